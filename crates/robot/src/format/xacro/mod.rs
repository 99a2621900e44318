//! Expands descriptions with macros (xacro).
//!
//! Supported: properties, macros with defaults and blocks, includes, `if` and `unless`, `${}` with Python arithmetic, `$(arg)`,
//! `$(find)` of given packages, `load_yaml`. element.rs has the element tree, expression.rs the expressions in `${}`, files.rs
//! the access to files, and expand.rs the expansion. Commands that need data of the computer (`$(env)`, `$(eval)`, other
//! packages) are refused, and the error names them. Nesting depth, length of texts and number of operations are bounded.

mod element;
mod expand;
mod expression;
mod files;
mod operations;
mod parameters;
mod tokens;
mod value;

pub(in crate::format) use expand::expanded;
