//! Runs commands for the tasks, and finds the folders of the repository and of its builds.
//!
//! A command is run as a separate process; if it fails, the task fails with a message.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs cargo as a separate process. xtask generates the sources of the crate `generated`, so it cannot be linked with this
/// crate.
pub(crate) fn cargo(arguments: &[&str]) -> Result<(), String> {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    done(Command::new(cargo).args(arguments), &format!("cargo {}", arguments.join(" ")))
}

/// Runs a command until it ends. Fails if the command fails. `what`: name of the command in the error message.
pub(crate) fn done(command: &mut Command, what: &str) -> Result<(), String> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{what} failed: {status}")),
        Err(e) => Err(format!("{what}: {e}")),
    }
}

/// The folder of the repository.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// The target folder of the workspace.
pub(crate) fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or(root().join("target"), PathBuf::from)
}

/// The target triple of this machine. It is passed as --target, because then the compiler flags do not apply to build scripts and
/// macros.
pub(crate) fn host() -> Result<String, String> {
    let output = Command::new("rustc").arg("-vV").output().map_err(|e| format!("rustc -vV: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().find_map(|line| line.strip_prefix("host: "));
    line.map(str::to_string).ok_or_else(|| "rustc -vV names no host".into())
}

/// The standard output of a command; empty if the command does not exist.
pub(crate) fn said(command: &mut Command) -> String {
    let output = command.output().map(|output| output.stdout).unwrap_or_default();
    String::from_utf8_lossy(&output).into_owned()
}
