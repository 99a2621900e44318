//! `fuzz SECONDS`: builds the targets of fuzz/ with coverage, on stable, and runs each for its share of the time.
//!
//! cargo-fuzz needs a nightly compiler for one flag; LLVM's pass behind it is had by name. The corpora of fuzz/corpus are only
//! read; what is found on the way stays in target/fuzz, and an input that breaks a target in target/fuzz/found.

use std::fs;
use std::path::Path;
use std::process::Command;

/// The programs of fuzz/targets, each with a folder of fuzz/corpus.
const TARGETS: [&str; 4] = ["robots", "logs", "artefacts", "identify"];

/// Coverage by counters of edges, and by what is compared with what.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                        -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
                        -Cllvm-args=-sanitizer-coverage-pc-table \
                        -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=16";

/// An input that takes longer, s, or more memory, MiB, is a finding.
const LIMITS: [&str; 3] = ["-timeout=20", "-rss_limit_mb=2048", "-max_len=8192"];

pub fn run(arguments: &[String]) -> Result<(), String> {
    let usage = "expected the seconds of all targets together: cargo xtask fuzz 600";
    let [seconds] = arguments else { return Err(usage.into()) };
    let seconds: u64 = seconds.parse().ok().filter(|s| *s > 0).ok_or(usage)?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    let target = root.join("target/fuzz");
    let host = host()?;
    let mut build = Command::new("cargo");
    // With --target the flags are not those of build scripts, which have no fuzzer to report to.
    build.args(["build", "--bins", "--locked", "--target", &host, "--manifest-path", "fuzz/Cargo.toml"]);
    build.current_dir(root).env("CARGO_TARGET_DIR", &target).env("RUSTFLAGS", COVERAGE);
    done(&mut build, "cargo build of fuzz/")?;

    let found = target.join("found");
    fs::create_dir_all(&found).map_err(|e| format!("{}: {e}", found.display()))?;
    let mut broken = Vec::new();
    for name in TARGETS {
        let corpus = target.join("corpus").join(name);
        fs::create_dir_all(&corpus).map_err(|e| format!("{}: {e}", corpus.display()))?;
        let mut fuzz = Command::new(target.join(&host).join("debug").join(name));
        fuzz.arg(format!("-max_total_time={}", seconds.div_ceil(TARGETS.len() as u64))).args(LIMITS);
        fuzz.arg(format!("-artifact_prefix={}/{name}-", found.display()));
        fuzz.args(["-print_final_stats=1", "-verbosity=0"]).arg(&corpus).arg(root.join("fuzz/corpus").join(name));
        println!("== {name}");
        if done(&mut fuzz, name).is_err() {
            broken.push(name);
        }
    }
    match broken.is_empty() {
        true => Ok(()),
        false => Err(format!("{}: an input breaks it; it is in {}", broken.join(", "), found.display())),
    }
}

/// The triple of this machine.
fn host() -> Result<String, String> {
    let output = Command::new("rustc").arg("-vV").output().map_err(|e| format!("rustc -vV: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().find_map(|line| line.strip_prefix("host: "));
    line.map(str::to_string).ok_or_else(|| "rustc -vV names no host".into())
}

fn done(command: &mut Command, what: &str) -> Result<(), String> {
    let status = command.status().map_err(|e| format!("{what}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{what} failed: {status}")) }
}
