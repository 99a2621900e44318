//! From states to triangles: the observation matrix, streamed.

mod column_sizes;
pub mod observation;
pub mod residual_sums;
