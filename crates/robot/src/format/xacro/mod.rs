//! Expands descriptions with macros (xacro).
//!
//! Supported: properties, macros with defaults and blocks, includes, `if` and `unless`, `${}` and `$(eval)` with Python
//! arithmetic and methods of texts, `$(arg)`, `$(find)` of packages that are given or stand above the file, `load_yaml`.
//! element.rs has the element tree, expression.rs the expressions in `${}`, files.rs the access to files, and expand.rs the
//! expansion. Commands that need data of the host (`$(env)`, other packages) are refused, and the error names them. Depth,
//! length and number of operations are bounded.

mod element;
mod expand;
mod expression;
mod files;
mod methods;
mod operations;
mod parameters;
mod tokens;
mod value;

pub(in crate::format) use expand::expanded;
