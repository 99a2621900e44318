//! Exact expressions of numbers, symbols and coordinates: their parsing and their output as text.

mod affine;
mod exact;
mod parse;
mod text;

pub use affine::Affine;
pub use exact::{CoordinateId, Name, Symbol, SymbolId, Value};
pub use parse::parse;
