//! The model that is linear in its parameters: tau = Y X + friction + couplings.
//!
//! [`regressor`] is the narrow interface through which everything else sees a robot: given q, dq, ddq, fill Y. A
//! [`compiled`] one of `generated` stands behind it, or a tape that `rist` hands over; neither can be told from the
//! other. [`mod@linear_model`] lays [`friction`] and [`coupling`] beside it, in the order of [`row_layout`].
//! [`parameter`] says what a column is; its name and its [`mod@unit`] follow. [`states`] are the samples that the rows
//! are made of. [`standard_map`] and [`pseudo_inertia`] lead to bodies; [`known_load`] is a body that was weighed.
//! [`yaml`] reads the files in which people write such things.
//!
//! It knows the numbers (`numerics`), what a robot is (`robot`), and the regressors of `generated`.
//!
//! Not here: expressions; where samples come from (`identification::signals`); which motion to run (`experiments`);
//! estimation (`identification`).

#![warn(missing_docs)]

pub mod artefact;
pub mod compiled;
pub mod coupling;
pub mod coupling_parameter;
pub mod description_options;
pub mod differentiable;
pub mod friction;
pub mod known_load;
pub mod label;
pub mod linear_model;
pub mod parameter;
pub mod pseudo_inertia;
pub mod reference;
pub mod regressor;
pub mod row_layout;
pub mod standard_map;
pub mod states;
pub mod unit;
pub mod yaml;
