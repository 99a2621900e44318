//! The task `fuzz SECONDS`: builds the programs of fuzz/ with coverage by the stable compiler, and runs each of them for an equal
//! share of the time.
//!
//! cargo-fuzz needs a nightly compiler for one flag. Here the LLVM pass behind this flag is selected by its name. The initial
//! inputs are only read: the corpora, and hostile files from security tests if they exist (../shared/findings/inputs/hardening).
//! New inputs are stored in target/fuzz/corpus, and inputs that crash a program in target/fuzz/found.
//!
//! The last step runs without coverage: it changes each file that the program can read at random, and runs the program with the
//! changed file (tests/src/mutation.rs).
//!
//! Not covered: folders of rosbag2, and the Python package.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::cargo::{cargo, done, host, root, target};

/// The programs in fuzz/targets, each with the folders of its initial inputs.
const TARGETS: [(&str, &[&str]); 8] = [
    ("robots", &["fuzz/corpus/robots", "models", "crates/robot/testdata"]),
    ("derive", &["fuzz/corpus/robots", "models", "crates/robot/testdata"]),
    ("write_back", &["fuzz/corpus/write_back", "fuzz/corpus/robots"]),
    ("meshes", &["fuzz/corpus/meshes"]),
    ("logs", &["fuzz/corpus/logs"]),
    ("identify", &["fuzz/corpus/identify"]),
    ("sums", &["fuzz/corpus/sums"]),
    ("artefacts", &["fuzz/corpus/artefacts"]),
];

/// Compiler flags for coverage: counters of edges, and operands of comparisons.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                        -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
                        -Cllvm-args=-sanitizer-coverage-pc-table \
                        -Cllvm-args=-sanitizer-coverage-trace-compares";

/// Limits: time for an input, s; memory and size of one allocation, MiB; length of an input, bytes. An input that exceeds the
/// time or the memory is a finding. The slowest work, an estimate with physically consistent bodies, takes 0.3 s in a release
/// build, and a hundred times longer with coverage on a shared machine. Inputs longer than 8 KiB find nothing more in the
/// available time.
///
/// The readers of rist may use 64 times the size of an input plus 64 MiB (its budget). No reader allocates more than twice this
/// budget at once.
const LIMITS: [&str; 4] = ["-timeout=60", "-rss_limit_mb=2048", "-malloc_limit_mb=128", "-max_len=8192"];

pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    let usage = "expected are the seconds of all targets together: cargo xtask fuzz 600";
    let [seconds] = arguments else { return Err(usage.into()) };
    let seconds: u64 = seconds.parse().ok().filter(|s| *s > 0).ok_or(usage)?;
    let (root, target, host) = (root(), target().join("fuzz"), host()?);
    let mut build = Command::new("cargo");
    build.args(["build", "--bins", "--locked", "--target", &host, "--manifest-path", "fuzz/Cargo.toml"]);
    build.current_dir(root).env("CARGO_TARGET_DIR", &target).env("RUSTFLAGS", COVERAGE);
    done(&mut build, "cargo build of fuzz/")?;

    // The time is divided equally between the targets and the mutations.
    let found = target.join("found");
    fs::create_dir_all(&found).map_err(|e| format!("{}: {e}", found.display()))?;
    let share = seconds.div_ceil(1 + TARGETS.len() as u64);
    let mut broken = Vec::new();
    for (name, folders) in TARGETS {
        let corpus = target.join("corpus").join(name);
        fs::create_dir_all(&corpus).map_err(|e| format!("{}: {e}", corpus.display()))?;
        let mut fuzz = Command::new(target.join(&host).join("debug").join(name));
        fuzz.arg(format!("-max_total_time={share}")).args(LIMITS);
        fuzz.arg(format!("-artifact_prefix={}/{name}-", found.display()));
        fuzz.args(["-print_final_stats=1", "-verbosity=0", "-print_funcs=0"]).arg(&corpus);
        println!("== {name}");
        let attacks = root.join("../shared/findings/inputs/hardening");
        if attacks.is_dir() {
            fuzz.arg(attacks);
        }
        if done(fuzz.args(folders).current_dir(root), name).is_err() {
            broken.push(name);
        }
    }
    // The last part changes files at random and runs the program `rist` itself, without coverage.
    println!("== mutations");
    if mutations(share, &found).is_err() {
        broken.push("mutations");
    }
    match broken.is_empty() {
        true => Ok(()),
        false => Err(format!("{}: an input breaks it; it is in {}", broken.join(", "), found.display())),
    }
}

/// Runs the program on files that are changed at random.
fn mutations(seconds: u64, found: &Path) -> Result<(), String> {
    cargo(&["build", "--quiet", "--release", "--package", "cli"])?;
    let program = target().join("release").join(format!("rist{}", std::env::consts::EXE_SUFFIX));
    let (program, found) = (program.display().to_string(), found.display().to_string());
    let words = ["run", "--quiet", "--release", "--package", "tests", "--bin", "mutations", "--"];
    cargo(&[&words[..], &[&program, &seconds.to_string(), &found]].concat())
}
