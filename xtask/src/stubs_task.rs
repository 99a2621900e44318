//! The tasks `stubs [--check]` and `notices [--check]`. `stubs` writes the documentation of request fields to the Python stubs
//! and to docs/files.md; `notices` writes THIRD_PARTY_NOTICES. With --check, they only compare.

use crate::cargo::cargo;

/// Runs the task as a separate program, because xtask is built without the output of `gen` and cannot read JSON.
pub(crate) fn run(task: &str, arguments: &[String]) -> Result<(), String> {
    let words = ["run", "--quiet", "--package", "tests", "--bin", task, "--"];
    cargo(&words.into_iter().chain(arguments.iter().map(String::as_str)).collect::<Vec<_>>())
}
