//! Determines the base parameters: the smallest set of inertial parameters that determines the torque.
//!
//! [`base_parameters`] takes these steps: a finite field chooses the columns ([`exact_rank`]), a numeric scan confirms them
//! ([`rank`]), the relations of the dropped columns are found ([`regrouping`]), compared with numeric relations ([`evidence`]),
//! named ([`names`]), and written as rules on request ([`written_rules`]).

pub(crate) mod angles;
pub(crate) mod base_parameters;
pub(crate) mod closed;
pub(crate) mod coefficient;
pub(crate) mod evidence;
pub(crate) mod exact_geometry;
pub(crate) mod exact_rank;
pub(crate) mod field;
pub(crate) mod field_algebra;
pub(crate) mod gate;
pub(crate) mod interpolation;
pub(crate) mod meaning;
pub(crate) mod names;
pub(crate) mod rank;
pub(crate) mod regrouping;
pub(crate) mod rigid_regrouping;
pub(crate) mod rule;
pub(crate) mod samples;
pub(crate) mod triangle;
pub(crate) mod unclear_rank;
pub(crate) mod weak;
pub(crate) mod written_rules;
