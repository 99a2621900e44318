//! `stubs [--check]`: writes (or compares) the documentation of request fields in the Python stubs and docs/files.md. `notices
//! [--check]`: writes (or compares) THIRD_PARTY_NOTICES.

use crate::cargo::cargo;

/// Runs the task as a separate program: xtask is built without the output of `gen`, and cannot read JSON.
pub(crate) fn run(task: &str, arguments: &[String]) -> Result<(), String> {
    let words = ["run", "--quiet", "--package", "tests", "--bin", task, "--"];
    cargo(&words.into_iter().chain(arguments.iter().map(String::as_str)).collect::<Vec<_>>())
}
