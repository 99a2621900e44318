//! A model as experiments want it: each file implements one trait of `experiments` or `linear_model` for a model.

pub(crate) mod regressor_slope;
pub(crate) mod surroundings;
pub(crate) mod tape_dynamics;
pub(crate) mod torque_enclosure;
