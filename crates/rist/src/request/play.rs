//! The options (request) of `rist play`, which writes a motion as a file for the controller of a robot.
//!
//! A request is a struct with all options of a command; each field is one option.

use experiments::excitation::limits::LimitsFile;
use identification::estimate::artefact::Estimate;

use super::Range;

words! {
    /// The controller that plays a motion.
    pub enum PlayTarget {
        /// An e-Series of Universal Robots.
        UrE = "ur-e" "URScript, a set point each 2 ms",
        /// A CB3 of Universal Robots.
        UrCb3 = "ur-cb3" "URScript, a set point each 8 ms",
        /// A control loop of libfranka (Franka robots).
        Franka = "franka" "CSV, a row each ms: for a loop of libfranka that reads it",
        /// A joint_trajectory_controller of ros2_control.
        Ros2 = "ros2" "A JointTrajectory in YAML, at the rate of the motion: quintic between its points",
    }
}

request! {
    /// Options for playing a motion on a robot.
    pub struct PlayRequest {
        /// Who plays it; none of them has been tried on its controller.
        controller: PlayTarget = PlayTarget::Ros2;
        /// The same motion slower: velocities times this, accelerations times its square.
        speed: f64 = 1.0, range(Range::Share), value_name("FACTOR");
        /// Where the robot stands, rad (m): the way to the first pose and back is planned, proved and played too. Coordinates that
        /// are not given stand at the first pose.
        from: Vec<(String, f64)> = Vec::new(), value_name("COORDINATE=POSITION");
        /// Limits of your own, as for `rist check`.
        limits: Option<LimitsFile> = None, value_name("FILE");
        /// An estimate of this model: efforts and powers are proved with its torques instead of the description's.
        after: Option<Estimate> = None, value_name("ESTIMATE");
    }
}
