//! The expansion of a description with macros (xacro).
//!
//! Properties, macros with defaults and blocks, includes, `if` and `unless`, `${}` with the arithmetic of Python, `$(arg)`,
//! `$(find)` of given packages, `load_yaml`. element.rs has the tree of a file, expression.rs the expressions in `${}`,
//! files.rs the access to files, expand.rs the rest. Commands that need data of the host (`$(env)`, `$(eval)`, other
//! packages) are refused by name. Depth, length and number of operations are bounded.

mod element;
mod expand;
mod expression;
mod files;
mod operations;
mod parameters;
mod tokens;
mod value;

pub(in crate::format) use expand::expanded;
