//! Reads the trajectories of other programs: positions at points in time.
//!
//! Known formats: `trajectory_msgs/JointTrajectory` of ROS 1 or 2 in YAML or JSON, alone or inside a MoveIt `RobotTrajectory` or
//! `DisplayTrajectory`; and tables.

use std::path::Path;

use experiments::motion::point_trajectory::PointTrajectory;
use linear_model::yaml;
use logs::{ColumnNames, Columns, Table};
use rist::{Error, LogError, Model};
use serde::Deserialize;

/// Reads the points of a JointTrajectory. `file`: name of the file in messages.
///
/// Fails if the text contains no trajectory, or several.
pub fn points_of_ros(file: &str, text: &str) -> Result<PointTrajectory, LogError> {
    let fail = |what: String| LogError::at(file, 0, what);
    let expected = "expected is a trajectory_msgs/JointTrajectory (joint_names, points of positions, velocities, \
                    accelerations and time_from_start), alone or as joint_trajectory of a RobotTrajectory";
    let read: RosFile = yaml::read(text).map_err(|e| fail(format!("this is no trajectory: {e}; {expected}")))?;
    let trajectory = read.trajectory().ok_or_else(|| fail(format!("this is no trajectory: {expected}")))?;
    trajectory.points().map_err(fail)
}

/// Reads the points of a trajectory from a file with a table (for example a CSV).
pub(crate) fn read_table(model: &Model, path: &Path) -> Result<PointTrajectory, Error> {
    points_of_table(model, &Table::read(path)?, &ColumnNames::default())
}

/// Points from a table with a time column, one position column per coordinate, and optional columns of velocities and
/// accelerations.
///
/// Fails if a column or a number is missing, if two columns contain the same quantity, or if time does not increase.
pub fn points_of_table(model: &Model, table: &Table, names: &ColumnNames) -> Result<PointTrajectory, Error> {
    let coordinates = model.regressor().coordinates();
    let slides: Vec<bool> = (0..coordinates.len()).map(|k| model.regressor().is_prismatic(k)).collect();
    let columns = Columns::of_motion(table, coordinates, names)?.with_sliding(&slides)?;
    let series = |source: &logs::ColumnSource| -> Vec<f64> {
        table.columns[source.column].iter().map(|x| source.factor * x).collect()
    };
    let of = |sources: &[logs::ColumnSource]| sources.iter().map(series).collect::<Vec<_>>();
    let (velocities, accelerations) = (columns.velocity.as_deref().map(of), columns.acceleration.as_deref().map(of));
    PointTrajectory::new(coordinates.to_vec(), series(&columns.time), of(&columns.position), velocities, accelerations)
        .map_err(|what| Error::new(format_args!("{}: {what}", table.file)))
}

/// The content of a ROS file: a trajectory, alone or inside another message.
#[derive(Deserialize)]
struct RosFile {
    #[serde(default)]
    joint_names: Option<Vec<String>>,
    #[serde(default)]
    points: Vec<RosPoint>,
    #[serde(default)]
    joint_trajectory: Option<RosTrajectory>,
    #[serde(default)]
    trajectory: Vec<RobotTrajectory>,
}

#[derive(Deserialize)]
struct RobotTrajectory {
    joint_trajectory: RosTrajectory,
}

#[derive(Deserialize)]
struct RosTrajectory {
    joint_names: Vec<String>,
    points: Vec<RosPoint>,
}

#[derive(Deserialize)]
struct RosPoint {
    positions: Vec<f64>,
    #[serde(default)]
    velocities: Vec<f64>,
    #[serde(default)]
    accelerations: Vec<f64>,
    time_from_start: RosTime,
}

/// A time in the form of ROS 2, in the form of ROS 1, or as a number of seconds.
#[derive(Deserialize)]
#[serde(untagged)]
enum RosTime {
    Two { sec: f64, nanosec: f64 },
    One { secs: f64, nsecs: f64 },
    Seconds(f64),
}

impl RosTime {
    fn seconds(&self) -> f64 {
        match self {
            RosTime::Two { sec, nanosec } => sec + 1e-9 * nanosec,
            RosTime::One { secs, nsecs } => secs + 1e-9 * nsecs,
            RosTime::Seconds(t) => *t,
        }
    }
}

impl RosFile {
    /// The trajectory in the file. `None` if there is none, or more than one.
    fn trajectory(self) -> Option<RosTrajectory> {
        let direct = self.joint_names.map(|joint_names| RosTrajectory { joint_names, points: self.points });
        let mut all: Vec<RosTrajectory> = direct.into_iter().chain(self.joint_trajectory).collect();
        all.extend(self.trajectory.into_iter().map(|t| t.joint_trajectory));
        if all.len() == 1 { all.pop() } else { None }
    }
}

impl RosTrajectory {
    fn points(&self) -> Result<PointTrajectory, String> {
        let n = self.joint_names.len();
        let times = self.points.iter().map(|p| p.time_from_start.seconds()).collect();
        let series = |what: &str, of: fn(&RosPoint) -> &Vec<f64>| {
            if let Some(i) = self.points.iter().position(|p| of(p).len() != n) {
                return Err(format!("{what} of point {}: expected are {n}, one per joint", i + 1));
            }
            Ok((0..n).map(|k| self.points.iter().map(|p| of(p)[k]).collect()).collect())
        };
        // Velocities and accelerations are optional: either all points have them, or no point has them.
        let optional = |what: &str, of: fn(&RosPoint) -> &Vec<f64>| {
            let is_without = self.points.iter().all(|p| of(p).is_empty());
            (!is_without).then(|| series(what, of)).transpose()
        };
        let velocities = optional("velocities", |p| &p.velocities)?;
        let accelerations = optional("accelerations", |p| &p.accelerations)?;
        let positions = series("positions", |p| &p.positions)?;
        PointTrajectory::new(self.joint_names.clone(), times, positions, velocities, accelerations)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiments::motion::point_trajectory::Interpolation;

    const ALONE: &str = r#"{"joint_names": ["b", "a"], "points": [
        {"positions": [1, 2], "velocities": [0, 0], "time_from_start": {"sec": 0, "nanosec": 0}},
        {"positions": [1.5, 2], "velocities": [0, 0], "time_from_start": {"sec": 1, "nanosec": 500000000}}]}"#;

    #[test]
    fn files_of_ros_are_read() {
        let alone = points_of_ros("t.json", ALONE).unwrap();
        let old = ALONE.replace("nanosec", "nsecs").replace("\"sec\"", "\"secs\"");
        let inside = format!("{{\"joint_trajectory\": {old}, \"multi_dof_joint_trajectory\": {{\"points\": []}}}}");
        let several = format!("{{\"model_id\": \"arm\", \"trajectory\": [{inside}]}}");
        for text in [inside.as_str(), &several] {
            assert_eq!(points_of_ros("t.json", text).unwrap(), alone);
        }
        let text = "joint_names: [b, a]\npoints:\n- {positions: [1, 2], velocities: [0, 0], time_from_start: 0}\n- \
                    {positions: [1.5, 2], velocities: [0, 0], time_from_start: 1.5}\n";
        assert_eq!(points_of_ros("t.yaml", text).unwrap(), alone);
        assert_eq!(alone.times(), [0.0, 1.5]);
        let names = ["a", "b", "c"].map(String::from);
        let refused = alone.clone().of_coordinates(&names, &|_| None).unwrap_err();
        assert!(refused.contains("it does not say where c stands"), "{refused}");
        let whole = alone.clone().of_coordinates(&names, &|_| Some(0.25)).unwrap();
        assert_eq!(whole.positions(), [vec![2.0, 2.0], vec![1.0, 1.5], vec![0.25, 0.25]]);
        assert_eq!(whole.interpolation(None), Ok(Interpolation::Cubic));
        let refused = whole.interpolation(Some(Interpolation::Quintic)).unwrap_err();
        assert!(refused.contains("needs accelerations"), "{refused}");
        assert!(alone.of_coordinates(&names[..1], &|_| None).unwrap_err().contains("no coordinate `b`"));
    }

    #[test]
    fn what_is_no_trajectory_is_refused() {
        for (from, to, says) in [
            ("\"sec\": 1, \"nanosec\": 500000000", "\"sec\": 0, \"nanosec\": 0", "time does not go on from point 1"),
            ("[1.5, 2]", "[1.5]", "positions of point 2: expected are 2"),
            ("[1.5, 2]", "[1.5, 1e300]", "positions of a at point 2: 1e300 is of no robot"),
            ("\"joint_names\"", "\"names\"", "this is no trajectory"),
            (
                "\"velocities\": [0, 0], \"time_from_start\": {\"sec\": 1",
                "\"time_from_start\": {\"sec\": 1",
                "velocities of point 2",
            ),
        ] {
            assert!(ALONE.contains(from), "{from}");
            let refused = points_of_ros("t.json", &ALONE.replace(from, to)).unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
    }
}
