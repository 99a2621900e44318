//! Adapters of a model: each file implements one trait of `experiments` or `linear_model` for it.

pub(crate) mod regressor_slope;
pub(crate) mod surroundings;
pub(crate) mod tape_dynamics;
pub(crate) mod torque_enclosure;
