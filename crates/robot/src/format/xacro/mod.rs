//! A description with macros (xacro), written out.
//!
//! Properties, macros with defaults and blocks, includes, `if` and `unless`, `${}` with the arithmetic of Python, `$(arg)`,
//! `$(find)` of given packages, `load_yaml`. element.rs holds the tree of a file, expression.rs what stands in `${}`,
//! files.rs what may be opened, expand.rs the rest. What asks the host (`$(env)`, `$(eval)`, other packages) is refused by
//! its name. How deep, how long and how much work: all of it is bounded.

mod element;
mod expand;
mod expression;
mod files;
mod operations;
mod parameters;
mod tokens;
mod value;

pub(in crate::format) use expand::expanded;
