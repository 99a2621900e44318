//! The model that is linear in its parameters: tau = Y X + friction + couplings.
//!
//! [`regressor`] is the interface through which all other code uses the dynamics of a robot: given q, dq, ddq, fill Y. Its
//! implementation is a [`compiled`] function of `generated` or a tape of `rist`, with equal results.
//! [`mod@linear_model`] adds the columns of [`friction`] and [`coupling`], in the order of [`row_layout`]. [`parameter`]
//! identifies a column; its name and its [`mod@unit`] follow from it. [`states`] are the samples from which rows are
//! computed. [`standard_map`] and [`pseudo_inertia`] connect base parameters with bodies; [`known_load`] is a body with known
//! mass. [`yaml`] reads files.
//!
//! It depends on `numerics`, `robot`, and the regressors of `generated`.
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
