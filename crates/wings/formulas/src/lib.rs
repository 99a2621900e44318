//! Wing (optional package) for formulas: writes functions of a robot for readers and for computer algebra systems.
//!
//! All languages print the same `listing`, which has assignments to named variables, or each entry expanded (`expand`). Each
//! language has its own grammar (`print`), and its own head and end of the file.
//!
//! Parts of the core that this wing uses: `modeling::formulas` derives the functions; lengths, angles and components of gravity
//! are named constants, and intermediate results have the names of Khalil's books. `expr` traverses a function node by node.

#![warn(missing_docs)]
#![allow(non_snake_case, reason = "Khalil's notation, docs/notation.md")]

mod derive;
mod determinant;
mod expand;
mod file;
mod inverse_arm;
mod inverse_geometry;
mod inverse_turns;
mod latex;
mod listing;
mod matlab;
mod print;
mod request;
mod shown;
mod symbols;
mod sympy;
mod text;

pub use derive::derive;
pub use determinant::jacobian_determinant;
pub use expand::TooLong;
pub use file::{FormulaLanguage, Formulas, formula_file, printed_symbols};
pub use inverse_arm::NoClosedForm;
pub use inverse_geometry::inverse_geometry;
pub use listing::{OutputEntry, output_name};
pub use request::{DeriveRequest, wing};
