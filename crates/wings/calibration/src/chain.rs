//! The chain of elementary transforms from the base to a link, with the exact Jacobian of its pose.
//!
//! Each elementary transform turns about an axis or slides along it. Its variable is a constant plus an error parameter, plus a
//! sum of coordinates. An axis with the direction a and the origin o in the base frame changes the position p of a point of the
//! last link by
//! ```text
//! dp = (w x (p - o) + v) dx     w = a, v = 0 for a turn;  w = 0, v = a for a slide
//! ```
//! This derivative is exact [Khalil, Dombre 2002, chapter 11]. The coordinates of the robot follow from the coordinates q of a
//! table: (1 + gear) q + zero - compliance tau, with the holding torque tau.
//!
//! Errors of the geometry are described in one of two conventions: by the geometric parameters of Khalil and Kleinfinger (with
//! the angle beta of Hayati), or by six errors of each joint frame of a URDF. A twist is the motion of a body per unit of a
//! parameter: angular and linear velocity.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rist::Error;
use robot::value::CoordinateId;
use robot::{JointKind, LinkId, Pose, Robot};

use crate::parameter::{Letter, Parameter};

/// The parameters by which errors of the geometry are described.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convention {
    /// By the geometric parameters (letters) of Khalil and Kleinfinger, and the angle beta of Hayati.
    Dh,
    /// By six errors of the frame of each joint in the description (URDF).
    Frames,
}

/// A pose: orientation and position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Rotation matrix.
    pub rotation: Matrix3<f64>,
    /// Position of the origin, m.
    pub position: Vector3<f64>,
}

impl Placed {
    /// The pose of a frame in itself: no rotation and no translation.
    pub fn identity() -> Placed {
        Placed { rotation: Matrix3::identity(), position: Vector3::zeros() }
    }

    pub(crate) fn of(pose: &Pose) -> Placed {
        Placed { rotation: Matrix3::from_fn(|i, k| pose.rotation[i][k]), position: Vector3::from(pose.position) }
    }

    /// The pose as arrays.
    pub fn pose(&self) -> Pose {
        Pose {
            rotation: std::array::from_fn(|i| std::array::from_fn(|k| self.rotation[(i, k)])),
            position: self.position.into(),
        }
    }

    /// The product of two poses: the pose `next`, which is given in the frame of this pose, relative to the frame in which this
    /// pose is given.
    pub fn then(&self, next: &Placed) -> Placed {
        Placed { rotation: self.rotation * next.rotation, position: self.at(&next.position) }
    }

    /// The inverse pose.
    pub fn inverse(&self) -> Placed {
        let rotation = self.rotation.transpose();
        Placed { rotation, position: -(rotation * self.position) }
    }

    /// The position of a point whose coordinates are given in the frame of this pose.
    pub fn at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.position
    }
}

/// The rotation matrix of a rotation vector, rad.
pub(crate) fn turned_by(vector: Vector3<f64>) -> Matrix3<f64> {
    Rotation3::new(vector).into_inner()
}

/// The motion of a body per unit of a parameter: angular velocity, and the velocity of the point of the body at the origin of the
/// frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Angular velocity.
    pub w: Vector3<f64>,
    /// Velocity of the point of the body that coincides with the origin of the frame.
    pub v: Vector3<f64>,
}

impl Twist {
    pub(crate) fn turn(axis: Vector3<f64>, origin: &Vector3<f64>) -> Twist {
        Twist { w: axis, v: -axis.cross(origin) }
    }

    pub(crate) fn slide(axis: Vector3<f64>) -> Twist {
        Twist { w: Vector3::zeros(), v: axis }
    }

    /// The velocity of the point at p.
    pub fn at(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.w.cross(p) + self.v
    }

    fn add(&mut self, other: &Twist, factor: f64) {
        self.w += factor * other.w;
        self.v += factor * other.v;
    }
}

#[derive(Clone, Debug)]
enum Motion {
    Turn(Unit<Vector3<f64>>),
    Slide(Vector3<f64>),
    Still(Matrix3<f64>),
}

/// An elementary transform.
#[derive(Clone, Debug)]
struct Element {
    motion: Motion,
    constant: f64,
    /// Index of the error parameter in [`Chain::parameters`].
    error: Option<usize>,
    /// Coordinates that the variable follows: index in [`Chain::coordinates`] and factor.
    terms: Vec<(usize, f64)>,
}

/// The chain from the base to a link.
#[derive(Clone, Debug)]
pub struct Chain {
    elements: Vec<Element>,
    /// The links of the chain, from the base on.
    pub links: Vec<LinkId>,
    /// The coordinates that move the chain, as indices of coordinates of the robot, ascending.
    pub coordinates: Vec<usize>,
    /// The parameters: zeros, errors of the geometry, gears, compliances.
    pub parameters: Vec<Parameter>,
    /// Number of errors of the geometry.
    geometry: usize,
    convention: Convention,
}

/// The pose of the last link with its derivatives.
pub struct Derivatives {
    /// The pose of the last link in the base frame.
    pub pose: Placed,
    /// For each parameter, the motion of the last link, in the base frame.
    pub twists: Vec<Twist>,
}

impl Chain {
    /// The chain to the link `tip`.
    ///
    /// Fails if a joint of the chain follows from numerically solved loops, or if nothing moves the link.
    pub fn new(robot: &Robot, tip: LinkId, convention: Convention) -> Result<Chain, Error> {
        let mut links: Vec<LinkId> = std::iter::successors(Some(tip), |&j| robot.link(j).antecedent).collect();
        links.reverse();
        let terms = |j: LinkId| robot.link(j).joint.variable.terms.iter();
        // Coordinates with an index from n_coordinates() on are passive: loops determine them, so the table lacks them.
        if let Some(j) = links.iter().find(|&&j| terms(j).any(|(k, _)| k.0 >= robot.n_coordinates())) {
            let message = format!(
                "joint `{}` follows from a loop that is solved numerically: a calibration needs joints whose positions are \
                 measured; name a link before it in [tip]",
                robot.link(*j).joint.name
            );
            return Err(Error::new(message));
        }
        let mut coordinates: Vec<usize> = links.iter().flat_map(|&j| terms(j).map(|(k, _)| k.0)).collect();
        coordinates.sort_unstable();
        coordinates.dedup();
        if coordinates.is_empty() {
            return Err(Error::new(format_args!(
                "no joint moves the link `{}`: name another in [tip]",
                robot.link(tip).name
            )));
        }
        // The order of the parameters is zeros, geometry, gears, compliances. `derivatives` computes the indices from it.
        let zeros = coordinates.iter().map(|&coordinate| Parameter::Zero { coordinate });
        let mut chain =
            Chain { elements: vec![], links, parameters: zeros.collect(), coordinates, geometry: 0, convention };
        for j in chain.links.clone() {
            match convention {
                Convention::Dh => chain.add_letters(robot, j),
                Convention::Frames => chain.add_frame(robot, j),
            }
        }
        chain.geometry = chain.parameters.len() - chain.coordinates.len();
        let more = |make: fn(usize) -> Parameter| chain.coordinates.iter().map(move |&k| make(k)).collect::<Vec<_>>();
        let gears = more(|coordinate| Parameter::Gear { coordinate });
        let compliances = more(|coordinate| Parameter::Compliance { coordinate });
        chain.parameters.extend(gears.into_iter().chain(compliances));
        Ok(chain)
    }

    /// The convention of the errors of the geometry.
    pub fn convention(&self) -> Convention {
        self.convention
    }

    fn push(&mut self, motion: Motion, constant: f64, error: Option<Parameter>, terms: Vec<(usize, f64)>) {
        let error = error.map(|error| {
            self.parameters.push(error);
            self.parameters.len() - 1
        });
        self.elements.push(Element { motion, constant, error, terms });
    }

    /// The terms of the joint variable of a link: for each coordinate that moves the joint, its index in [`Chain::coordinates`]
    /// and its factor.
    fn terms(&self, robot: &Robot, j: LinkId) -> Vec<(usize, f64)> {
        let place = |k: &CoordinateId| self.coordinates.binary_search(&k.0).unwrap_or(0);
        robot.link(j).joint.variable.terms.iter().map(|(k, c)| (place(k), *c)).collect()
    }

    /// Adds Rz(gamma) Tz(b) Ry(beta) Rx(alpha) Tx(d) Rz(theta) Tz(r): the geometric parameters of Khalil and Kleinfinger, and
    /// the angle beta of Hayati, which describes the error between nearly parallel axes.
    fn add_letters(&mut self, robot: &Robot, j: LinkId) {
        let (link, terms) = (robot.link(j), self.terms(robot, j));
        let dh = &link.geometry;
        let number = |value: &robot::Value| value.number(&robot.symbols);
        let of = |kind: JointKind| if link.joint.kind == kind { terms.clone() } else { vec![] };
        let (x, y, z) = (Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis());
        // `sin_cos` gives exact quarter turns, so the chain has the poses of `Robot::link_poses` up to rounding.
        let all = [
            (Letter::Gamma, Motion::Turn(z), number(&dh.gamma), vec![]),
            (Letter::B, Motion::Slide(*z), number(&dh.b), vec![]),
            (Letter::Beta, Motion::Turn(y), 0.0, vec![]),
            (Letter::Alpha, Motion::Turn(x), number(&dh.alpha), vec![]),
            (Letter::D, Motion::Slide(*x), number(&dh.d), vec![]),
            (Letter::Theta, Motion::Turn(z), number(&dh.theta), of(JointKind::Revolute)),
            (Letter::R, Motion::Slide(*z), number(&dh.r), of(JointKind::Prismatic)),
        ];
        for (letter, motion, constant, terms) in all {
            self.push(motion, constant, Some(Parameter::Dh { link: j.0, letter }), terms);
        }
    }

    /// Adds the frame of a joint in the description: the translations Tx Ty Tz, the rotation of the frame, small turns about x,
    /// y and z (the errors), then the motion of the joint.
    fn add_frame(&mut self, robot: &Robot, j: LinkId) {
        let (link, terms) = (robot.link(j), self.terms(robot, j));
        let before = link.antecedent.map_or(Placed::identity(), |i| Placed::of(&robot.link(i).file_frame));
        let own = Placed::of(&link.file_frame);
        let at_zero = Placed::of(&link.geometry.pose(&robot.symbols, 0.0, 0.0));
        let joint = before.inverse().then(&at_zero).then(&own);
        let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
        let error = |axis: usize| Some(Parameter::Frame { link: j.0, axis });
        for (k, axis) in axes.iter().enumerate() {
            self.push(Motion::Slide(**axis), joint.position[k], error(k), vec![]);
        }
        self.push(Motion::Still(joint.rotation), 0.0, None, vec![]);
        for (k, axis) in axes.iter().enumerate() {
            self.push(Motion::Turn(*axis), 0.0, error(3 + k), vec![]);
        }
        // The axis of the joint is z of the link frame, and passes through the origin of the joint frame.
        let axis: Vector3<f64> = own.rotation.transpose() * Vector3::z();
        match link.joint.kind {
            JointKind::Revolute => self.push(Motion::Turn(Unit::new_normalize(axis)), 0.0, None, terms),
            JointKind::Prismatic => self.push(Motion::Slide(axis), 0.0, None, terms),
            // Every joint has the same number of transforms.
            JointKind::Fixed => self.push(Motion::Still(Matrix3::identity()), 0.0, None, vec![]),
        }
    }

    /// Brings the zeros of revolute joints into the range of half a turn, because a change by a whole turn gives the same
    /// robot.
    pub(crate) fn within_half_a_turn(&self, values: &mut [f64]) {
        for k in 0..self.coordinates.len() {
            let is_whole = |element: &Element| {
                let mut terms = element.terms.iter().filter(|(of, _)| *of == k);
                matches!(element.motion, Motion::Turn(_)) && terms.all(|(_, c)| c.fract() == 0.0)
                    || element.terms.iter().all(|(of, _)| *of != k)
            };
            if values[k].abs() > PI && self.elements.iter().all(is_whole) {
                values[k] -= TAU * (values[k] / TAU).round();
            }
        }
    }

    /// The pose of the last link in the base frame; for
    /// [`Convention::Frames`], the pose of the joint frame of the last link. `q`: coordinates of the chain in the table, rad
    /// (m); `torque`: holding torques, N m (N); `values`: one per parameter.
    pub fn pose(&self, q: &[f64], torque: &[f64], values: &[f64]) -> Placed {
        self.walked(q, torque, values, |_, _| {})
    }

    /// The pose like [`Chain::pose`], with its derivatives.
    pub fn derivatives(&self, q: &[f64], torque: &[f64], values: &[f64]) -> Derivatives {
        let n = self.coordinates.len();
        let (gears, compliances) = (n + self.geometry, 2 * n + self.geometry);
        let mut twists = vec![Twist::default(); self.parameters.len()];
        let pose = self.walked(q, torque, values, |element, twist| {
            if let Some(e) = element.error {
                twists[e] = twist;
            }
            element.terms.iter().for_each(|(k, c)| twists[*k].add(&twist, *c));
        });
        for k in 0..n {
            let zero = twists[k];
            twists[gears + k].add(&zero, q[k]);
            twists[compliances + k].add(&zero, -torque[k]);
        }
        Derivatives { pose, twists }
    }

    /// Walks from the base to the last link. `each` gets every moving transform with its twist.
    fn walked(&self, q: &[f64], torque: &[f64], values: &[f64], mut each: impl FnMut(&Element, Twist)) -> Placed {
        let n = self.coordinates.len();
        let (gears, compliances) = (n + self.geometry, 2 * n + self.geometry);
        let of_robot = |k: usize| (1.0 + values[gears + k]) * q[k] + values[k] - values[compliances + k] * torque[k];
        let mut pose = Placed::identity();
        for element in &self.elements {
            let error = element.error.map_or(0.0, |e| values[e]);
            let variable = element.constant + error + element.terms.iter().map(|(k, c)| c * of_robot(*k)).sum::<f64>();
            match &element.motion {
                Motion::Turn(axis) => {
                    each(element, Twist::turn(pose.rotation * axis.as_ref(), &pose.position));
                    if variable != 0.0 {
                        pose.rotation *= turned_by(variable * axis.into_inner());
                    }
                }
                Motion::Slide(axis) => {
                    let direction = pose.rotation * axis;
                    each(element, Twist::slide(direction));
                    pose.position += variable * direction;
                }
                Motion::Still(rotation) => pose.rotation *= rotation,
            }
        }
        pose
    }

    /// The pose of each link of the chain relative to its antecedent (the link before it) at q = 0, with the errors
    /// `values`. The poses are those of link frames for [`Convention::Dh`], and of joint frames for [`Convention::Frames`].
    pub fn placements(&self, values: &[f64]) -> Vec<Placed> {
        let each = self.elements.len() / self.links.len().max(1);
        let at_zero = |elements: &[Element]| {
            elements.iter().fold(Placed::identity(), |pose, element| {
                let variable = element.constant + element.error.map_or(0.0, |e| values[e]);
                let zero: f64 = element.terms.iter().map(|(k, c)| c * values[*k]).sum();
                let rotation = match &element.motion {
                    Motion::Turn(axis) => turned_by((variable + zero) * axis.into_inner()),
                    Motion::Slide(axis) => {
                        return Placed { position: pose.at(&((variable + zero) * axis)), ..pose };
                    }
                    Motion::Still(rotation) => *rotation,
                };
                Placed { rotation: pose.rotation * rotation, ..pose }
            })
        };
        self.elements.chunks(each.max(1)).map(at_zero).collect()
    }
}

#[cfg(test)]
mod tests {
    use random::Random;

    use super::*;
    use crate::measurement::MeasurementKind;
    use crate::simulated::{arm, problem, truth};

    fn apart(a: &Placed, b: &Placed) -> f64 {
        (a.position - b.position).norm() + (a.rotation - b.rotation).norm()
    }

    /// Without errors, the chain gives the poses of the robot, in both conventions.
    #[test]
    fn a_chain_without_errors_is_the_robot() {
        let robot = arm();
        let mut random = Random::new(1);
        let tip = robot.link_ids().last().unwrap();
        for convention in [Convention::Dh, Convention::Frames] {
            let chain = Chain::new(&robot, tip, convention).unwrap();
            let q: Vec<f64> = (0..6).map(|_| random.between(-3.0, 3.0)).collect();
            let pose = chain.pose(&q, &[0.0; 6], &vec![0.0; chain.parameters.len()]);
            // Rounding of about fifty products.
            assert!(apart(&pose, &Placed::of(&robot.link_poses(&q)[5])) < 1e-14);
        }
    }

    /// An error of a geometric parameter (letter) has the same effect on the pose as an equal change of this parameter in the
    /// description.
    #[test]
    fn an_error_is_a_change_of_the_description() {
        let robot = arm();
        let tip = robot.link_ids().last().unwrap();
        let chain = Chain::new(&robot, tip, Convention::Dh).unwrap();
        let q = [0.3, -0.8, 1.1, 0.4, -0.9, 2.0];
        let mut checked = 0;
        for (k, parameter) in chain.parameters.iter().enumerate() {
            let Parameter::Dh { link, letter } = *parameter else { continue };
            let mut values = vec![0.0; chain.parameters.len()];
            values[k] = 0.01;
            let mut changed = robot.clone();
            let geometry = &mut changed.links[link].geometry;
            let place = match letter {
                Letter::Gamma => &mut geometry.gamma,
                Letter::B => &mut geometry.b,
                Letter::Beta => continue,
                Letter::Alpha => &mut geometry.alpha,
                Letter::D => &mut geometry.d,
                Letter::Theta => &mut geometry.theta,
                Letter::R => &mut geometry.r,
            };
            let given = place.number(&robot.symbols) + 0.01;
            *place = robot::value::parse(&format!("{given:?}"), &|_| None).unwrap();
            let pose = chain.pose(&q, &[0.0; 6], &values);
            assert!(apart(&pose, &Placed::of(&changed.link_poses(&q)[5])) < 1e-14, "{parameter:?}");
            checked += 1;
        }
        assert_eq!(checked, 36);
    }

    /// The twists are the derivatives of the pose. They are compared with central differences at random errors.
    #[test]
    fn twists_are_derivatives() {
        let robot = arm();
        let mut random = Random::new(3);
        for convention in [Convention::Dh, Convention::Frames] {
            let problem = problem(&robot, convention, MeasurementKind::Pose, 1, &mut random);
            let (chain, at) = (&problem.chain, truth(&problem, 0.5, 0.1, &mut random));
            let q: Vec<f64> = (0..6).map(|_| random.between(-2.0, 2.0)).collect();
            let torque: Vec<f64> = (0..6).map(|_| random.between(-2.0, 2.0)).collect();
            let found = chain.derivatives(&q, &torque, &at.chain);
            let step = 1e-5;
            for k in 0..chain.parameters.len() {
                let moved = |step: f64| {
                    let mut values = at.chain.clone();
                    values[k] += step;
                    chain.pose(&q, &torque, &values)
                };
                let (ahead, behind) = (moved(step), moved(-step));
                let velocity = (ahead.position - behind.position) / (2.0 * step);
                let spin = (ahead.rotation - behind.rotation) / (2.0 * step) * found.pose.rotation.transpose();
                // The error of a central difference: its step squared times the third derivative of a pose of this size.
                let limit = 1e-8;
                assert!((velocity - found.twists[k].at(&found.pose.position)).norm() < limit, "{k}");
                assert!((spin - found.twists[k].w.cross_matrix()).norm() < limit, "{k}");
            }
        }
    }
}
