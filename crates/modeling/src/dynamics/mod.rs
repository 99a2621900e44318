//! The functions of a robot in which its inertial parameters act, one per file.

pub(crate) mod composite;
pub(crate) mod energy;
pub(crate) mod forward_dynamics;
pub(crate) mod friction;
pub(crate) mod inertia_matrix;
pub(crate) mod parameter_inputs;
pub(crate) mod pose;
pub(crate) mod regressor;
pub(crate) mod torque;
