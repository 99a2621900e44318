//! Pages for people: one file of HTML each, which loads nothing.
//!
//! [`identification::Page`] presents an identification: its verdict with the grades by purpose and joint, the torques of
//! each joint and what is left of them, the robot on its way through the log, the parameters with their meaning, their
//! correlations and the rows that tell each, the motion against the limits, and the plan, an exciting motion, the
//! validation and another estimate where there are some. Lines over time (`timeline`) can be looked at closer.
//!
//! [`robot`] shows a description: a drawing ([`drawing`]), links, base parameters, where the ten numbers of each link
//! went. The text stands in `templates/`, with the scripts ([`compact`]); charts are SVG of our own ([`chart`]). A page
//! depends on its content alone: no clock is read, and the date is what the caller gives.

#![warn(missing_docs)]

pub mod chart;
pub mod compact;
pub mod comparison;
pub mod drawing;
pub mod excitation;
pub mod experiments;
mod frame;
mod grades;
pub mod identification;
mod information;
mod joints;
mod motion;
pub mod number;
mod parameters;
mod plot;
pub mod robot;
pub mod scale;
pub mod sheet;
mod template;
#[cfg(test)]
mod test_page;
mod text;
mod timeline;
pub mod wrap;
