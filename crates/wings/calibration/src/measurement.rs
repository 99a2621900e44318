//! The measurements at the postures, and the values that a calibration predicts for these measurements.
//!
//! B: base of the robot in the frame of the measurements; C(q): last link in the base frame; R: orientation of the tool, and p_k:
//! measured points, in the frame of the last link; a: fixed point (anchor) in the base frame; s: radius of a sphere.
//! ```text
//! point k       B C(q) p_k
//! orientation   B C(q) R            (its residual is a rotation vector in the frame of the measurements)
//! distance      |C(q) p_1 - a|      (of a sphere: minus s, measured as 0)
//! ```
//! A robot may touch something at each posture instead of being measured. If it touches a plane, z of the point counts as
//! measured, with the value 0. If it touches a fixed point, x, y and z count as measured, with the value 0.
//!
//! A problem consists of the postures (joint positions with measurements), the chain to the measured link, and the list of all
//! parameters. Rows are the components of the residuals (measurement minus prediction), each a length or an angle.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

use crate::chain::{Chain, Placed, Twist, turned_by};
use crate::parameter::Parameter;

/// Rotations with a smaller cosine are near half a turn.
const LEAST_COSINE: f64 = -0.9;

/// The kind of the measurements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasurementKind {
    /// Orientation and position of the tool.
    Pose,
    /// Positions of this number of points of the last link.
    Points(usize),
    /// The distance between a point of the last link and a fixed point.
    Distance,
    /// A point of the last link stays on a sphere of unknown radius around a fixed point.
    Sphere,
}

impl MeasurementKind {
    /// Number of points of the last link.
    pub fn points(self) -> usize {
        if let MeasurementKind::Points(n) = self { n } else { 1 }
    }

    pub(crate) fn is_distance(self) -> bool {
        matches!(self, MeasurementKind::Distance | MeasurementKind::Sphere)
    }
}

/// A posture with its measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture {
    /// Line of the file; 0 if it has none.
    pub line: usize,
    /// Positions of the coordinates of the chain, rad (m).
    pub q: Vec<f64>,
    /// Holding torques of the coordinates of the chain, N m (N); zeros if they are not used.
    pub torque: Vec<f64>,
    /// Measured points, m. A component that is not measured is NaN.
    pub points: Vec<[f64; 3]>,
    /// Measured orientation.
    pub rotation: Option<Matrix3<f64>>,
    /// Measured distance, m.
    pub distance: Option<f64>,
}

/// The postures, the chain that reaches them, and the list of all parameters.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The chain to the measured link.
    pub chain: Chain,
    /// The kind of the measurements.
    pub kind: MeasurementKind,
    /// The postures.
    pub postures: Vec<Posture>,
    /// All parameters: first the unknowns of the measurement, then the parameters of the chain.
    pub parameters: Vec<Parameter>,
}

/// Values of all unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknowns {
    /// Base of the robot in the frame of the measurements.
    pub base: Placed,
    /// The fixed point in the base frame, m.
    pub anchor: Vector3<f64>,
    /// Radius of a sphere, m.
    pub radius: f64,
    /// The measured points in the frame of the last link, m.
    pub points: Vec<Vector3<f64>>,
    /// The orientation of the tool in the frame of the last link.
    pub tool: Matrix3<f64>,
    /// The parameters of the chain.
    pub chain: Vec<f64>,
}

/// Whether a residual is a length or an angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResidualKind {
    /// A length, m.
    Length,
    /// An angle, rad.
    Angle,
}

/// The residuals of some postures with their derivatives.
pub struct Linearised {
    /// Derivatives of the predictions by all parameters.
    pub jacobian: DMatrix<f64>,
    /// Measurement minus prediction.
    pub residual: DVector<f64>,
    /// Length or angle, one per row.
    pub kinds: Vec<ResidualKind>,
    /// The posture of each row.
    pub posture: Vec<usize>,
}

impl Problem {
    /// The problem of these postures.
    pub fn new(chain: Chain, kind: MeasurementKind, postures: Vec<Posture>) -> Problem {
        let axes = 0..3;
        let mut parameters = Vec::new();
        match kind {
            MeasurementKind::Distance | MeasurementKind::Sphere => {
                parameters.extend(axes.clone().map(|axis| Parameter::Anchor { axis }));
                parameters.extend((kind == MeasurementKind::Sphere).then_some(Parameter::Radius));
            }
            _ => parameters.extend((0..6).map(|axis| Parameter::Base { axis })),
        }
        for point in 0..kind.points() {
            parameters.extend(axes.clone().map(|axis| Parameter::Point { point, axis }));
        }
        if kind == MeasurementKind::Pose {
            parameters.extend(axes.map(|axis| Parameter::Tool { axis }));
        }
        parameters.extend(chain.parameters.iter().copied());
        Problem { chain, kind, postures, parameters }
    }

    /// A problem with the same chain and kind of measurement, but with other postures.
    pub fn with(&self, postures: Vec<Posture>) -> Problem {
        Problem { postures, ..self.clone() }
    }

    /// Number of unknowns of the measurement.
    pub(crate) fn frames(&self) -> usize {
        self.parameters.len() - self.chain.parameters.len()
    }

    /// Unknowns with frames at the origin and without errors of the chain.
    pub fn nominal(&self) -> Unknowns {
        Unknowns {
            base: Placed::identity(),
            anchor: Vector3::zeros(),
            radius: 0.0,
            points: vec![Vector3::zeros(); self.kind.points()],
            tool: Matrix3::identity(),
            chain: vec![0.0; self.chain.parameters.len()],
        }
    }

    /// The residuals of all postures with their derivatives by all parameters.
    pub fn linearised(&self, at: &Unknowns) -> Linearised {
        let all: Vec<usize> = (0..self.postures.len()).collect();
        self.linearised_of(at, &all)
    }

    /// The residuals of the postures `of` with their derivatives.
    pub fn linearised_of(&self, at: &Unknowns, of: &[usize]) -> Linearised {
        let p = self.parameters.len();
        let (mut rows, mut residual, mut kinds, mut posture) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for &r in of {
            for (e, kind, row) in self.rows(&self.postures[r], at) {
                rows.extend(row);
                residual.push(e);
                kinds.push(kind);
                posture.push(r);
            }
        }
        let jacobian = DMatrix::from_row_slice(residual.len(), p, &rows);
        Linearised { jacobian, residual: DVector::from_vec(residual), kinds, posture }
    }

    /// The residuals of the postures `of`, with the kind and the posture of each.
    pub fn residuals_of(&self, at: &Unknowns, of: &[usize]) -> Vec<(f64, ResidualKind, usize)> {
        let mut all = Vec::new();
        for &r in of {
            let posture = &self.postures[r];
            let link = self.chain.pose(&posture.q, &posture.torque, &at.chain);
            if self.kind.is_distance() {
                let length = (link.at(&at.points[0]) - at.anchor).norm() - at.radius;
                all.push((posture.distance.unwrap_or(0.0) - length, ResidualKind::Length, r));
                continue;
            }
            let pose = at.base.then(&link);
            for (measured, own) in posture.points.iter().zip(&at.points) {
                let place = pose.at(own);
                let axes = (0..3).filter(|&axis| measured[axis].is_finite());
                all.extend(axes.map(|axis| (measured[axis] - place[axis], ResidualKind::Length, r)));
            }
            if let Some(measured) = posture.rotation {
                let own = pose.rotation * at.tool;
                let error = rotation_vector(&(measured * own.transpose()));
                all.extend((0..3).map(|axis| (error[axis], ResidualKind::Angle, r)));
            }
        }
        all
    }

    /// The rows of one posture: residual, kind, derivatives by all parameters.
    fn rows(&self, posture: &Posture, at: &Unknowns) -> Vec<(f64, ResidualKind, Vec<f64>)> {
        let link = self.chain.derivatives(&posture.q, &posture.torque, &at.chain);
        let mut rows = Vec::new();
        if self.kind.is_distance() {
            rows.push(self.distance_row(posture, at, &link.pose, &link.twists));
            return rows;
        }
        let pose = at.base.then(&link.pose);
        // The parameters of the chain move the last link in the base frame.
        let turned = |v: Vector3<f64>| at.base.rotation * v;
        for (k, (measured, own)) in posture.points.iter().zip(&at.points).enumerate() {
            let in_base = link.pose.at(own);
            let place = at.base.at(&in_base);
            let column = |parameter: &Parameter| match *parameter {
                Parameter::Base { axis: axis @ 0..3 } => unit(axis),
                Parameter::Base { axis } => unit(axis - 3).cross(&(place - at.base.position)),
                Parameter::Point { point, axis } if point == k => pose.rotation * unit(axis),
                _ => Vector3::zeros(),
            };
            let frames = self.parameters[..self.frames()].iter().map(column);
            let columns: Vec<Vector3<f64>> =
                frames.chain(link.twists.iter().map(|twist| turned(twist.at(&in_base)))).collect();
            for axis in (0..3).filter(|&axis| measured[axis].is_finite()) {
                let row = columns.iter().map(|c| c[axis]).collect();
                rows.push((measured[axis] - place[axis], ResidualKind::Length, row));
            }
        }
        if let Some(measured) = posture.rotation {
            let own = pose.rotation * at.tool;
            let error = rotation_vector(&(measured * own.transpose()));
            let column = |parameter: &Parameter| match *parameter {
                Parameter::Base { axis: axis @ 3.. } => unit(axis - 3),
                Parameter::Tool { axis } => own * unit(axis),
                _ => Vector3::zeros(),
            };
            let frames = self.parameters[..self.frames()].iter().map(column);
            let columns: Vec<Vector3<f64>> = frames.chain(link.twists.iter().map(|twist| turned(twist.w))).collect();
            rows.extend(
                (0..3).map(|axis| (error[axis], ResidualKind::Angle, columns.iter().map(|c| c[axis]).collect())),
            );
        }
        rows
    }

    fn distance_row(
        &self,
        posture: &Posture,
        at: &Unknowns,
        pose: &Placed,
        twists: &[Twist],
    ) -> (f64, ResidualKind, Vec<f64>) {
        let place = pose.at(&at.points[0]);
        let offset = place - at.anchor;
        let length = offset.norm();
        let direction = offset / length.max(f64::MIN_POSITIVE);
        let column = |parameter: &Parameter| match *parameter {
            Parameter::Anchor { axis } => -direction[axis],
            Parameter::Radius => -1.0,
            Parameter::Point { axis, .. } => direction.dot(&(pose.rotation * unit(axis))),
            _ => 0.0,
        };
        let frames = self.parameters[..self.frames()].iter().map(column);
        let row = frames.chain(twists.iter().map(|twist| direction.dot(&twist.at(&place)))).collect();
        (posture.distance.unwrap_or(0.0) - (length - at.radius), ResidualKind::Length, row)
    }

    /// The unknowns after a step of all parameters.
    pub fn moved(&self, at: &Unknowns, step: &[f64]) -> Unknowns {
        let mut next = at.clone();
        let (mut base_turn, mut tool_turn) = (Vector3::zeros(), Vector3::zeros());
        for (parameter, x) in self.parameters.iter().zip(step) {
            match *parameter {
                Parameter::Base { axis: axis @ 0..3 } => next.base.position[axis] += x,
                Parameter::Base { axis } => base_turn[axis - 3] = *x,
                Parameter::Anchor { axis } => next.anchor[axis] += x,
                Parameter::Radius => next.radius += x,
                Parameter::Point { point, axis } => next.points[point][axis] += x,
                Parameter::Tool { axis } => tool_turn[axis] = *x,
                _ => {}
            }
        }
        next.base.rotation = turned_by(base_turn) * at.base.rotation;
        next.tool = at.tool * turned_by(tool_turn);
        let of_chain = step.iter().skip(self.frames());
        next.chain.iter_mut().zip(of_chain).for_each(|(value, x)| *value += x);
        next
    }
}

/// The rotation vector of a rotation matrix, rad. The sine is exact for small angles, where the cosine is not.
fn rotation_vector(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let skew = 0.5 * (rotation - rotation.transpose());
    let sines = Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]);
    let (sine, cosine) = (sines.norm(), 0.5 * (rotation.trace() - 1.0));
    if cosine < LEAST_COSINE {
        // Near half a turn, the sine does not give the axis.
        return Rotation3::from_matrix_unchecked(*rotation).scaled_axis();
    }
    let angle = sine.atan2(cosine);
    if sine > 0.0 { angle / sine * sines } else { sines }
}

fn unit(axis: usize) -> Vector3<f64> {
    Vector3::ith(axis, 1.0)
}
