//! Runs the program on files that are changed at random.
//!
//! Rule: for any file, the program ends normally with the code 0, 1 or 2, within [`SECONDS`] of processor time and within an
//! address space that depends on the size of the file. A signal, an abort, a panic or another code is a finding.

use std::path::Path;
use std::process::Command;

use crate::hostile::{command, hardening};
use crate::program::{LIMITED_ARM, Run, run};
use crate::random::Random;
use crate::workspace;

/// Limit of the processor time of a run, s, for `xtask fuzz`. Tests use a program that is hardly optimised, so there the limit
/// only detects endless loops.
pub const SECONDS: usize = if cfg!(debug_assertions) { 10 } else { 2 };

/// Address space for a run of the program without a file, KiB. The program and its threads use about 300 MiB.
const SPACE_KIB: usize = 512 << 10;

/// Additional address space for a file of this size, KiB: twice (64 times its size plus 64 MiB). The factor two is for commands
/// that read a file and write one.
fn allowance_kib(bytes: usize) -> usize {
    2 * (64 * bytes).div_ceil(1024) + 2 * (64 << 10)
}

/// A file that is changed at random, and the commands that read it. `{}` in a command stands for the file.
pub struct Seed {
    /// Name of the file. The program recognises the format by the extension of the name.
    pub name: String,
    pub bytes: Vec<u8>,
    pub commands: Vec<Vec<String>>,
    /// For each command, its probability to be run when it is selected, in thousandths. Slow commands are run less often
    /// ([`by_time`]).
    pub odds: Vec<usize>,
}

/// A run of the program that broke the rule of this module.
pub struct Finding {
    pub name: String,
    pub bytes: Vec<u8>,
    pub command: Vec<String>,
    /// How the run ended, and the last lines of its output.
    pub outcome: String,
}

/// Runs the program in `folder`, with the limits for a file of this number of bytes.
pub fn bounded(program: &Path, folder: &Path, bytes: usize, arguments: &[&str]) -> Run {
    let limits = format!("ulimit -v {}; ulimit -t {SECONDS}; exec \"$@\"", SPACE_KIB + allowance_kib(bytes));
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(limits).arg("sh").arg(program).args(arguments).current_dir(folder);
    // A backtrace needs much time and memory and gives no more information, so it is disabled.
    run(shell.env("RUST_BACKTRACE", "0"))
}

/// Why a run breaks the rule of this module; `None` if it does not.
pub fn broken(run: &Run) -> Option<String> {
    let last = run.err.lines().rev().take(3).collect::<Vec<_>>().join(" | ");
    match run.code {
        Some(0..=2) if !run.err.contains("panicked at") => None,
        Some(code) => Some(format!("code {code}: {last}")),
        None => Some(format!("a signal: {last}")),
    }
}

fn seed(folder: &Path, file: &str, commands: &[&[&str]]) -> Seed {
    let words = |command: &&[&str]| command.iter().map(ToString::to_string).collect();
    Seed {
        name: file.rsplit('/').next().unwrap_or(file).into(),
        bytes: std::fs::read(folder.join(file)).unwrap_or_else(|e| panic!("{file}: {e}")),
        commands: commands.iter().map(words).collect(),
        odds: vec![1000; commands.len()],
    }
}

/// Starting a process takes about this time, s. A command that needs no longer is always run.
const CHEAP_SECONDS: f64 = 0.015;

/// Measures each command once on the unchanged file, and makes its probability inversely proportional to this time. So each
/// command gets about the same share of the time, and a few slow commands do not delay the many fast ones.
pub fn by_time(program: &Path, folder: &Path, seeds: &mut [Seed]) {
    for seed in seeds {
        std::fs::write(folder.join(mutant(&seed.name)), &seed.bytes).expect("a folder of ours is writable");
        for (command, odds) in seed.commands.iter().zip(&mut seed.odds) {
            let start = std::time::Instant::now();
            attempt(program, folder, seed.bytes.len(), &mutant(&seed.name), command);
            let share = CHEAP_SECONDS / start.elapsed().as_secs_f64().max(CHEAP_SECONDS);
            *odds = (1000.0 * share).ceil() as usize;
        }
    }
}

fn attempt(program: &Path, folder: &Path, bytes: usize, file: &str, command: &[String]) -> Run {
    let arguments: Vec<&str> = command.iter().map(|word| if word == "{}" { file } else { word }).collect();
    bounded(program, folder, bytes, &arguments)
}

/// All files to be changed: the files that the program writes in `folder`, the inputs of the fuzz targets in `fuzz`, and hostile
/// files from security tests.
pub fn seeds(program: &Path, folder: &Path) -> Vec<Seed> {
    let mut all = written(program, folder);
    all.extend(corpora(folder));
    all.extend(attacks(folder));
    all
}

fn make(program: &Path, folder: &Path) {
    let steps: [&[&str]; 11] = [
        &["excite", "arm.yaml", "--limits", "limits.yaml", "--starts", "1", "--rate", "100", "--out", "motion.yaml"],
        &["simulate", "arm.yaml", "motion.yaml", "--out", "logs"],
        &["identify", "arm.yaml", "logs/motion.csv", "--out", "estimate.yaml"],
        &["validate", "arm.yaml", "estimate.yaml", "logs/motion.csv", "--out", "validation.yaml"],
        &["plan", "arm.yaml", "-n", "2", "--duration", "1", "--rate", "100", "--out", "plan.yaml"],
        &["accumulate", "arm.yaml", "logs/motion.csv", "--out", "sums.tri"],
        &["simulate", "arm.yaml", "motion.yaml", "--seed", "2", "--validation", "0", "--out", "other"],
        &["accumulate", "arm.yaml", "other/motion.csv", "--like", "sums.tri", "--out", "other.tri"],
        &["compare", "sums.tri", "other.tri", "--out", "comparison.yaml"],
        &["excite", "arm.urdf", "--starts", "1", "--rate", "100", "--out", "urdf_motion.yaml"],
        &["simulate", "arm.urdf", "urdf_motion.yaml", "--out", "urdf_logs"],
    ];
    for step in steps {
        let run = run(Command::new(program).args(step).current_dir(folder));
        assert!(matches!(run.code, Some(0 | 1)), "{step:?}: {}", run.err);
    }
}

/// The files that the program writes on its way from a description to sums of logs.
pub fn written(program: &Path, folder: &Path) -> Vec<Seed> {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("a folder of ours is writable");
    write("arm.yaml", LIMITED_ARM);
    write("limits.yaml", "all: {velocity: 3, acceleration: 20}\nspace: {floor: -2}\n");
    write("load.yaml", "link: forearm\nmass: 0.5\ncentre_of_mass: [0.1, 0, 0]\n");
    write("options.yaml", "friction: [viscous, coulomb, offset]\nsignal: {cutoff: 8}\nweights: huber\n");
    write("states.csv", "q1,q2,dq1,dq2,ddq1,ddq2\n0.1,0.2,0.3,0.4,0.5,0.6\n-1,1,-1,1,-1,1\n");
    // A robot whose inertial parameters are written to an MJCF, and a log of it.
    let corpus = workspace().join("fuzz/corpus/write_back");
    for file in ["arm.urdf", "arm.xml"] {
        write(file, &std::fs::read_to_string(corpus.join(file)).expect("the corpora are there"));
    }
    make(program, folder);
    let log = "logs/motion.csv";
    let identify = ["identify", "arm.urdf", "urdf_logs/motion.csv", "--anyway", "--write-mjcf", "z", "--into", "{}"];
    let estimate: [&[&str]; 6] = [
        &["validate", "arm.yaml", "{}", log],
        &["report", "--estimate", "{}", "--out", "x"],
        &["generate", "arm.yaml", "--estimate", "{}", "--out", "x"],
        &["check", "arm.yaml", "motion.yaml", "--after", "{}"],
        &["excite", "arm.yaml", "--starts", "1", "--iterations", "1", "--rate", "50", "--after", "{}", "--out", "x"],
        &["simulate", "arm.yaml", "motion.yaml", "--feedforward", "{}", "--validation", "0", "--out", "y"],
    ];
    let robot: [&[&str]; 4] = [
        &["inspect", "{}"],
        &["excite", "{}", "--starts", "1", "--iterations", "2", "--out", "x"],
        &["convert", "{}", "--to", "urdf"],
        &["lint", "{}"],
    ];
    let motion: [&[&str]; 4] = [
        &["check", "arm.yaml", "{}"],
        &["simulate", "arm.yaml", "{}", "--validation", "0", "--out", "y"],
        &["report", "--motion", "{}", "--out", "x"],
        &["report", "--motion", "{}", "--model", "arm.yaml", "--out", "x"],
    ];
    let plan: [&[&str]; 3] = [
        &["check", "arm.yaml", "{}"],
        &["simulate", "arm.yaml", "{}", "--validation", "0", "--out", "y"],
        &["report", "--plan", "{}", "--out", "x"],
    ];
    let of = |file: &str, commands: &[&[&str]]| seed(folder, file, commands);
    vec![
        of("arm.yaml", &robot),
        of("arm.xml", &[&identify]),
        of("states.csv", &[&["evaluate", "arm.yaml", "{}", "--quantity", "torque"]]),
        of("limits.yaml", &[&["check", "arm.yaml", "motion.yaml", "--limits", "{}"]]),
        of("load.yaml", &[&["simulate", "arm.yaml", "motion.yaml", "--load", "{}", "--out", "y"]]),
        of("options.yaml", &[&["identify", "arm.yaml", log, "--options", "{}"]]),
        of("motion.yaml", &motion),
        of("plan.yaml", &plan),
        // Files that only the library reads have no command.
        of("comparison.yaml", &[]),
        of("estimate.yaml", &estimate),
        of("validation.yaml", &[&["report", "--validation", "{}", "--out", "x"]]),
        of("sums.tri", &[&["merge", "{}", "--out", "x"], &["solve", "{}"]]),
        of(log, &[&["identify", "arm.yaml", "{}"], &["doctor", "arm.yaml", "{}"]]),
    ]
}

/// The inputs of the fuzz targets in `fuzz`. A mesh is read through a URDF that refers to it.
fn corpora(folder: &Path) -> Vec<Seed> {
    let mut all = Vec::new();
    for (corpus, command) in [
        ("logs", &["doctor", "arm.yaml", "{}"][..]),
        ("robots", &["inspect", "{}"]),
        ("write_back", &["inspect", "{}"]),
        ("sums", &["solve", "{}"]),
        ("meshes", &[]),
    ] {
        let corpus = workspace().join("fuzz/corpus").join(corpus);
        for path in crate::files_below(&corpus) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let robot = format!("{name}.urdf");
            let of_mesh = ["excite", &robot, "--starts", "1", "--iterations", "1", "--rate", "50", "--out", "x"];
            if command.is_empty() {
                std::fs::write(folder.join(&robot), with_mesh(&mutant(&name))).expect("a folder of ours is writable");
            }
            all.push(seed(&corpus, &name, &[if command.is_empty() { &of_mesh } else { command }]));
        }
    }
    all
}

/// A URDF with one link, whose collision shape is this mesh.
fn with_mesh(mesh: &str) -> String {
    format!(
        "<robot name=\"r\"><link name=\"base\"/><link name=\"l\"><inertial><origin xyz=\"0.1 0 0\"/><mass value=\"2\"/>\
         <inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/></inertial><collision><geometry>\
         <mesh filename=\"{mesh}\"/></geometry></collision></link><joint name=\"j\" type=\"revolute\">\
         <parent link=\"base\"/><child link=\"l\"/><origin xyz=\"0 0 3\"/><axis xyz=\"0 1 0\"/>\
         <limit lower=\"-2\" upper=\"2\" effort=\"100\" velocity=\"5\"/></joint></robot>"
    )
}

/// Hostile files with more bytes are skipped, because each would take the time of many others. Another test reads all of them.
const MAX_ATTACK_BYTES: usize = 1 << 16;

/// The hostile files from security tests, and the other files that their commands need.
fn attacks(folder: &Path) -> Vec<Seed> {
    let Some(hardening) = hardening() else { return Vec::new() };
    let beside = |name: &str| hardening.join("tamper").join(name).display().to_string();
    let (robot, motion) = (beside("p2.yaml"), beside("m.yaml"));
    let mut all = Vec::new();
    for path in crate::files_below(&hardening) {
        let bytes = std::fs::read(&path).expect("a file of ../shared is read");
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match command(&path, &String::from_utf8_lossy(&bytes), &robot, &motion) {
            Some(command) if bytes.len() <= MAX_ATTACK_BYTES => {
                all.push(Seed { name, bytes, commands: vec![command], odds: vec![1000] });
            }
            // Meshes are written next to the descriptions that refer to them.
            None if bytes.len() <= MAX_ATTACK_BYTES => {
                std::fs::write(folder.join(name), bytes).expect("a folder of ours is writable");
            }
            _ => {}
        }
    }
    all
}

fn mutant(name: &str) -> String {
    format!("mutant-{name}")
}

/// Numbers and words with which readers had errors in the past.
const WORDS: [&str; 18] = [
    "nan",
    ".inf",
    "-1",
    "0",
    "1e308",
    "-1e308",
    "1e-320",
    "4294967296",
    "9223372036854775807",
    "1e6",
    "[]",
    "{}",
    "\"\"",
    "*a",
    "\u{202e}",
    "\u{1b}[31m",
    "\0",
    "-0.0",
];

/// The bytes with up to four random changes.
pub fn mutated(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len().max(1)).min(bytes.len());
        let end = bytes.len().min(at + 1 + random.below(40));
        match random.below(8) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
            1 if !bytes.is_empty() => bytes[at] = random.below(256) as u8,
            2 => drop(bytes.drain(at..end)),
            3 => {
                let copy = bytes[at..end].to_vec();
                let place = random.below(bytes.len() + 1);
                bytes.splice(place..place, copy);
            }
            4 => bytes.truncate(at),
            5 => {
                // Duplicates or removes a line.
                let start = bytes[..at].iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1);
                let end = bytes[at..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |k| at + k + 1);
                let line = bytes[start..end].to_vec();
                if random.below(2) == 0 {
                    drop(bytes.drain(start..end))
                } else {
                    drop(bytes.splice(start..start, line))
                }
            }
            _ => {
                // Replaces a number by another one.
                let is_digit = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'e');
                let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|k| at + k) else { continue };
                let end = bytes[start..].iter().position(|b| !is_digit(b)).map_or(bytes.len(), |k| start + k);
                bytes.splice(start..end, WORDS[random.below(WORDS.len())].bytes());
            }
        }
    }
    bytes
}

/// Runs the program on randomly changed files until `is_enough` (given the number of runs) is true. Returns the runs that broke
/// the rule of this module.
pub fn hunt(
    program: &Path,
    folder: &Path,
    seeds: &[Seed],
    random: &mut Random,
    is_enough: impl Fn(usize) -> bool,
) -> (usize, Vec<Finding>) {
    let (mut count, mut found) = (0, Vec::new());
    while !is_enough(count) {
        let seed = &seeds[random.below(seeds.len())];
        if seed.commands.is_empty() {
            continue;
        }
        let drawn = random.below(seed.commands.len());
        if random.below(1000) >= seed.odds[drawn] {
            continue;
        }
        let command = &seed.commands[drawn];
        let bytes = mutated(&seed.bytes, random);
        let name = mutant(&seed.name);
        std::fs::write(folder.join(&name), &bytes).expect("a folder of ours is writable");
        let run = attempt(program, folder, bytes.len(), &name, command);
        count += 1;
        if let Some(outcome) = broken(&run) {
            found.push(Finding { name, bytes, command: command.clone(), outcome });
        }
    }
    (count, found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_knows_a_panic_from_a_refusal() {
        let of = |code, err: &str| broken(&Run { code, err: err.into(), ..Run::default() });
        assert!(of(Some(2), "rist: no").is_none() && of(Some(0), "").is_none() && of(Some(1), "").is_none());
        assert!(of(Some(101), "x").is_some() && of(None, "").is_some());
        assert!(of(Some(2), "thread 'a' panicked at b").is_some());
    }

    #[test]
    fn mutants_differ_and_repeat_by_their_seed() {
        let of = |seed| mutated(b"a: 1.5\nb: [2, 3]\n", &mut Random(seed));
        assert_eq!(of(1), of(1));
        let different: std::collections::BTreeSet<Vec<u8>> = (0..100).map(of).collect();
        assert!(different.len() > 80, "{}", different.len());
        assert!((0..100).all(|seed| mutated(b"", &mut Random(seed)).len() < 100));
    }
}
