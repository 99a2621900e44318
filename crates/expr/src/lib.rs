//! Hash-consed expression graphs, their evaluation and their operation counts.
//!
//! A [`Graph`] holds every subexpression once. An [`Expr`] is a handle with a sign, so that -x costs
//! nothing and x - y and y - x share a node. A [`Function`] is named inputs -> named outputs: the
//! unit of evaluation ([`Tape`]), of differentiation ([`Adjoint`], [`Graph::derivatives`]), of evaluation in another algebra
//! ([`Function::evaluate_in`]), of counting ([`Function::count`]) and of code generation, where a [`Module`] of functions
//! makes a file. [`fewest_operations`] chooses between ways to write entries. [`Fusion`] says which products are fused into sums: the tape and generated code perform the same operations. Nothing here knows robots.

#![warn(missing_docs)]

mod adjoint;
mod choice;
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
pub use choice::{Move, fewest_operations};
pub use function::{Algebra, Count, Function, Input, Output, TellingPlaces, operands};
pub use fusion::{Fusion, Operation};
pub use graph::{Expr, Graph, Node, Symbol, SymbolKind};
pub use module::{Constant, Documented, Entries, Module, Value};
pub use sine::SINE_SOURCE;
pub use tape::{LaneOutputs, Tape, Workspace};
