//! The cells of a table to be written.

/// The cells of a column to be written.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells<'a> {
    /// Texts, none missing.
    Texts(Vec<&'a str>),
    /// Numbers; NaN and infinite ones are written as missing.
    Numbers(Vec<f64>),
}
