//! Wing (optional package) for packages: folders with an identified model that run on a robot.
//!
//! A package is made of templates (`templates/`) with placeholders such as `@PREFIX@`. Its numbers come from the estimate, the
//! torque limits from the description, and the units of the drives from the options of the identification ([`DriveUnits`]). All
//! packages have the same rule for a state that is late or is not finite: they keep the last safe torque for some cycles, and
//! then send no torque.
//!
//! Parts of the core that this wing uses: `rist::generate` writes the C file, `modeling` derives the functions that are written
//! in Python, and `identification` has the transmission between drives and joints.

#![warn(missing_docs)]

mod arduino;
mod drive_units;
mod lerobot;
mod names;
mod package;
mod parts;
mod python;
mod request;
mod ros2_control;

pub use drive_units::DriveUnits;
pub use package::package;
pub use parts::PackageFile;
pub use request::{PackageRequest, PackageTarget, wing};
