//! The cells of a table that is written.

/// The cells of a column of a table that is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells<'a> {
    /// Texts, each there.
    Texts(Vec<&'a str>),
    /// Numbers; what is not finite is written as absent.
    Numbers(Vec<f64>),
}
