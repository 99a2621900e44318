//! One exciting motion of all joints within proved limits: a finite Fourier series between rest and rest, or a quintic
//! spline.

pub mod artefact;
pub mod barrier;
pub mod certificate_text;
pub mod columns;
pub mod course;
pub mod criterion;
pub mod descent;
pub mod described_torque;
pub mod enclosure;
pub mod error_margins;
pub mod fitting;
pub mod fourier_series;
pub mod gap_proof;
pub mod held_limits;
pub mod ledger;
pub mod left_out;
mod limit_kind;
pub mod limits;
pub mod margins;
pub mod motion;
pub mod no_motion;
pub mod polynomial_course;
pub mod problem;
pub mod proof;
pub mod quintic_spline;
pub mod sampled_drives;
pub mod search;
pub mod space_limits;
pub mod space_wall;
pub mod spline_enclosure;
pub mod stopping;
pub mod torque_wall;
pub mod visibility;
pub mod walled;
