//! A Function as Rust source, and a robot's functions as one file.

mod function;
mod numbers;
mod robot_file;

pub use function::render;
pub use robot_file::{RobotFile, index_file, robot_file};
