//! Reads MJCF, the model format of MuJoCo.

mod actuators;
mod bodies;
mod compiler;
mod defaults;
mod element;
mod equalities;
mod inertials;
mod joints;
mod left_out;
mod masses;
mod meshes;
mod numbers;
mod read;

pub(in crate::format) use element::{Folders, without_includes};
pub(in crate::format) use read::read_mjcf_with;
