//! Tests `rist wrench`: logs of a force-torque sensor on the last link, each with one mistake. A log has postures at rest or a
//! motion.
//!
//! A wrench is a force and a torque. The load is identifiable only if the sensor turns relative to gravity.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::arms::Arm;
use super::case::{Case, Command, with_steps, written};
use super::motion::harmonics;
use crate::number::Number;
use crate::pose::{BASE, Frame, joint_variables};
use crate::program::Run;
use crate::random_situations::draw::Draw;

/// The kinds of mistakes, each with a phrase of a finding that names it.
const KINDS: [(&str, &str); 12] = [
    ("none", ""),
    ("negated", "the signs are turned"),
    ("counts", "the signals are no N and N m"),
    ("torques in N mm", "are the torques in N mm?"),
    ("w first", "the first number of the quaternions is w"),
    ("inverted poses", "the poses are those of the frame at rest in the sensor"),
    ("base axes", "in the axes of the frame at rest"),
    ("turned 30 deg", "turned against the frame of the poses"),
    ("turned 90 deg", "turned against the frame of the poses"),
    ("compensated", "takes the weight out"),
    ("rpy in degrees", "in degrees, taken for radians"),
    ("tared", ""),
];
/// Sampling period, s. `STEP`: time step of the difference quotient for accelerations, s.
const PERIOD: f64 = 0.005;
const STEP: f64 = 1e-3;
/// Gravity, m/s^2.
const GRAVITY: f64 = 9.80665;
/// A load is identifiable if the direction of gravity in the sensor frame has at least this standard deviation.
const TURNS: f64 = 0.3;

pub const COMMAND: Command = Command { word: "wrench", case, findings, obeyed: with_steps };

/// A sample: pose of the sensor; force and torque on the load, in the axes of the sensor.
#[derive(Clone, Copy)]
struct Row {
    turn: Matrix3<f64>,
    place: Vector3<f64>,
    force: Vector3<f64>,
    torque: Vector3<f64>,
    /// Force and torque on the load by its weight alone, as if it were at rest.
    weight: [Vector3<f64>; 2],
}

fn case(seed: u64, arms: &[Arm]) -> Case<'_> {
    let draw = &mut Draw::of(seed, 1);
    let (name, says) = KINDS[(seed % KINDS.len() as u64) as usize];
    let arm = &arms[draw.below(arms.len())];
    let is_motion = draw.chance(0.5);
    let rows = rows(arm, is_motion, draw);
    let axis = vector(draw).normalize();
    let log = |name: &str, right: &[Row]| {
        let mut rows = right.to_vec();
        spoil(name, axis, &mut rows);
        text(&rows, is_motion, name)
    };
    let [wrong, right] =
        [(name, "wrong.csv"), ("none", "right.csv")].map(|(kind, file)| written(file, &log(kind, &rows)));
    let words = |file: String| vec!["wrench".to_string(), file];
    let down = rows.iter().map(|row| row.turn.transpose() * Vector3::z());
    let mean = down.clone().sum::<Vector3<f64>>() / rows.len() as f64;
    let turns = (down.map(|z| (z - mean).norm_squared()).sum::<f64>() / rows.len() as f64).sqrt();
    Case {
        arm,
        kind: if says.is_empty() { "none" } else { name },
        is_right: Box::new(move |text| text.contains(says)),
        is_above: turns > TURNS,
        words: words(wrong),
        clean: Some(words(right)),
    }
}

fn vector(draw: &mut Draw) -> Vector3<f64> {
    Vector3::from_fn(|_, _| draw.normal())
}

/// The samples of an ideal sensor with a load of six point masses.
fn rows(arm: &Arm, is_motion: bool, draw: &mut Draw) -> Vec<Row> {
    let mass = draw.log(0.6, 5.0);
    let centre = 0.05 * vector(draw);
    let points: Vec<Vector3<f64>> = (0..6).map(|_| centre + 0.04 * vector(draw)).collect();
    let offsets = [2.0 * vector(draw), 0.1 * vector(draw)];
    let noise = draw.log(0.003, 0.05);
    let motion = harmonics(arm, 20.0, draw);
    let count = if is_motion { (motion.duration / PERIOD) as usize } else { 12 + draw.below(30) };
    let mut row = |i: usize| {
        let t = PERIOD * i as f64;
        let at_rest: Vec<f64> = (0..arm.n()).map(|k| draw.uniform(arm.range(k).0, arm.range(k).1)).collect();
        let at = |dt: f64| pose(arm, &if is_motion { motion.at(t + dt).q } else { at_rest.clone() });
        let [before, now, behind] = [-STEP, 0.0, STEP].map(at);
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        for point in &points {
            let [a, b, c] = [&before, &now, &behind].map(|(turn, place)| turn * point + place);
            let push = (mass / 6.0) * ((a - 2.0 * b + c) / (STEP * STEP) + GRAVITY * Vector3::z());
            let push = now.0.transpose() * push;
            force += push;
            torque += point.cross(&push);
        }
        let (force, torque) =
            (force + offsets[0] + noise * vector(draw), torque + offsets[1] + 0.05 * noise * vector(draw));
        let weight = now.0.transpose() * (mass * GRAVITY * Vector3::z());
        let middle = points.iter().sum::<Vector3<f64>>() / 6.0;
        Row { turn: now.0, place: now.1, force, torque, weight: [weight, middle.cross(&weight)] }
    };
    (0..count).map(&mut row).collect()
}

/// The pose of the last frame at the joint positions q.
fn pose(arm: &Arm, q: &[f64]) -> (Matrix3<f64>, Vector3<f64>) {
    let q: Vec<Number> = q.iter().map(|x| Number::constant(*x)).collect();
    let variables = joint_variables(&arm.robot, &q);
    let mut frames: Vec<Frame> = Vec::new();
    for (link, variable) in arm.robot.links.iter().zip(variables) {
        let before = link.antecedent.map_or(BASE, |i| frames[i.0]);
        frames.push(before.placed(&arm.robot, &link.geometry, link.joint.kind, variable));
    }
    let last = frames.last().copied().unwrap_or(BASE);
    (Matrix3::from_fn(|i, k| last.rotation[i][k].value), Vector3::from_fn(|i, _| last.origin[i].value))
}

/// Adds a mistake to the samples. Mistakes in the orientation are added when the log is written.
fn spoil(kind: &str, axis: Vector3<f64>, rows: &mut [Row]) {
    let angle: f64 = if kind == "turned 30 deg" { 30.0 } else { 90.0 };
    let turned = Rotation3::new(angle.to_radians() * axis).into_inner();
    let first = rows[0];
    for row in rows {
        let Row { turn, place, force, torque, weight } = row;
        match kind {
            "negated" => (*force, *torque) = (-*force, -*torque),
            "counts" => (*force, *torque) = (1e3 * *force, 1e3 * *torque),
            "torques in N mm" => *torque *= 1e3,
            "compensated" => (*force, *torque) = (*force - weight[0], *torque - weight[1]),
            "inverted poses" => (*turn, *place) = (turn.transpose(), -(turn.transpose() * *place)),
            "base axes" => (*force, *torque) = (*turn * *force, *turn * *torque),
            "turned 30 deg" | "turned 90 deg" => (*force, *torque) = (turned * *force, turned * *torque),
            "tared" => (*force, *torque) = (*force - first.force, *torque - first.torque),
            _ => {}
        }
    }
}

/// The log as CSV. Orientations are quaternions, or roll, pitch and yaw if the mistake concerns these.
fn text(rows: &[Row], is_motion: bool, kind: &str) -> String {
    let is_rpy = kind == "rpy in degrees";
    let mut all = if is_motion { "t,".to_string() } else { String::new() };
    all += "fx,fy,fz,tx,ty,tz,x,y,z,";
    all += if is_rpy { "roll,pitch,yaw\n" } else { "qx,qy,qz,qw\n" };
    for (i, row) in rows.iter().enumerate() {
        let turn = Rotation3::from_matrix_unchecked(row.turn);
        let angles = turn.euler_angles();
        let q = UnitQuaternion::from_rotation_matrix(&turn);
        let orientation = match kind {
            _ if is_rpy => vec![angles.0.to_degrees(), angles.1.to_degrees(), angles.2.to_degrees()],
            "w first" => vec![q.w, q.i, q.j, q.k],
            _ => vec![q.i, q.j, q.k, q.w],
        };
        let clock = is_motion.then_some(PERIOD * i as f64);
        let vectors = [row.force, row.torque, row.place];
        let numbers = clock.into_iter().chain(vectors.iter().flat_map(|v| v.iter().copied())).chain(orientation);
        all += &numbers.map(|x| format!("{x:?}")).collect::<Vec<_>>().join(",");
        all.push('\n');
    }
    all
}

/// The findings of a run: the reasons why a load must not be used, with the remedy.
fn findings(_: &[String], run: &Run) -> Vec<String> {
    let is_no = run.out.lines().any(|line| line == "trust: no");
    let next = run.out.lines().find_map(|line| line.strip_prefix("next: ")).unwrap_or_default();
    let reasons = run.out.lines().filter_map(|line| line.strip_prefix("  - "));
    reasons
        .filter(|_| is_no)
        .enumerate()
        .map(|(k, why)| if k == 0 { format!("{why}; {next}") } else { why.into() })
        .collect()
}
