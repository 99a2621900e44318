//! A Module of Functions as source: one Rust file that needs no other.

mod numbers;
mod rust_file;
mod rust_function;

pub use rust_file::{index_file, rust_file};
