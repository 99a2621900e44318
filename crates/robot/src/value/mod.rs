//! Numbers, symbols and coordinates as the user wrote them, read and written.

mod affine;
mod exact;
mod parse;
mod text;

pub use affine::Affine;
pub use exact::{CoordinateId, Name, Symbol, SymbolId, Value};
pub use parse::parse;
