//! Matrices, transforms, intervals and distributions.
//!
//! A log becomes rows, and rows become a [`triangle`]: R, z, rho of a QR decomposition that never holds the rows.
//! [`reflection`] and [`row_block`] feed it; [`least_squares`], [`total_least_squares`] and [`information_matrix`] ask
//! it. [`interval`], [`range`] and [`jet`] enclose what a function can be between two instants. [`fft`] and [`fourier`]
//! transform, [`student`] tells chance from difference, and [`interruption`] ends long work.
//!
//! It knows the lanes of `generated`: the triangle takes eight samples abreast, as a generated function writes them.
//!
//! Not here: anything of robots, logs, parameters or units. A column is a number. Matrices that fit `nalgebra` stay
//! there.

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
