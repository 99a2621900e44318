//! Runs the program `rist`, which this package contains. rist/_program.py calls it.

use std::ffi::OsString;
use std::panic::catch_unwind;
use std::path::PathBuf;

use pyo3::prelude::*;

use crate::error::OrError;

/// Exit code of a Rust program that ends by a panic.
const PANIC_EXIT_CODE: u8 = 101;

/// Runs the program with the words of a command line, and returns its exit code. Without the interpreter lock.
#[pyfunction]
pub fn _run_program(py: Python<'_>, words: Vec<OsString>) -> u8 {
    // If the program panics, its message is already on standard error.
    py.detach(|| catch_unwind(|| cli::run_program(words)).unwrap_or(PANIC_EXIT_CODE))
}

/// Writes a robot description and two logs of the robot into a directory, to try rist: ur5.urdf, log.csv and other.csv. Returns
/// their paths. Also writes poses.csv, measured poses for `rist.calibrate`, into the same directory.
///
/// >>> robot, log, other = rist.example()
/// >>> rist.identify(robot, log, validate=other)
#[pyfunction]
#[pyo3(signature = (directory=None), text_signature = "(directory='ur5')")]
pub fn example(directory: Option<PathBuf>) -> PyResult<Vec<PathBuf>> {
    let mut paths = rist::example::write_example(&directory.unwrap_or("ur5".into())).or_error()?;
    // Programs take the result apart as three paths; the poses are a later addition.
    paths.truncate(3);
    Ok(paths)
}
