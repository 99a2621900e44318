//! Adapters from [`crate::Model`] to traits of `experiments` and `linear_model`: each file implements one trait.

pub(crate) mod regressor_slope;
pub(crate) mod surroundings;
pub(crate) mod tape_dynamics;
pub(crate) mod torque_enclosure;
