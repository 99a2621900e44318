//! From states to triangles: the observation matrix, streamed.

pub mod observation;
pub mod residual_sums;
