//! The options (request) for a package: a folder with an identified model that runs on a robot.
//!
//! A request is a struct with all options of a command; each field is one option.

use rist::Options;
use rist::request::Request;
use rist::wings::Wing;

/// The request that this wing registers.
pub fn wing() -> Wing {
    Wing { requests: vec![("package", PackageRequest::fields)], ..Wing::default() }
}

rist::words! {
    /// What runs the model.
    pub enum PackageTarget {
        /// A package of ROS 2 with a chainable controller and a solver of inverse dynamics.
        Ros2Control = "ros2-control" "ROS 2: a chainable controller, and a plugin for inverse_dynamics_solver",
        /// A Python file for servo arms.
        Lerobot = "lerobot" "One Python file for servo arms: goal currents or goal positions",
        /// A sketch for drives on a CAN bus.
        Arduino = "arduino" "An Arduino sketch with the C file in float, for drives on a CAN bus",
    }
}

rist::request! {
    /// Options that select a package.
    pub struct PackageRequest {
        /// Instead of source, write a folder that runs the model on a robot. [out] names this folder, and [estimate] is needed
        /// too.
        target: Option<PackageTarget> = None, flag("as"), value_name("TARGET");
        /// For [target]: the options with which the logs of the estimate were identified. They contain the units, gains and
        /// signs of the drives.
        options: Option<Options> = None, value_name("FILE");
    }
}
