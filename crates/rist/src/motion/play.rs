//! A motion as a file that a controller plays.

use std::path::Path;

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::motion::Motion;
use experiments::motion::servo_script::servo_script;
use experiments::motion::trajectory_file::{TrajectoryFormat, trajectory_file};

use crate::describe::model::Model;
use crate::error::Error;

/// What plays it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Player {
    /// A controller that takes points.
    Trajectory(TrajectoryFormat),
    /// URScript, by servoj.
    ServoScript,
}

/// Set points a second of an e-Series of Universal Robots.
pub(crate) const UR_E_SERIES_HZ: f64 = 500.0;
/// Of a CB3.
pub(crate) const UR_CB3_HZ: f64 = 125.0;

impl Player {
    /// The player that a file is for, by the end of its name: .csv, .yaml or .json (ROS JointTrajectory), .script (URScript).
    ///
    /// Fails on other names, and where URScript is asked for with another robot than one of six joints that turn.
    pub fn of_file(file: &Path, model: &Model) -> Result<Player, Error> {
        let end = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let regressor = model.regressor();
        let n = regressor.coordinates().len();
        match end.as_str() {
            "csv" => Ok(Player::Trajectory(TrajectoryFormat::Csv)),
            "yaml" | "yml" => Ok(Player::Trajectory(TrajectoryFormat::RosYaml)),
            "json" => Ok(Player::Trajectory(TrajectoryFormat::RosJson)),
            "script" if n == 6 && !(0..n).any(|k| regressor.is_prismatic(k)) => Ok(Player::ServoScript),
            "script" => Err(Error::new(format_args!(
                "{}: URScript plays robots with six joints that turn; {} has {n} coordinates",
                file.display(),
                model.robot.name
            ))),
            _ => Err(Error::new(format_args!(
                "{}: the end of the name chooses the format: .csv, .yaml or .json (ROS JointTrajectory), .script (URScript)",
                file.display()
            ))),
        }
    }

    /// The text of the file: points at the rate of the motion; set points of URScript at that of a controller, 125 Hz where it is
    /// the motion's, else 500 Hz.
    ///
    /// Fails where it is no motion.
    pub fn text(self, motion: &ExcitingMotion) -> Result<String, Error> {
        let found = motion.motion("the motion")?;
        let rate = match self {
            Player::ServoScript if found.rate == UR_CB3_HZ => UR_CB3_HZ,
            Player::ServoScript => UR_E_SERIES_HZ,
            Player::Trajectory(_) => found.rate,
        };
        let reference = Motion { rate, ..found }.reference();
        let coordinates: Vec<String> = motion.joints.iter().map(|j| j.coordinate.clone()).collect();
        Ok(match self {
            Player::Trajectory(format) => trajectory_file(&reference, &coordinates, rate, format),
            Player::ServoScript => servo_script(&reference),
        })
    }
}
