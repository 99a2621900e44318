//! The Rust of this repository as tokens: what imports what, in which order.

pub(crate) mod imports;
pub(crate) mod orders;
pub(crate) mod tokens;
