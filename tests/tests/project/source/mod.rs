//! Reads the Rust code of this repository as tokens: imports and their order.

pub(crate) mod imports;
pub(crate) mod orders;
pub(crate) mod tokens;
