//! Graphs of mathematical expressions, their evaluation, and the number of their operations.
//!
//! A [`Graph`] stores every subexpression once (hash consing). An [`Expr`] refers to a node and has a sign. So -x costs no
//! operation, and x - y and y - x have the same node. A [`Function`] has named inputs and named outputs. It is evaluated with a
//! [`Tape`], differentiated with [`Adjoint`] or [`Graph::derivatives`], evaluated in another algebra with
//! [`Function::evaluate_in`], and its operations are counted with [`Function::count`]. Code is generated from a [`Module`], which
//! contains the functions of one file. If an entry can be written in several forms, [`fewest_operations`] chooses the form.
//! [`Fusion`] determines which products are fused into sums, so that the tape and generated code perform the same operations.
//! This package is independent of robots.

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
