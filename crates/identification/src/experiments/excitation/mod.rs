//! One exciting motion of all joints: a finite Fourier series between rest and rest, within proved limits.

pub mod artefact;
pub mod barrier;
pub mod columns;
pub mod criterion;
pub mod descent;
pub mod enclosure;
pub mod fitting;
pub mod fourier_motion;
pub mod gap_proof;
pub mod limits;
pub mod problem;
pub mod proof;
pub mod search;
pub mod space_limits;
pub mod space_wall;
pub mod visibility;
