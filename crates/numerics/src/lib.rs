//! Matrices, transforms, intervals and distributions.
//!
//! A log becomes rows, and rows become a [`triangle`]: R, z, rho of a QR decomposition that never stores the rows. [`reflection`]
//! and [`row_block`] feed it; [`least_squares`], [`total_least_squares`] and [`information_matrix`] solve with it. [`interval`],
//! [`range`] and [`jet`] enclose the values of a function between two instants. [`fft`] and [`fourier`] transform, [`student`]
//! has the distributions of tests, and [`interruption`] ends long work.
//!
//! It knows the lanes of `generated`: the triangle takes eight samples in SIMD lanes, as a generated function writes them.
//!
//! Not here: robots, logs, parameters or units. A column is a number. Matrices that `nalgebra` handles well stay there.

#![warn(missing_docs)]

mod error;
pub mod fft;
pub mod fourier;
pub mod information_matrix;
pub mod interruption;
pub mod interval;
pub mod jet;
pub mod least_squares;
pub mod positive_definite;
pub mod range;
pub mod reflection;
pub mod row_block;
pub mod student;
pub mod total_least_squares;
pub mod triangle;
pub mod vector;

pub use error::Error;
