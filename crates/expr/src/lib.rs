//! Hash-consed expression graphs, their evaluation and their operation counts.
//!
//! A [`Graph`] contains every subexpression once. An [`Expr`] is a handle with a sign, so that -x costs no
//! operation and x - y and y - x share a node. A [`Function`] has named inputs and named outputs: it is the
//! unit of evaluation ([`Tape`]), of differentiation ([`Adjoint`], [`Graph::derivatives`]), of evaluation in another algebra
//! ([`Function::evaluate_in`]), of counting ([`Function::count`]) and of code generation, where a [`Module`] of functions
//! is a file. [`fewest_operations`] chooses among alternative forms of entries. [`Fusion`] determines the products that are
//! fused into sums: the tape and generated code perform equal operations. This package is independent of robots.

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
