//! Pages for users: one file of HTML each, which loads no other file.
//!
//! [`identification::Page`] presents an identification: its verdict with the trust by purpose and joint, the torques and
//! residuals of each joint, the moving robot, the parameters with their meaning, their correlations and the leverage of the
//! rows, the motion compared with the limits, and, if given, the plan, an exciting motion, the validation and another
//! estimate. Lines over time (`timeline`) can be zoomed.
//!
//! [`robot`] shows a description: a drawing ([`drawing`]), links, base parameters, and the base parameters that contain the
//! ten numbers of each link. Texts are in `templates/`, with the scripts ([`compact`]); charts are SVG ([`chart`]). A page
//! depends only on its content: no clock is read, and the caller gives the date.

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
