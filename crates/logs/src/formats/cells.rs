//! The cells of a table that is written to a file.
//!
//! A column has either texts or numbers.

/// The cells of one column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells<'a> {
    /// Texts; no cell is missing.
    Texts(Vec<&'a str>),
    /// Numbers; NaN and infinite numbers are written as missing cells.
    Numbers(Vec<f64>),
}
