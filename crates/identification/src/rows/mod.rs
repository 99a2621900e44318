//! Reduces states to triangles: the observation matrix, block by block.

mod column_sizes;
pub mod observation;
pub mod residual_sums;
