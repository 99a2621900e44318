//! Writes what was identified into the files that simulators read.

pub mod write_back;
