//! Writes a Module of Functions as source code: one Rust file that needs no other file, or a C99 header and source.

#![warn(missing_docs)]

mod c;
mod c_sine;
mod controller;
mod monitor;
mod numbers;
mod rust_file;
mod rust_function;
mod sine;
pub mod steps;

pub use c::{CFiles, c_files};
pub use monitor::{FrictionColumn, Monitor};
pub use rust_file::{index_file, rust_file};
