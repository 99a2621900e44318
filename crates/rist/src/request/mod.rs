//! What a step is asked for.

pub mod excite_request;
pub mod harmonic_request;
