//! The ten inertial parameters under a change of frame, and the parts a file lumps into a link.

/// Placement of a frame b in a frame a: `R_ab` orientation (rows), `p_ab` position, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    pub rotation: [[f64; 3]; 3],
    pub position: [f64; 3],
}

impl Pose {
    pub const IDENTITY: Pose =
        Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], position: [0.0; 3] };

    /// aTc from `self` = aTb and `next` = bTc.
    pub fn compose(&self, next: &Pose) -> Pose {
        let p = turn(&self.rotation, next.position);
        Pose { rotation: product(&self.rotation, &next.rotation), position: [0, 1, 2].map(|i| self.position[i] + p[i]) }
    }

    /// bTa from `self` = aTb.
    pub fn inverse(&self) -> Pose {
        let rotation = transposed(&self.rotation);
        Pose { rotation, position: turn(&rotation, self.position).map(|x| -x) }
    }
}

/// Three rows of three.
pub type Matrix3 = [[f64; 3]; 3];

pub(crate) fn turn(m: &Matrix3, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

pub(crate) fn product(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

pub(crate) fn transposed(m: &Matrix3) -> Matrix3 {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[j][i]))
}

/// A rigid part of a link, as its file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The part's name in the file (a URDF link).
    pub name: String,
    /// Its inertial frame (origin at the centre of mass) in the link frame.
    pub pose: Pose,
    /// kg.
    pub mass: f64,
    /// Inertia about the centre of mass, in the inertial frame, kg m^2: xx xy xz yy yz zz.
    pub inertia: [f64; 6],
}
