//! A model as experiments want it: each file implements one trait of `experiments` or `linear_model` for a model.

pub mod regressor_slope;
pub mod surroundings;
pub mod tape_dynamics;
pub mod torque_enclosure;
