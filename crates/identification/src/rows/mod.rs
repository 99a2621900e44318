//! Computes the observation matrix from states (q, dq, ddq, tau at the samples), block by block, and reduces it to triangles. A
//! triangle is the R of a QR decomposition.

mod column_sizes;
pub mod observation;
pub mod residual_sums;
