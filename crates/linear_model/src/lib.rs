//! The model that is linear in its parameters: tau = Y X + friction + couplings.
//!
//! [`regressor`] is the interface through which all other code uses the dynamics of a robot: it computes Y from q, dq, ddq. The
//! interface is implemented by a [`compiled`] function of `generated` and by a tape (list of interpreted operations) of `rist`,
//! with equal results. [`mod@linear_model`] adds the columns of [`friction`] and [`coupling`], in the order of [`row_layout`].
//! A [`parameter`] identifies a column and gives its name and its [`mod@unit`]. [`states`] are the samples from which rows are
//! computed. [`standard_map`] and [`pseudo_inertia`] relate base parameters to rigid bodies; [`known_load`] is a load with
//! known mass. [`yaml`] reads files.
//!
//! This crate depends on `numerics`, `robot`, and the regressors of `generated`.
//!
//! Not here: symbolic expressions; the samples of logs (`identification::signals`); exciting motions (`experiments`); estimation
//! (`identification`).

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
