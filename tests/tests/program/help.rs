//! Snapshot tests of the help of every command, so that a review shows each change of an option.

use std::path::Path;
use std::process::Command;

use tests::program::{program, run};
use tests::snapshot::assert_snapshot;

/// The help as it is printed to a pipe. So it does not depend on the terminal in which the test runs.
fn help(words: &[&str]) -> String {
    let run = run(Command::new(program()).args(words).env_remove("COLUMNS").env_remove("LINES"));
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{words:?}");
    run.out
}

/// Names of the commands, read from the help of the program; the list ends at an empty line.
fn commands(program: &str) -> Vec<&str> {
    let listed = program.lines().skip_while(|line| *line != "Try it:").take_while(|line| !line.is_empty());
    let names = listed.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.filter_map(|line| line.split_whitespace().next()).collect()
}

#[test]
fn the_help_of_every_command_is_as_it_was() {
    let whole = help(&["--help"]);
    assert_snapshot("help/rist.txt", &whole);
    let commands = commands(&whole);
    assert!(commands.len() > 15, "{commands:?}");
    for command in &commands {
        let shown = help(&[command, "--help"]);
        assert_snapshot(&format!("help/{command}.txt"), &shown);
        assert_snapshot(&format!("help/{command}.all.txt"), &help(&[command, "--help-all"]));
        assert_eq!(help(&[command, "-h"]), shown);
    }
    // A stored help text whose command no longer exists is an error.
    let folder = tests::workspace().join("tests/data/help");
    for entry in std::fs::read_dir(&folder).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        let of = name.trim_end_matches(".txt").trim_end_matches(".all");
        assert!(of == "rist" || commands.contains(&of), "{}: no command has this help", Path::new(&name).display());
    }
}
