//! Pages for people: one file of HTML each, which loads nothing.
//!
//! [`identification::Page`] presents an identification: its verdict, the parts of each joint's torque and its residual,
//! the parameters with their meaning, the motion against the limits, and the plan, an exciting motion and the
//! validation where there are some. [`robot`] shows a description: a drawing ([`drawing`]), links, base parameters,
//! where the ten numbers of each link went. The text stands in `templates/`; charts are SVG of our own ([`chart`]). A page depends on its
//! content alone: no clock is read, and the date is what the caller gives.

#![warn(missing_docs)]

pub mod chart;
pub mod drawing;
pub mod excitation;
mod experiments;
pub mod identification;
mod joints;
mod motion;
pub mod number;
mod parameters;
pub mod robot;
pub mod scale;
pub mod sheet;
mod template;
pub mod wrap;
