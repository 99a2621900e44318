//! Reads and writes the YAML format of rist.

mod convention;
mod geometry;
mod link;
mod loops;
mod read;
mod repairs;
mod standard_parameters;
mod write;

pub use geometry::{GeometryErrors, write_geometry_into_yaml};
pub use read::read_yaml;
pub(super) use read::read_yaml_with;
pub use repairs::write_repairs_into_yaml;
pub use write::write_yaml;
