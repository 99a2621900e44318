//! Numerical methods: matrices, transforms, intervals and distributions.
//!
//! A log gives equations W x = y, with one row per sample and joint. A [`triangle`] is the part R, z, rho of the QR decomposition
//! [W y] = Q [R z; 0 rho]; it is updated row by row, and the rows are not stored. [`reflection`] and [`row_block`] compute the
//! triangle. [`least_squares`], [`total_least_squares`] and [`information_matrix`] solve linear systems. [`interval`], [`range`]
//! and [`jet`] enclose the values of a function between two instants. [`fft`] and [`fourier`] transform signals, [`student`] has
//! the distributions of tests, and [`interruption`] ends long work.
//!
//! This crate depends on the crate `generated` only for the type `Eight` (eight samples in SIMD lanes). Generated functions write
//! rows in this layout, and a triangle reads them.
//!
//! This crate does not know robots, logs, parameters or units: a column is an array of numbers. For matrices that `nalgebra`
//! handles well, `nalgebra` is used directly.

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
