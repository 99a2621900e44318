//! Reads the .par files of SYMORO.

mod angles;
mod carried;
mod generic;
mod parameters;
mod read;
mod table;
mod text;
mod variables;

pub use read::read_par;
pub(in crate::format) use read::read_par_with;
