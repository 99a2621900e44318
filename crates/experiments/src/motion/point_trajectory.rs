//! A motion that others made: points in time, and how a controller goes from one to the next.
//!
//! Read from `trajectory_msgs/JointTrajectory` in YAML or JSON, of ROS 1 or 2, alone or inside a `RobotTrajectory` or a
//! `DisplayTrajectory` of MoveIt. Points of a table (a CSV) come from the caller.

use linear_model::yaml;
use logs::Error;
use serde::Deserialize;

/// How a controller goes from point to point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight: velocities jump.
    Linear,
    /// By positions and velocities: accelerations jump.
    Cubic,
    /// By positions, velocities and accelerations: the jerk jumps.
    Quintic,
}

impl Interpolation {
    /// All, with their words.
    pub const ALL: [(Interpolation, &str); 3] =
        [(Interpolation::Linear, "linear"), (Interpolation::Cubic, "cubic"), (Interpolation::Quintic, "quintic")];

    /// Its word.
    pub fn word(self) -> &'static str {
        Interpolation::ALL.into_iter().find(|(i, _)| *i == self).map_or("", |(_, word)| word)
    }
}

/// The points. Series are one per coordinate, all of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct PointTrajectory {
    coordinates: Vec<String>,
    times: Vec<f64>,
    positions: Vec<Vec<f64>>,
    velocities: Option<Vec<Vec<f64>>>,
    accelerations: Option<Vec<Vec<f64>>>,
}

/// Most points of a trajectory: an hour at 1 kHz takes more, and longer to prove than anybody waits.
const MOST_POINTS: usize = 400_000;
/// The largest number, SI: of no robot, and small enough that a proof does not overflow.
const LARGEST_NUMBER: f64 = 1e6;

impl PointTrajectory {
    /// From series: s, rad (m) and their derivatives.
    ///
    /// Fails where there are fewer than two points or very many, where time does not go on, and where a number is not
    /// finite or larger than a robot has.
    pub fn new(
        coordinates: Vec<String>,
        times: Vec<f64>,
        positions: Vec<Vec<f64>>,
        velocities: Option<Vec<Vec<f64>>>,
        accelerations: Option<Vec<Vec<f64>>>,
    ) -> Result<PointTrajectory, String> {
        let count = times.len();
        if !(2..=MOST_POINTS).contains(&count) {
            return Err(format!("it has {count} points; expected are 2 to {MOST_POINTS}"));
        }
        if let Some(i) = (1..count).find(|&i| times[i] <= times[i - 1]) {
            return Err(format!(
                "time does not go on from point {i} ({} s) to the next ({} s)",
                times[i - 1],
                times[i]
            ));
        }
        let all = [Some(&positions), velocities.as_ref(), accelerations.as_ref()];
        for (what, series) in ["positions", "velocities", "accelerations"].iter().zip(all) {
            let Some(series) = series else { continue };
            if series.len() != coordinates.len() || series.iter().any(|x| x.len() != count) {
                return Err(format!("{what}: expected is one number per joint and point"));
            }
            for (name, x) in coordinates.iter().zip(series) {
                if let Some(i) = x.iter().position(|x| x.is_nan() || x.abs() > LARGEST_NUMBER) {
                    return Err(format!("{what} of {name} at point {}: {:e} is of no robot", i + 1, x[i]));
                }
            }
        }
        if let Some(t) = times.iter().find(|t| t.is_nan() || t.abs() > LARGEST_NUMBER) {
            return Err(format!("a point is at {t} s"));
        }
        Ok(PointTrajectory { coordinates, times, positions, velocities, accelerations })
    }

    /// Reads a JointTrajectory, as the head says.
    pub fn from_ros(file: &str, text: &str) -> Result<PointTrajectory, Error> {
        let fail = |what: String| Error::at(file, 0, what);
        let expected = "expected is a trajectory_msgs/JointTrajectory (joint_names, points of positions, velocities, \
                        accelerations and time_from_start), alone or as joint_trajectory of a RobotTrajectory";
        let read: RosFile = yaml::read(text).map_err(|e| fail(format!("this is no trajectory: {e}; {expected}")))?;
        let trajectory = read.trajectory().ok_or_else(|| fail(format!("this is no trajectory: {expected}")))?;
        trajectory.points().map_err(fail)
    }

    /// The coordinates of a model; those that the file does not move stand where `stands` says.
    ///
    /// Fails where the file moves a joint that is no coordinate, or nothing says where a coordinate stands.
    pub fn of_coordinates(
        self,
        names: &[String],
        stands: &dyn Fn(usize) -> Option<f64>,
    ) -> Result<PointTrajectory, String> {
        if let Some(unknown) = self.coordinates.iter().find(|c| !names.contains(c)) {
            return Err(format!("there is no coordinate `{unknown}`; there are {}", names.join(", ")));
        }
        let count = self.times.len();
        let place = |name: &String| self.coordinates.iter().position(|c| c == name);
        let mut positions = Vec::new();
        for (k, name) in names.iter().enumerate() {
            positions.push(match (place(name), stands(k)) {
                (Some(place), _) => self.positions[place].clone(),
                (None, Some(q)) => vec![q; count],
                (None, None) => {
                    return Err(format!(
                        "it does not say where {name} stands: give `coordinates: {{{name}: {{locked: POSITION}}}}` in [limits]"
                    ));
                }
            });
        }
        let still = |series: Option<Vec<Vec<f64>>>| {
            let series = series?;
            Some(names.iter().map(|name| place(name).map_or(vec![0.0; count], |k| series[k].clone())).collect())
        };
        let (velocities, accelerations) = (still(self.velocities.clone()), still(self.accelerations.clone()));
        Ok(PointTrajectory { coordinates: names.to_vec(), times: self.times, positions, velocities, accelerations })
    }

    /// The interpolation that was asked for, or the smoothest that the points allow.
    ///
    /// Fails where the points have not what it needs.
    pub fn interpolation(&self, asked: Option<Interpolation>) -> Result<Interpolation, String> {
        let needs =
            |what: &str| format!("an interpolation of this kind needs {what} at the points, and the file has none");
        match (asked, &self.velocities, &self.accelerations) {
            (Some(Interpolation::Linear), ..) | (None, None, _) => Ok(Interpolation::Linear),
            (Some(Interpolation::Cubic), Some(_), _) | (None, Some(_), None) => Ok(Interpolation::Cubic),
            (Some(Interpolation::Quintic) | None, Some(_), Some(_)) => Ok(Interpolation::Quintic),
            (Some(_), None, _) => Err(needs("velocities")),
            (Some(_), _, None) => Err(needs("accelerations")),
        }
    }

    /// Names, in the order of the series.
    pub fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    /// s.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// rad (m).
    pub fn positions(&self) -> &[Vec<f64>] {
        &self.positions
    }

    /// rad/s (m/s), where the file has them.
    pub fn velocities(&self) -> Option<&[Vec<f64>]> {
        self.velocities.as_deref()
    }

    /// rad/s^2 (m/s^2), where the file has them.
    pub fn accelerations(&self) -> Option<&[Vec<f64>]> {
        self.accelerations.as_deref()
    }

    /// Whether it begins and ends without velocity, as far as the points say.
    pub fn rests_at_its_ends(&self) -> bool {
        let last = self.times.len() - 1;
        self.velocities.as_ref().is_none_or(|v| v.iter().all(|v| v[0] == 0.0 && v[last] == 0.0))
    }
}

/// A file of ROS, whatever it holds around the trajectory.
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

/// ROS 2, ROS 1, or seconds.
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
    /// The trajectory; of several none.
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
        // Either all points have them, or none.
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

    const ALONE: &str = r#"{"joint_names": ["b", "a"], "points": [
        {"positions": [1, 2], "velocities": [0, 0], "time_from_start": {"sec": 0, "nanosec": 0}},
        {"positions": [1.5, 2], "velocities": [0, 0], "time_from_start": {"sec": 1, "nanosec": 500000000}}]}"#;

    #[test]
    fn files_of_ros_are_read() {
        let alone = PointTrajectory::from_ros("t.json", ALONE).unwrap();
        let old = ALONE.replace("nanosec", "nsecs").replace("\"sec\"", "\"secs\"");
        let inside = format!("{{\"joint_trajectory\": {old}, \"multi_dof_joint_trajectory\": {{\"points\": []}}}}");
        let several = format!("{{\"model_id\": \"arm\", \"trajectory\": [{inside}]}}");
        for text in [inside.as_str(), &several] {
            assert_eq!(PointTrajectory::from_ros("t.json", text).unwrap(), alone);
        }
        let text = "joint_names: [b, a]\npoints:\n- {positions: [1, 2], velocities: [0, 0], time_from_start: 0}\n- \
                    {positions: [1.5, 2], velocities: [0, 0], time_from_start: 1.5}\n";
        assert_eq!(PointTrajectory::from_ros("t.yaml", text).unwrap(), alone);
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
            let refused = PointTrajectory::from_ros("t.json", &ALONE.replace(from, to)).unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
    }
}
