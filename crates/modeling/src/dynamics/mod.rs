//! What the motion of the links makes of the inertial parameters: one function of a robot a file.

pub(crate) mod composite;
pub(crate) mod energy;
pub(crate) mod forward_dynamics;
pub(crate) mod friction;
pub(crate) mod inertia_matrix;
pub(crate) mod parameter_inputs;
pub(crate) mod pose;
pub(crate) mod regressor;
pub(crate) mod torque;
