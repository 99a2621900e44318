//! Writes a motion as a file that a controller plays.
//!
//! Formats: CSV, a JointTrajectory of ROS, or a URScript that sends set points.

use std::path::Path;

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::motion::Motion;
use experiments::motion::servo_script::servo_script;
use experiments::motion::trajectory_file::{TrajectoryFormat, trajectory_file};

use crate::describe::model::Model;
use crate::error::Error;

/// The kind of file with which a controller plays a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayFormat {
    /// A file of trajectory points.
    Trajectory(TrajectoryFormat),
    /// A URScript program that sends set points with `servoj`.
    ServoScript,
}

/// Rate at which a Universal Robots e-Series takes set points, Hz.
pub(crate) const UR_E_SERIES_HZ: f64 = 500.0;
/// Rate at which a Universal Robots CB3 takes set points, Hz.
pub(crate) const UR_CB3_HZ: f64 = 125.0;

impl PlayFormat {
    /// The kind of a file, by its extension: .csv, .yaml or .json (ROS JointTrajectory), .script (URScript).
    ///
    /// Fails for other extensions, and for URScript if the robot does not have six turning joints.
    pub fn of_file(file: &Path, model: &Model) -> Result<PlayFormat, Error> {
        let end = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let regressor = model.regressor();
        let n = regressor.coordinates().len();
        match end.as_str() {
            "csv" => Ok(PlayFormat::Trajectory(TrajectoryFormat::Csv)),
            "yaml" | "yml" => Ok(PlayFormat::Trajectory(TrajectoryFormat::RosYaml)),
            "json" => Ok(PlayFormat::Trajectory(TrajectoryFormat::RosJson)),
            "script" if n == 6 && !(0..n).any(|k| regressor.is_prismatic(k)) => Ok(PlayFormat::ServoScript),
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

    /// The text of the file. Trajectory points have the rate of the motion. URScript set points have the rate of a controller:
    /// 125 Hz if the motion has this rate, otherwise 500 Hz.
    ///
    /// Fails if `motion` holds no valid motion.
    pub fn text(self, motion: &ExcitingMotion) -> Result<String, Error> {
        let found = motion.motion("the motion")?;
        let rate = match self {
            PlayFormat::ServoScript if found.rate == UR_CB3_HZ => UR_CB3_HZ,
            PlayFormat::ServoScript => UR_E_SERIES_HZ,
            PlayFormat::Trajectory(_) => found.rate,
        };
        let reference = Motion { rate, ..found }.reference();
        let coordinates: Vec<String> = motion.joints.iter().map(|j| j.coordinate.clone()).collect();
        Ok(match self {
            PlayFormat::Trajectory(format) => trajectory_file(&reference, &coordinates, rate, format),
            PlayFormat::ServoScript => servo_script(&reference),
        })
    }
}
