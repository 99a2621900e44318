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
        UrE = "ur-e" "URScript, with a set point every 2 ms",
        /// A CB3 of Universal Robots.
        UrCb3 = "ur-cb3" "URScript, with a set point every 8 ms",
        /// A control loop of libfranka (Franka robots).
        Franka = "franka" "CSV, with a row every 1 ms, for a control loop of libfranka that reads this file",
        /// A joint_trajectory_controller of ros2_control.
        Ros2 = "ros2" "A JointTrajectory in YAML, at the rate of the motion, with quintic interpolation between its points",
    }
}

request! {
    /// Options for playing a motion on a robot.
    pub struct PlayRequest {
        /// Controller that will play the motion. None of the formats has been tried on its controller.
        controller: PlayTarget = PlayTarget::Ros2;
        /// Factor for a slower motion: velocities are multiplied by FACTOR, accelerations by its square.
        speed: f64 = 1.0, range(Range::Share), value_name("FACTOR");
        /// Position of the robot before the motion, rad (m). The ways from there to the first pose and back are planned, proved
        /// and played too. A coordinate that is not given is already at the first pose.
        from: Vec<(String, f64)> = Vec::new(), value_name("COORDINATE=POSITION");
        /// YAML with further limits, as for [limits] of `rist check`.
        limits: Option<LimitsFile> = None, value_name("FILE");
        /// An estimate of this model. The torques in the proofs of effort and power then follow from the estimate, not from the
        /// description.
        after: Option<Estimate> = None, value_name("ESTIMATE");
    }
}
