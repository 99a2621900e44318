//! Numerical methods: matrices, transforms, intervals and distributions.
//!
//! A log becomes rows, and rows become a [`triangle`]: R, z, rho of a QR decomposition that does not store the rows.
//! [`reflection`] and [`row_block`] compute it. [`least_squares`], [`total_least_squares`] and [`information_matrix`] solve
//! linear systems. [`interval`], [`range`] and [`jet`] enclose the values of a function between two instants. [`fft`] and
//! [`fourier`] transform signals, [`student`] has the distributions of tests, and [`interruption`] ends long work.
//!
//! It depends on the type `Eight` of `generated`: a triangle takes eight samples in SIMD lanes, as a generated function writes
//! them.
//!
//! It does not know robots, logs, parameters or units: a column is an array of numbers. For matrices that `nalgebra` handles
//! well, `nalgebra` is used directly.

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
