//! The hostile files with which the robustness of rist was tested (`../shared/findings/inputs/hardening`), and the command that
//! reads each file.
//!
//! Hostile files are made to crash a reader, or to exhaust time or memory.

use std::path::{Path, PathBuf};

/// The folder of the hostile files; `None` if ../shared does not exist.
pub fn hardening() -> Option<PathBuf> {
    crate::shared().map(|shared| shared.join("findings/inputs/hardening"))
}

/// The command that reads a file, with `{}` for the file. `None` for scripts that generate files, and for files that another file
/// includes.
///
/// `robot`, `motion`: the other files that a command needs, the arm p2.yaml and its motion m.yaml.
pub fn command(path: &Path, text: &str, robot: &str, motion: &str) -> Option<Vec<String>> {
    let of = |words: &[&str]| Some(words.iter().map(ToString::to_string).collect());
    let name = path.display().to_string();
    let (_, kind) = name.rsplit_once('.').unwrap_or((&name, ""));
    match kind {
        "gz" if name.ends_with(".tri.gz") => None,
        "csv" | "gz" | "mcap" | "npz" | "parquet" | "db3" | "arrow" | "arrows" | "feather" => {
            of(&["doctor", robot, "{}"])
        }
        "tri" => of(&["solve", "{}"]),
        "urdf" if path.parent().is_some_and(|folder| folder.ends_with("mesh")) => {
            of(&["excite", "{}", "--starts", "1", "--iterations", "2", "--rate", "50", "--out", "x.yaml"])
        }
        "urdf" | "par" | "xml" => of(&["inspect", "{}"]),
        "yaml" if text.contains("\nlinks:") => of(&["inspect", "{}"]),
        "yaml" if text.contains("period_s:") => of(&["check", robot, "{}"]),
        "yaml" if text.contains("sample_time_s:") => of(&["simulate", robot, "{}", "--out", "logs"]),
        "yaml" if text.contains("white_sigma:") => of(&["report", "--estimate", "{}", "--out", "x.html"]),
        "yaml" => of(&["check", robot, motion, "--limits", "{}"]),
        _ => None,
    }
}
