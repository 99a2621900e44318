//! Files without end, or made to be slow: refused with a message, in bounded memory.
#![cfg(unix)]

use std::path::Path;
use std::process::Command;

use tests::model_path;
use tests::program::{Run, folder, program};

/// Address space of a run, KiB: the program and its threads map some 300 MiB, whatever they read.
const SPACE: usize = 1 << 20;

/// Runs the program with bounded memory; without the bound, what does not end would take the machine's.
fn bounded(folder: &Path, arguments: &[&str]) -> Run {
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(format!("ulimit -v {SPACE}; exec \"$@\"")).arg("sh").arg(program()).args(arguments);
    tests::program::run(shell.current_dir(folder))
}

#[test]
fn files_without_end_are_refused() {
    let here = folder("hostile-endless");
    let planar = model_path("planar2r_vertical.yaml");
    let planar = planar.to_str().unwrap();
    std::fs::write(here.join("log.csv"), "t,q1,q2,tau1,tau2\n0,0,0,0,0\n").unwrap();
    std::os::unix::fs::symlink("/dev/zero", here.join("endless.yaml")).unwrap();
    let commands: [&[&str]; 8] = [
        &["merge", "/dev/zero", "--out", "x.tri"],
        &["inspect", "endless.yaml"],
        &["identify", planar, "/dev/zero"],
        &["identify", planar, "log.csv", "--options", "endless.yaml"],
        &["validate", planar, "endless.yaml", "log.csv"],
        &["simulate", planar, "endless.yaml", "--out", "logs"],
        &["report", "--estimate", "endless.yaml", "--out", "report.html"],
        &["check", planar, "endless.yaml"],
    ];
    for command in commands {
        let run = bounded(&here, command);
        assert_eq!(run.code, Some(2), "{command:?}: {}", run.err);
        let says_why =
            ["larger than 16 MiB", "binary file", "no sums of rist accumulate"].iter().any(|why| run.err.contains(why));
        assert!(says_why, "{command:?}: {}", run.err);
    }
}

/// Strings that claim 4 GiB in files of some bytes: the process is not to end by an allocation that fails.
#[test]
fn strings_of_a_recording_are_not_believed() {
    let here = folder("hostile-claims");
    let planar = model_path("planar2r_vertical.yaml");
    let claims: [&[u8]; 3] = [
        b"\x03\x06\0\0\0\0\0\0\0\x01\0\xff\xff\xff\xff",
        b"\x04\x08\0\0\0\0\0\0\0\x01\0\x01\0\xff\xff\xff\xff",
        b"\x06\x20\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff",
    ];
    for record in claims {
        std::fs::write(here.join("claim.mcap"), [b"\x89MCAP0\r\n", record].concat()).unwrap();
        let run = bounded(&here, &["doctor", planar.to_str().unwrap(), "claim.mcap"]);
        assert_eq!(run.code, Some(2), "{}", run.err);
        assert!(run.err.contains("a string claims 4294967295 bytes"), "{}", run.err);
    }
}

/// The line of a fault in a pipe is not looked for: whoever opens a pipe without a writer waits for ever.
#[test]
fn a_fault_in_a_pipe_is_told() {
    let here = folder("hostile-pipe");
    let text = "(printf 'convention: khalil-kleinfinger\nnam: x\n' > f.yaml &); exec timeout 20 \"$0\" inspect f.yaml";
    let made = Command::new("mkfifo").arg(here.join("f.yaml")).status().unwrap();
    assert!(made.success());
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(text).arg(program());
    let run = tests::program::run(shell.current_dir(&here));
    assert!(run.code == Some(2) && run.err.contains("f.yaml:2"), "{:?}: {}", run.code, run.err);
}

/// A step of a motion is filled with those of the controller, so a slow rate is a claim for memory.
#[test]
fn a_slow_rate_is_refused() {
    let here = folder("hostile-rate");
    let planar = model_path("planar2r_vertical.yaml");
    let planar = planar.to_str().unwrap();
    let run = tests::program::rist(&here, &["excite", planar, "--out", "motion.yaml"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let text = std::fs::read_to_string(here.join("motion.yaml")).unwrap();
    let slow = |line: &str| if line.starts_with("rate_hz:") { "rate_hz: 1e-6".into() } else { line.to_string() };
    let slow: Vec<String> = text.lines().map(slow).collect();
    std::fs::write(here.join("slow.yaml"), slow.join("\n")).unwrap();
    let run = bounded(&here, &["simulate", planar, "slow.yaml", "--out", "logs"]);
    assert_eq!(run.code, Some(2), "{}", run.err);
    assert!(run.err.contains("a controller has 1 to 20000 Hz"), "{}", run.err);
}

/// What a terminal would take for a command is shown as what it is, in messages too.
#[test]
fn names_are_shown_as_what_they_are() {
    let here = folder("hostile-names");
    let run = bounded(&here, &["inspect", "a\u{1b}]0;x\u{202e}.yaml", "--color", "always"]);
    assert_eq!(run.code, Some(2));
    assert!(run.err.contains("a\\u{1b}]0;x\\u{202e}.yaml"), "{:?}", run.err);
}

#[test]
fn an_element_of_countless_attributes_is_refused_where_it_stands() {
    let here = folder("hostile-attributes");
    let attributes: String = (0..100_000).map(|k| format!(" a{k}=\"1\"")).collect();
    std::fs::write(here.join("crowded.urdf"), format!("<robot name=\"r\">\n<link{attributes}/></robot>")).unwrap();
    let run = bounded(&here, &["inspect", "crowded.urdf"]);
    assert_eq!(run.code, Some(2));
    let lines: Vec<&str> = run.err.lines().collect();
    let [message, excerpt] = lines[..] else { panic!("{}", run.err) };
    assert_eq!(message, "rist: crowded.urdf:2: <link> has more than 256 attributes: no element of a URDF has");
    assert!(excerpt.starts_with(" 2 | <link a0=\"1\"") && excerpt.len() < 120, "{excerpt}");
}
