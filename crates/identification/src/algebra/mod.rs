//! Matrices, transforms and random numbers. Nothing here knows robots.

pub mod fourier;
pub mod information_matrix;
pub mod interval;
pub mod jet;
pub mod least_squares;
pub mod positive_definite;
pub mod random;
pub mod range;
pub mod total_least_squares;
pub mod triangle;
pub mod vector;
