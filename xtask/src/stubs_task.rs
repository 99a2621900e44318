//! `stubs [--check]`: writes, or compares, what Python and docs/files.md say of the fields of requests.

use crate::cargo::cargo;

/// In a program of its own: this one is built without what `gen` writes.
pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    let words = ["run", "--quiet", "--package", "tests", "--bin", "stubs", "--"];
    cargo(&words.into_iter().chain(arguments.iter().map(String::as_str)).collect::<Vec<_>>())
}
