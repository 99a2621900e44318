//! Writes HTML pages for users: of an identification, and of a robot. Each page is one file and loads no other file.
//!
//! [`identification::Page`] presents an identification: its verdict with the trust by purpose and joint; the torques and
//! residuals of each joint; the moving robot; the parameters with their meaning, correlations and leverages; and the motion
//! compared with the limits. If given, it also presents the plan, an exciting motion, the validation and another estimate.
//! Lines over time (`timeline`) can be zoomed.
//!
//! [`robot`] presents a robot description: a drawing ([`drawing`]), the links, the base parameters, and the base parameters
//! that contain the ten inertial parameters of each link. Texts and scripts ([`compact`]) are in `templates/`; charts are SVG
//! ([`chart`]). A page depends only on its content: the caller supplies the date, and no clock is read.

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
pub mod replay;
pub mod robot;
pub mod scale;
pub mod sections;
pub mod sheet;
mod template;
#[cfg(test)]
mod test_page;
mod text;
mod timeline;
pub mod wrap;
