//! Hash-consed expression graphs, their evaluation and their operation counts.
//!
//! A [`Graph`] contains every subexpression once. An [`Expr`] is a handle with a sign, so that -x costs no operation, and x - y
//! and y - x share a node. A [`Function`] has named inputs and named outputs. It is evaluated with a [`Tape`], differentiated
//! with [`Adjoint`] or [`Graph::derivatives`], evaluated in another algebra with [`Function::evaluate_in`] and counted with
//! [`Function::count`]. Code is generated from a [`Module`], the functions of one file. [`fewest_operations`] chooses among
//! alternative forms of entries. [`Fusion`] determines the products that are fused into sums: the tape and generated code perform
//! the same operations. This package is independent of robots.

#![warn(missing_docs)]

mod adjoint;
mod cheapest_forms;
mod forward;
mod function;
mod fusion;
mod graph;
mod module;
mod sine;
mod slots;
mod tape;
mod tape_operation;

pub use adjoint::{Adjoint, AdjointWorkspace};
pub use cheapest_forms::{FormChange, fewest_operations};
pub use function::{Algebra, Count, Function, Input, Output, SparsityPattern, operands};
pub use fusion::{Fusion, Operation};
pub use graph::{Expr, Graph, Node, Symbol, SymbolKind};
pub use module::{Constant, ConstantValue, Documented, Entries, Module};
pub use sine::SINE_SOURCE;
pub use tape::{LaneOutputs, Tape, Workspace};
