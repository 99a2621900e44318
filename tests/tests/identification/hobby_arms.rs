//! Tests that one command leads from the files of a hobby arm to a verdict. The files are a data set of LeRobot and a log of
//! Dynamixel registers, simulated for the arms that are described here. The commands of the guide to servos run as they are
//! printed.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use identification::estimate::artefact::Estimate;
use logs::{Cells, parquet_bytes};
use rist::Model;
use tests::joint_log::{JointLog, Machine, described};
use tests::program::{folder, rist, rist_done};

/// A joint of a test arm: name, axis, origin in the frame of the previous link (m), mass of the link (kg), centre of mass of
/// the link (m).
type ArmJoint = (&'static str, &'static str, [f64; 3], f64, [f64; 3]);

/// Five joints with the names and about the sizes of an SO-101.
const SO101: [ArmJoint; 5] = [
    ("shoulder_pan", "0 0 1", [0.0, 0.0, 0.06], 0.10, [0.0, 0.0, 0.03]),
    ("shoulder_lift", "0 1 0", [0.03, 0.0, 0.055], 0.11, [0.01, 0.0, 0.07]),
    ("elbow_flex", "0 1 0", [0.03, 0.0, 0.116], 0.10, [0.07, 0.0, 0.0]),
    ("wrist_flex", "0 1 0", [0.135, 0.0, 0.0], 0.08, [0.03, 0.0, 0.01]),
    ("wrist_roll", "1 0 0", [0.06, 0.0, 0.0], 0.09, [0.03, 0.02, 0.01]),
];

/// Six joints with the names and about the sizes of a WidowX 250.
const WX250S: [ArmJoint; 6] = [
    ("waist", "0 0 1", [0.0, 0.0, 0.07], 0.5, [0.0, 0.0, 0.03]),
    ("shoulder", "0 1 0", [0.0, 0.0, 0.04], 0.4, [0.02, 0.0, 0.18]),
    ("elbow", "0 1 0", [0.05, 0.0, 0.25], 0.3, [0.1, 0.0, 0.0]),
    ("forearm_roll", "1 0 0", [0.18, 0.0, 0.0], 0.2, [0.04, 0.01, 0.0]),
    ("wrist_angle", "0 1 0", [0.07, 0.0, 0.0], 0.15, [0.04, 0.0, 0.01]),
    ("wrist_rotate", "1 0 0", [0.065, 0.0, 0.0], 0.2, [0.04, 0.02, 0.01]),
];

/// Stall torque of the STS3215 at 7.4 V, N m. One count of the load of this servo is 0.1 % of the stall torque.
const STS3215_STALL: f64 = 1.912;
/// Torque per current of an XM430-W350, N m/A. The next constant is its current per count, A.
const XM430_GAIN: f64 = 4.1 / 2.3;
const XM430_COUNT: f64 = 2.69e-3;
/// Torque per count of an XL430-W250, N m. This servo reports a load instead of a current.
const XL430_COUNT: f64 = 1.4e-3;

fn urdf(name: &str, joints: &[ArmJoint]) -> String {
    let mut text = format!("<robot name=\"{name}\"><link name=\"base\"/>");
    let three = |x: [f64; 3]| x.map(|x| x.to_string()).join(" ");
    for (k, (joint, axis, place, mass, centre)) in joints.iter().enumerate() {
        let parent = if k == 0 { "base".into() } else { format!("l{k}") };
        let inertia = 4e-4 * mass;
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "<link name=\"l{0}\"><inertial><origin xyz=\"{1}\"/><mass value=\"{mass}\"/><inertia ixx=\"{inertia}\" ixy=\"0\" \
             ixz=\"0\" iyy=\"{2}\" iyz=\"0\" izz=\"{2}\"/></inertial></link><joint name=\"{joint}\" type=\"revolute\"><parent \
             link=\"{parent}\"/><child link=\"l{0}\"/><origin xyz=\"{3}\"/><axis xyz=\"{axis}\"/><limit lower=\"-1.9\" \
             upper=\"1.7\" effort=\"5\" velocity=\"5\"/></joint>",
            k + 1,
            three(*centre),
            1.5 * inertia,
            three(*place),
        );
    }
    text + "</robot>"
}

/// Writes the description of an arm into a folder; returns its model, and a log at 50 Hz. `friction`: one number for all
/// joints. It is both the viscous friction, N m s/rad, and the Coulomb friction, N m.
fn arm(here: &Path, file: &str, joints: &[ArmJoint], friction: f64) -> (Model, JointLog) {
    std::fs::write(here.join(file), urdf(file.trim_end_matches(".urdf"), joints)).unwrap();
    let model = Model::read(here.join(file)).unwrap();
    let n = joints.len();
    let (parameters, amplitude) = (described(&model.robot), vec![1.0; n]);
    let (viscous, coulomb) = (vec![friction; n], vec![friction; n]);
    let exact = Machine::exact(&model.robot, &parameters, &amplitude);
    let log = Machine { viscous: &viscous, coulomb: &coulomb, ..exact }.log().every(10);
    (model, log)
}

/// Writes a data set of LeRobot. `position` converts a position in rad to the units of the data set. Loads are in 0.1 % of the
/// stall torque.
fn data_set(here: &Path, log: &JointLog, position: impl Fn(f64) -> f64) {
    for sub in ["my_data_set/meta", "my_data_set/data/chunk-000"] {
        std::fs::create_dir_all(here.join(sub)).unwrap();
    }
    std::fs::write(here.join("my_data_set/meta/info.json"), "{\"features\": {}}").unwrap();
    let numbers = |x: &[f64], f: &dyn Fn(f64) -> f64| Cells::Numbers(x.iter().map(|x| f(*x)).collect());
    let mut columns = vec![("timestamp".to_string(), numbers(&log.t, &|t| t))];
    for (k, q) in log.q.iter().enumerate() {
        columns.push((format!("observation.state_{}", k + 1), numbers(q, &|q| (100.0 * position(q)).round() / 100.0)));
    }
    for (k, tau) in log.tau.iter().enumerate() {
        let load = |x: f64| (1000.0 * x / STS3215_STALL).round();
        columns.push((format!("observation.effort_{}", k + 1), numbers(tau, &load)));
    }
    columns.push(("episode_index".into(), numbers(&log.t, &|_| 0.0)));
    let file = "my_data_set/data/chunk-000/episode_000000.parquet";
    std::fs::write(here.join(file), parquet_bytes(&columns).unwrap()).unwrap();
}

/// Writes a log of Dynamixel registers: positions in counts, and currents in 16 bits. `per_count`: torque per count of each
/// joint, N m.
fn dynamixel(path: PathBuf, log: &JointLog, per_count: &[f64]) {
    let n = log.q.len();
    let header = |what: &str| (1..=n).map(|k| format!("id{k}_present_{what}")).collect::<Vec<_>>().join(",");
    let mut text = format!("time_ms,{},{}\n", header("position"), header("current"));
    for r in 0..log.t.len() {
        let count = |q: f64| (2048.0 + q * 4096.0 / std::f64::consts::TAU).round();
        let current = |k: usize| (log.tau[k][r] / per_count[k]).round().rem_euclid(65536.0);
        let positions = log.q.iter().map(|q| count(q[r]));
        let cells: Vec<String> = positions.chain((0..n).map(current)).map(|x| x.to_string()).collect();
        let _ = writeln!(text, "{},{}", (1e3 * log.t[r]).round(), cells.join(","));
    }
    std::fs::write(path, text).unwrap();
}

/// Identifies by one command, and compares the parameters with the description, whose parameters are the true ones.
fn round_trip(here: &Path, model: &Model, command: &str) {
    let run = rist_done(here, &format!("{command} --out estimate.yaml"));
    assert!(run.out.contains("trust: ") && !run.out.contains("trust: no"), "{command}: {}", run.out);
    let estimate =
        Estimate::from_yaml("estimate.yaml", &std::fs::read_to_string(here.join("estimate.yaml")).unwrap()).unwrap();
    let truth = model.nominal_parameters().unwrap();
    for (found, truth) in estimate.parameters.iter().zip(&truth) {
        let Some((x, sigma)) = found.value.zip(found.sigma) else { continue };
        // The rounding of counts is not normally distributed noise, and the filter removes some of the signal. The two per cent
        // of the value in the tolerance allow for both.
        assert!(
            (x - truth).abs() < 5.0 * sigma + 0.02 * truth.abs(),
            "{command}: {}: {x} +- {sigma}, {truth}",
            found.id
        );
    }
}

#[test]
fn a_data_set_of_an_so101_gives_a_verdict_by_one_command() {
    let here = folder("so101");
    let (model, log) = arm(&here, "so101.urdf", &SO101, 0.03);
    data_set(&here, &log, f64::to_degrees);
    round_trip(&here, &model, "identify so101.urdf my_data_set --arm so101:degrees");
    // Normalised positions: -100 to 100 over the position limits -1.9 and 1.7 rad.
    data_set(&here, &log, |q| (q + 0.1) * 200.0 / 3.6);
    round_trip(&here, &model, "identify so101.urdf my_data_set --arm so101:normalised");
    // The values do not show whether they are degrees or normalised. So the program asks, and does not assume one of them.
    let asked = rist(&here, &["identify", "so101.urdf", "my_data_set", "--arm", "so101"]);
    assert!(asked.code != Some(0) && asked.err.contains("`so101:normalised`"), "{}", asked.err);
    let plain = rist(&here, &["doctor", "so101.urdf", "my_data_set"]);
    assert!(plain.err.contains(" takes the units, zeros and gains of the servos"), "{}", plain.err);
}

#[test]
fn a_log_of_a_widowx_gives_a_verdict_by_one_command() {
    let here = folder("wx250s");
    let (model, log) = arm(&here, "wx250s.urdf", &WX250S, 0.1);
    let one = XM430_GAIN * XM430_COUNT;
    dynamixel(here.join("dxl.csv"), &log, &[one, 2.0 * one, 2.0 * one, one, one, XL430_COUNT]);
    round_trip(&here, &model, "identify wx250s.urdf dxl.csv --arm wx250s");
    rist_done(&here, "doctor wx250s.urdf dxl.csv --arm wx250s");
}

/// Runs the commands of the guide in a folder with the files that the guide describes.
#[test]
fn the_guide_to_servos_runs_as_printed() {
    let here = folder("guide_to_servos");
    let (_, log) = arm(&here, "so101.urdf", &SO101, 0.03);
    data_set(&here, &log, f64::to_degrees);
    let (_, log) = arm(&here, "arm.urdf", &WX250S[..4], 0.1);
    dynamixel(here.join("dxl.csv"), &log, &[XM430_GAIN * XM430_COUNT; 4]);
    let guide = tests::text_of("docs/how-to/record-on-servos.md");
    let commands: Vec<&str> =
        tests::fenced(&guide, "```").into_iter().filter_map(|line| line.strip_prefix("rist ")).collect();
    assert_eq!(commands.len(), 4, "{commands:?}");
    for command in commands {
        rist_done(&here, command);
    }
}
