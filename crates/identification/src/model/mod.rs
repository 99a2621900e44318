//! The model that is linear in the parameters: tau = Y X + friction + couplings.

pub mod compiled;
pub mod coupling;
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
pub mod standard_map;
pub mod states;
pub mod unit;
