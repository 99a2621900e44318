//! Frames as products of six elementary transforms, and vectors in space. Their entries are [`Number`]s, which carry derivatives.
//!
//! J: inertia of a body; R: rotation of its frame.

use robot::{JointKind, ModifiedDh, Robot, Value};

use crate::number::Number;

pub type Vector = [Number; 3];
pub type Matrix = [[Number; 3]; 3];

#[derive(Clone, Copy)]
pub struct Frame {
    pub rotation: Matrix,
    pub origin: Vector,
}

const ONE: Number = Number::constant(1.0);
const ZERO: Number = Number::ZERO;

pub const BASE: Frame =
    Frame { rotation: [[ONE, ZERO, ZERO], [ZERO, ONE, ZERO], [ZERO, ZERO, ONE]], origin: [ZERO; 3] };

impl Frame {
    fn then(self, rotation: Matrix, translation: Vector) -> Frame {
        let moved = turned(&self.rotation, translation);
        Frame { rotation: product(&self.rotation, &rotation), origin: sum(self.origin, moved) }
    }

    pub fn about_x(self, angle: Number) -> Frame {
        let (s, c) = (angle.sin(), angle.cos());
        self.then([[ONE, ZERO, ZERO], [ZERO, c, -s], [ZERO, s, c]], [ZERO; 3])
    }

    pub fn about_z(self, angle: Number) -> Frame {
        let (s, c) = (angle.sin(), angle.cos());
        self.then([[c, -s, ZERO], [s, c, ZERO], [ZERO, ZERO, ONE]], [ZERO; 3])
    }

    pub fn along_x(self, length: Number) -> Frame {
        self.then(BASE.rotation, [length, ZERO, ZERO])
    }

    pub fn along_z(self, length: Number) -> Frame {
        self.then(BASE.rotation, [ZERO, ZERO, length])
    }

    /// The frame Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r) relative to this frame. The joint variable is added to theta or
    /// r.
    pub fn placed(self, robot: &Robot, g: &ModifiedDh, kind: JointKind, variable: Number) -> Frame {
        let number = |v: &Value| Number::constant(v.number(&robot.symbols));
        let (angle, length) = match kind {
            JointKind::Revolute => (variable, ZERO),
            JointKind::Prismatic => (ZERO, variable),
            JointKind::Fixed => (ZERO, ZERO),
        };
        self.about_z(number(&g.gamma))
            .along_z(number(&g.b))
            .about_x(number(&g.alpha))
            .along_x(number(&g.d))
            .about_z(number(&g.theta) + angle)
            .along_z(number(&g.r) + length)
    }

    pub fn axis(&self) -> Vector {
        self.rotation.map(|row| row[2])
    }
}

/// The joint variables, each the sum of c_k q_k over the coordinates plus an offset. If the numbers q carry derivatives, the
/// results do too.
pub fn joint_variables(robot: &Robot, q: &[Number]) -> Vec<Number> {
    let of_link = |link: &robot::Link| {
        let offset = Number::constant(link.joint.variable.offset.number(&robot.symbols));
        link.joint.variable.terms.iter().fold(offset, |sum, &(k, c)| sum + Number::constant(c) * q[k.0])
    };
    robot.links.iter().map(of_link).collect()
}

pub fn joint_rates(robot: &Robot, dq: &[Number]) -> Vec<Number> {
    let of_link = |link: &robot::Link| {
        link.joint.variable.terms.iter().fold(ZERO, |sum, &(k, c)| sum + Number::constant(c) * dq[k.0])
    };
    robot.links.iter().map(of_link).collect()
}

pub fn constants(x: [f64; 3]) -> Vector {
    x.map(Number::constant)
}

pub fn sum(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] + b[i])
}

pub fn scaled(a: Vector, factor: Number) -> Vector {
    a.map(|x| x * factor)
}

pub fn inner(a: Vector, b: Vector) -> Number {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn turned(m: &Matrix, v: Vector) -> Vector {
    m.map(|row| inner(row, v))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

/// R J R^T v: the inertia J times the vector v in the base frame. J: inertia `body` = XX XY XZ YY YZ ZZ .. in the frame with the
/// rotation R.
pub fn inertia_times(rotation: &Matrix, body: &[f64; 10], v: Vector) -> Vector {
    let [xx, xy, xz, yy, yz, zz] = [0, 1, 2, 3, 4, 5].map(|i| Number::constant(body[i]));
    let local = [0, 1, 2].map(|j| inner([rotation[0][j], rotation[1][j], rotation[2][j]], v));
    let moment = turned(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], local);
    turned(rotation, moment)
}
