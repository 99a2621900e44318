//! Derives the functions of a robot, one per file: torques, regressors, inertia matrix, poses, Jacobians and others.

pub(crate) mod composite;
pub(crate) mod derivatives;
pub(crate) mod energy;
pub(crate) mod entry_forms;
pub(crate) mod factor;
pub(crate) mod forward_dynamics;
pub(crate) mod frame_motion;
pub(crate) mod friction;
pub(crate) mod geometric_errors;
pub(crate) mod inertia_matrix;
pub(crate) mod link_frame;
pub(crate) mod mass_centre;
pub(crate) mod momenta;
pub(crate) mod momentum;
pub(crate) mod momentum_rate;
pub(crate) mod parameter_inputs;
pub(crate) mod pose;
pub(crate) mod reactions;
pub(crate) mod reference_frame;
pub(crate) mod regressor;
pub(crate) mod run_axes;
pub(crate) mod slotine_li;
pub(crate) mod torque;
