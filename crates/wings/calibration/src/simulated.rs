//! Simulated calibrations for tests: an arm with known errors, and postures that it measures.
//!
//! A problem consists of postures, the chain to the measured link, and the list of parameters. The truth is the set of unknowns
//! with which measurements are simulated.

use std::path::Path;

use nalgebra::{Rotation3, Vector3};
use random::Random;
use robot::Robot;

use crate::chain::{Chain, Convention, Placed, turned_by};
use crate::measurement::{MeasurementKind, Posture, Problem, Unknowns};
use crate::parameter::{Parameter, ParameterGroup};

/// An arm with six revolute joints, similar to industrial arms: the axes of shoulder and elbow are parallel, and the last three
/// axes intersect.
pub(crate) const ARM: &str = "convention: khalil-kleinfinger
name: arm
gravity: [0, 0, -9.81]
coordinates: [q1, q2, q3, q4, q5, q6]
links:
  - {link: 1, antecedent: base, theta: q1}
  - {link: 2, antecedent: 1, alpha: -pi/2, d: 0.15, theta: q2}
  - {link: 3, antecedent: 2, d: 0.6, theta: q3}
  - {link: 4, antecedent: 3, alpha: -pi/2, d: 0.1, theta: q4, r: 0.65}
  - {link: 5, antecedent: 4, alpha: pi/2, theta: q5}
  - {link: 6, antecedent: 5, alpha: -pi/2, theta: q6}
";

pub(crate) fn arm() -> Robot {
    rist::parse_robot(ARM, Path::new("arm.yaml"), &rist::ModelOptions::default()).unwrap()
}

/// A calibration problem with random postures (joint positions within 2 rad), but without measurements.
pub(crate) fn problem(
    robot: &Robot,
    convention: Convention,
    kind: MeasurementKind,
    count: usize,
    random: &mut Random,
) -> Problem {
    let tip = robot.link_ids().last().unwrap();
    let chain = Chain::new(robot, tip, convention).unwrap();
    let n = chain.coordinates.len();
    let mut posture = |line| Posture {
        line,
        q: (0..n).map(|_| random.between(-2.0, 2.0)).collect(),
        torque: vec![0.0; n],
        points: if kind.is_distance() { vec![[f64::NAN; 3]] } else { vec![[0.0; 3]; kind.points()] },
        rotation: (kind == MeasurementKind::Pose).then(|| Rotation3::identity().into_inner()),
        distance: kind.is_distance().then_some(0.0),
    };
    let postures = (0..count).map(|r| posture(r + 2)).collect();
    Problem::new(chain, kind, postures)
}

/// Random frames, zeros of this size, and errors of the geometry of this size, m and rad.
pub(crate) fn truth(problem: &Problem, zero: f64, geometry: f64, random: &mut Random) -> Unknowns {
    let mut vector = |size: f64| Vector3::from_fn(|_, _| random.between(-size, size));
    let base = Placed { rotation: turned_by(vector(2.0)), position: vector(1.0) };
    let (tool, anchor) = (turned_by(vector(2.0)), 2.0 * vector(1.0));
    let points = (0..problem.kind.points()).map(|_| vector(0.2)).collect();
    let mut size = |parameter: &Parameter| match parameter.group() {
        ParameterGroup::Zeros => random.between(-zero, zero),
        ParameterGroup::Geometry => random.between(-geometry, geometry),
        _ => 0.0,
    };
    let chain = problem.chain.parameters.iter().map(&mut size).collect();
    Unknowns { base, tool, anchor, radius: 0.0, points, chain }
}

/// Fills in what the robot with these unknowns measures, with normal noise of lengths, m, and of angles, rad.
pub(crate) fn measured(problem: &Problem, truth: &Unknowns, noise: [f64; 2], random: &mut Random) -> Problem {
    let mut of = |posture: &Posture| {
        let link = problem.chain.pose(&posture.q, &posture.torque, &truth.chain);
        let pose = truth.base.then(&link);
        let mut normal = |size: f64| Vector3::from_fn(|_, _| size * random.normal());
        let points = truth.points.iter().map(|p| (pose.at(p) + normal(noise[0])).into()).collect();
        let rotation = posture.rotation.map(|_| turned_by(normal(noise[1])) * pose.rotation * truth.tool);
        let length = (link.at(&truth.points[0]) - truth.anchor).norm() - truth.radius + normal(noise[0])[0];
        let distance = posture.distance.map(|_| length);
        let points = if distance.is_some() { posture.points.clone() } else { points };
        Posture { points, rotation, distance, ..posture.clone() }
    };
    let postures = problem.postures.iter().map(&mut of).collect();
    problem.with(postures)
}
