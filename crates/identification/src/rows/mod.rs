//! Computes the observation matrix from states, block by block, and reduces it to triangles (R of QR).

mod column_sizes;
pub mod observation;
pub mod residual_sums;
