//! Writes motions as files that a controller can play.
//!
//! - CSV: `t, q_<coordinate>.., dq_<coordinate>.., ddq_<coordinate>..` in s, rad, rad/s, rad/s^2, at any rate.
//! - ROS `trajectory_msgs/JointTrajectory` as YAML or JSON: joint_names, points with positions, velocities,
//!   accelerations and time_from_start (sec, nanosec as in ROS 2).

use std::fmt::Write;

use gate::shown::csv_cell;

use crate::motion::reference_motion::Reference;

/// The format of a trajectory file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrajectoryFormat {
    /// CSV with the columns `t, q_<coordinate>, dq_<coordinate>, ddq_<coordinate>`; s, rad, rad/s, rad/s^2.
    Csv,
    /// ROS message trajectory_msgs/JointTrajectory as YAML.
    RosYaml,
    /// ROS message trajectory_msgs/JointTrajectory as JSON.
    RosJson,
}

impl TrajectoryFormat {
    /// The extension of the file's name, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            TrajectoryFormat::Csv => "csv",
            TrajectoryFormat::RosYaml => "yaml",
            TrajectoryFormat::RosJson => "json",
        }
    }
}

/// Text of a trajectory file with points at `rate` Hz. It has no points if the motion is empty or the rate is not positive.
///
/// The last point is the last sample of the motion, even if the rate does not divide the duration; then it follows the previous
/// point by less than 1/rate. Between samples, positions follow the cubic with the positions and velocities of the two
/// neighbours; velocities and accelerations are linear.
pub fn trajectory_file(reference: &Reference, coordinates: &[String], rate: f64, format: TrajectoryFormat) -> String {
    let points = resampled(reference, rate);
    match format {
        TrajectoryFormat::Csv => csv(&points, coordinates),
        TrajectoryFormat::RosYaml => yaml(&points, coordinates),
        TrajectoryFormat::RosJson => json(&points, coordinates),
    }
}

/// Tolerance for rounding errors in the computation of a number of points or samples.
const COUNT_TOLERANCE: f64 = 1e-9;
/// A point that is nearer to a sample than this share of the sample time equals the sample.
const SAME_SAMPLE_SHARE: f64 = 1e-6;
struct TrajectoryPoint {
    t: f64,
    q: Vec<f64>,
    dq: Vec<f64>,
    ddq: Vec<f64>,
}

fn resampled(r: &Reference, rate: f64) -> Vec<TrajectoryPoint> {
    let count = r.q.first().map_or(0, Vec::len);
    if count == 0 || rate.is_nan() || rate <= 0.0 {
        return vec![];
    }
    // Number of points that fit into the motion. The tolerance keeps the last point in spite of rounding.
    let h = r.sample_time;
    let end = (count - 1) as f64 * h;
    let points = (end * rate + COUNT_TOLERANCE) as usize + 1;
    // Index i: the last sample before time t. s in [0, 1]: position of t between sample i and the next one.
    let at = |t: f64| {
        let i = ((t / h + COUNT_TOLERANCE) as usize).min(count - 1);
        let j = (i + 1).min(count - 1);
        let s = (t - i as f64 * h) / h;
        let s = if s < SAME_SAMPLE_SHARE { 0.0 } else { s.min(1.0) };
        // Positions by cubic Hermite interpolation, consistent with the velocities of the reference.
        let cubic = |k: usize| {
            let (a, b) = (r.q[k][i], r.q[k][j]);
            let (va, vb) = (h * r.dq[k][i], h * r.dq[k][j]);
            let (s2, s3) = (s * s, s * s * s);
            a * (2.0 * s3 - 3.0 * s2 + 1.0) + va * (s3 - 2.0 * s2 + s) + b * (3.0 * s2 - 2.0 * s3) + vb * (s3 - s2)
        };
        let linear = |x: &[Vec<f64>], k: usize| x[k][i] + s * (x[k][j] - x[k][i]);
        let n = 0..r.q.len();
        TrajectoryPoint {
            t,
            q: n.clone().map(cubic).collect(),
            dq: n.clone().map(|k| linear(&r.dq, k)).collect(),
            ddq: n.map(|k| linear(&r.ddq, k)).collect(),
        }
    };
    // The last sample is added as a point, so that a motion that ends at rest also ends at rest in its file.
    let last = Some(end).filter(|end| end - (points - 1) as f64 / rate > SAME_SAMPLE_SHARE * h);
    (0..points).map(|p| p as f64 / rate).chain(last).map(at).collect()
}

fn list(x: &[f64]) -> String {
    x.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ")
}

/// Header line of a CSV file: `t`, then `prefix_coordinate` for each prefix and coordinate.
pub(crate) fn csv_header(prefixes: &[&str], coordinates: &[String]) -> String {
    let mut text = String::from("t");
    for prefix in prefixes {
        let cell = |c: &String| format!(",{}", csv_cell(&format!("{prefix}_{c}")));
        coordinates.iter().for_each(|c| text.push_str(&cell(c)));
    }
    text + "\n"
}

fn csv(points: &[TrajectoryPoint], coordinates: &[String]) -> String {
    let mut text = csv_header(&["q", "dq", "ddq"], coordinates);
    let list = |x: &[f64]| list(x).replace(", ", ",");
    for p in points {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{:.6},{},{},{}", p.t, list(&p.q), list(&p.dq), list(&p.ddq));
    }
    text
}

fn split(t: f64) -> (u64, u64) {
    let nanoseconds = (t * 1e9).round() as u64;
    (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000)
}

fn yaml(points: &[TrajectoryPoint], coordinates: &[String]) -> String {
    let names: Vec<String> = coordinates.iter().map(|c| quoted(c)).collect();
    let mut text = format!("joint_names: [{}]\npoints:\n", names.join(", "));
    for p in points {
        let (seconds, nanoseconds) = split(p.t);
        let _ = writeln!(text, "  - positions: [{}]", list(&p.q));
        let _ = writeln!(text, "    velocities: [{}]", list(&p.dq));
        let _ = writeln!(text, "    accelerations: [{}]", list(&p.ddq));
        let _ = writeln!(text, "    time_from_start: {{sec: {seconds}, nanosec: {nanoseconds}}}");
    }
    text
}

fn json(points: &[TrajectoryPoint], coordinates: &[String]) -> String {
    let names: Vec<String> = coordinates.iter().map(|c| quoted(c)).collect();
    let point = |p: &TrajectoryPoint| {
        let (seconds, nanoseconds) = split(p.t);
        format!(
            "    {{\"positions\": [{}], \"velocities\": [{}], \"accelerations\": [{}], \
             \"time_from_start\": {{\"sec\": {seconds}, \"nanosec\": {nanoseconds}}}}}",
            list(&p.q),
            list(&p.dq),
            list(&p.ddq)
        )
    };
    let points: Vec<String> = points.iter().map(point).collect();
    format!("{{\n  \"joint_names\": [{}],\n  \"points\": [\n{}\n  ]\n}}\n", names.join(", "), points.join(",\n"))
}

/// The text as a JSON string literal, which is also valid YAML.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push_str(&format!("\\u{:04x}", c as u32)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::exciting_trajectory::ExcitingTrajectory;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct JointTrajectory {
        joint_names: Vec<String>,
        points: Vec<JointPoint>,
    }
    #[derive(Deserialize)]
    struct JointPoint {
        positions: Vec<f64>,
        velocities: Vec<f64>,
        accelerations: Vec<f64>,
        time_from_start: Time,
    }
    #[derive(Deserialize)]
    struct Time {
        sec: u64,
        nanosec: u64,
    }

    fn reference() -> (Reference, Vec<String>) {
        let sweep = ExcitingTrajectory::sweep(1, &[0.2, 0.0], 1.0, 1.0, 1e-3);
        (sweep.reference(), vec!["q1".into(), "el\"bow".into()])
    }

    #[test]
    fn ros_files_read_back() {
        let (reference, names) = reference();
        for format in [TrajectoryFormat::RosYaml, TrajectoryFormat::RosJson] {
            let text = trajectory_file(&reference, &names, 100.0, format);
            let read: JointTrajectory = serde_yaml::from_str(&text).unwrap();
            assert_eq!(read.joint_names, names);
            // The last point is at the time of the last sample.
            assert_eq!(read.points.len(), (reference.q[0].len() - 1).div_ceil(10) + 1);
            let p = &read.points[57];
            assert_eq!((p.time_from_start.sec, p.time_from_start.nanosec), (0, 570_000_000));
            // The point at 0.57 s equals sample 570.
            assert!((p.positions[1] - reference.q[1][570]).abs() < 1e-12);
            assert_eq!(p.velocities[1], reference.dq[1][570]);
            assert_eq!(p.accelerations.len(), 2);
        }
    }

    #[test]
    fn csv_at_another_rate_follows_the_motion() {
        let (reference, names) = reference();
        let text = trajectory_file(&reference, &names, 1500.0, TrajectoryFormat::Csv);
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("t,q_q1,\"q_el\"\"bow\",dq_q1,\"dq_el\"\"bow\",ddq_q1,\"ddq_el\"\"bow\""));
        for line in lines {
            let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
            let i = (cells[0] * 1000.0) as usize;
            // Tolerance: the change of the position within one sample time, at 1 rad/s.
            assert!((cells[2] - reference.q[1][i]).abs() <= 1.001e-3);
        }
        // A rate of 70 Hz does not divide the duration of the motion; its last sample must still be the last point.
        let text = trajectory_file(&reference, &names, 70.0, TrajectoryFormat::Csv);
        let last: Vec<f64> = text.lines().last().unwrap().split(',').map(|c| c.parse().unwrap()).collect();
        let end = reference.q[0].len() - 1;
        assert!((last[0] - end as f64 * 1e-3).abs() < 1e-6, "{last:?}");
        assert!((last[2] - reference.q[1][end]).abs() < 1e-12, "{last:?}");
        assert_eq!(last[4], reference.dq[1][end]);
        assert_eq!(trajectory_file(&reference, &names, 0.0, TrajectoryFormat::Csv).lines().count(), 1);
    }
}
