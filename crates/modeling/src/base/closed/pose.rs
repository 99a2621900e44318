//! Poses of frames (rotation and position) with entries in a finite field, in which the loops of a robot are closed without
//! rounding.

use crate::base::field::{CirclePoint, Residue};
use crate::kinematics::loop_chain::PLACEMENT;

pub(crate) type ExactVector = [Residue; 3];
/// A 3 x 3 matrix over the finite field, as its rows.
pub(crate) type ExactMatrix = [ExactVector; 3];

const ZERO: Residue = Residue::ZERO;
const ONE: Residue = Residue::ONE;

pub(crate) const UNTURNED: ExactMatrix = [[ONE, ZERO, ZERO], [ZERO, ONE, ZERO], [ZERO, ZERO, ONE]];

/// Pose [R p] of a frame in another frame: rotation R and position p.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub rotation: ExactMatrix,
    pub position: ExactVector,
}

impl Pose {
    pub(crate) const IDENTITY: Pose = Pose { rotation: UNTURNED, position: [ZERO; 3] };

    /// The pose Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r) of a link, from its nine entries in the order of
    /// [`crate::kinematics::loop_chain`].
    pub(crate) fn placement(entries: &[Residue]) -> Pose {
        let [cg, sg, b, ca, sa, d, ct, st, r] = <[Residue; PLACEMENT]>::try_from(entries).unwrap_or_default();
        let gamma = Pose { rotation: about_z((cg, sg)), position: [ZERO, ZERO, b] };
        let alpha = Pose { rotation: [[ONE, ZERO, ZERO], [ZERO, ca, -sa], [ZERO, sa, ca]], position: [ZERO; 3] };
        let theta = Pose { rotation: about_z((ct, st)), position: [d, ZERO, r] };
        gamma.then(&alpha).then(&theta)
    }

    pub(crate) fn then(&self, next: &Pose) -> Pose {
        let moved = turned(&self.rotation, next.position);
        let position = [0, 1, 2].map(|i| self.position[i] + moved[i]);
        Pose { rotation: product(&self.rotation, &next.rotation), position }
    }
}

/// The matrix of the rotation about z by the angle with (cos, sin) = (c, s).
pub(crate) fn about_z((c, s): CirclePoint) -> ExactMatrix {
    [[c, -s, ZERO], [s, c, ZERO], [ZERO, ZERO, ONE]]
}

pub(crate) fn dot(a: ExactVector, b: ExactVector) -> Residue {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn turned(m: &ExactMatrix, v: ExactVector) -> ExactVector {
    m.map(|row| dot(row, v))
}

pub(crate) fn transposed(m: &ExactMatrix) -> ExactMatrix {
    [0, 1, 2].map(|c| [0, 1, 2].map(|r| m[r][c]))
}

pub(crate) fn product(a: &ExactMatrix, b: &ExactMatrix) -> ExactMatrix {
    let columns = transposed(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

/// Column c of a 3 x 3 matrix.
pub(crate) fn column(m: &ExactMatrix, c: usize) -> ExactVector {
    [0, 1, 2].map(|r| m[r][c])
}
