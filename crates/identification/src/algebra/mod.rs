//! Matrices, transforms and random numbers. Nothing here knows robots.

pub mod behrens_fisher;
pub mod fourier;
pub mod in_order;
pub mod information_matrix;
pub mod interruption;
pub mod interval;
pub mod jet;
pub mod least_squares;
pub mod positive_definite;
pub mod random;
pub mod range;
pub mod reflection;
pub mod row_block;
pub mod student;
pub mod total_least_squares;
pub mod triangle;
pub mod vector;
