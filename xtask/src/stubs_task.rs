//! `stubs [--check]`: writes, or compares, what Python and docs/files.md say of the fields of requests.
//! `notices [--check]`: the same of THIRD_PARTY_NOTICES.

use crate::cargo::cargo;

/// Each in a program of its own: this one is built without what `gen` writes, and reads no JSON.
pub(crate) fn run(task: &str, arguments: &[String]) -> Result<(), String> {
    let words = ["run", "--quiet", "--package", "tests", "--bin", task, "--"];
    cargo(&words.into_iter().chain(arguments.iter().map(String::as_str)).collect::<Vec<_>>())
}
