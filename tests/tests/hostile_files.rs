//! The files by which rist was attacked, each with its outcome: read, refused or said. None ends in a panic, a signal or a
//! hang, and each stays in the memory that its size allows.
#![cfg(unix)]

use std::path::{Path, PathBuf};

use tests::mutation::{bounded, broken};
use tests::program::{folder, program};
use tests::snapshot::assert_snapshot;

/// Every file below a folder, in the order of the names.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() { files(&path, found) } else { found.push(path) }
    }
}

/// The command that reads a file; none of those that make others, or that another names.
fn command(path: &str, text: &str, robot: &str, motion: &str) -> Option<Vec<String>> {
    let of = |words: &[&str]| Some(words.iter().map(ToString::to_string).collect());
    let (_, kind) = path.rsplit_once('.').unwrap_or((path, ""));
    match kind {
        "csv" | "gz" if path.ends_with(".tri.gz") => None,
        "csv" | "gz" | "mcap" | "npz" | "parquet" | "db3" => of(&["doctor", robot, path]),
        "tri" => of(&["solve", path]),
        "urdf" if path.contains("/mesh/") => {
            of(&["excite", path, "--starts", "1", "--iterations", "2", "--rate", "50", "--out", "x.yaml"])
        }
        "urdf" | "par" | "xml" => of(&["inspect", path]),
        "yaml" if text.contains("\nlinks:") => of(&["inspect", path]),
        "yaml" if text.contains("period_s:") => of(&["check", robot, path]),
        "yaml" if text.contains("sample_time_s:") => of(&["simulate", robot, path, "--out", "logs"]),
        "yaml" if text.contains("white_sigma:") => of(&["report", "--estimate", path, "--out", "x.html"]),
        "yaml" => of(&["check", robot, motion, "--limits", path]),
        _ => None,
    }
}

#[test]
fn each_file_is_read_refused_or_said() {
    let Some(shared) = tests::shared() else { return };
    let all = shared.join("findings/inputs/hardening");
    let here = folder("hostile-files");
    let (robot, motion) = (all.join("tamper/p2.yaml"), all.join("tamper/m.yaml"));
    let (robot, motion) = (robot.display().to_string(), motion.display().to_string());
    let (mut paths, mut told, mut beyond) = (Vec::new(), String::new(), Vec::new());
    files(&all, &mut paths);
    for path in paths {
        let name = path.strip_prefix(&all).unwrap().display().to_string();
        let bytes = std::fs::read(&path).unwrap();
        let shown = path.display().to_string();
        let Some(words) = command(&shown, &String::from_utf8_lossy(&bytes), &robot, &motion) else {
            told += &format!("{name}: no input of its own\n");
            continue;
        };
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let run = bounded(program(), &here, bytes.len(), &words);
        if let Some(outcome) = broken(&run) {
            beyond.push(format!("{name}: {outcome}"));
        }
        let outcome = match run.code {
            Some(0) => "read",
            Some(1) => "read, and the answer is no",
            _ => "refused",
        };
        let why = run.err.lines().rfind(|line| line.starts_with("rist:")).unwrap_or_default();
        let why: String = why.replace(&all.display().to_string(), "").chars().take(160).collect();
        told += format!("{name}: {outcome}: {why}").trim_end_matches([':', ' ']);
        told.push('\n');
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
    assert_snapshot("hostile/outcomes.txt", &told);
}
