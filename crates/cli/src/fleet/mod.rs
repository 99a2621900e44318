//! Commands of the wing (optional package) `fleet`: accumulate, merge, solve, compare.
//!
//! A sum contains the regression rows of logs in triangular form (R of QR decompositions). These commands make sums from logs,
//! add them, compute an estimate from them, and compare them.

pub(crate) mod accumulate;
pub(crate) mod compare;
pub(crate) mod merge;
pub(crate) mod solve;

use std::path::Path;

use fleet::Accumulator;

use crate::failure::Failure;

/// Reads a file with the sums of logs.
fn read_sums(path: &Path) -> Result<Accumulator, Failure> {
    Ok(Accumulator::read(path)?)
}
