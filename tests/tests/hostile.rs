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
    let commands: [&[&str]; 7] = [
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
        let says_why = ["larger than 16 MiB", "binary file"].iter().any(|why| run.err.contains(why));
        assert!(says_why, "{command:?}: {}", run.err);
    }
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
