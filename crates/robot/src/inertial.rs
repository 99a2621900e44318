//! The ten inertial parameters under a change of frame, and the rigid parts of a link.
//!
//! For a body seen from frame b (inertia I_b about the origin of b, first moment h_b, mass m) and
//! the placement (R_ab, p_ab) of b in a, with h = R_ab h_b:
//! I_a = R_ab I_b R_ab^T + 2 (p . h) E - (p h^T + h p^T) + m (p . p E - p p^T)
//! h_a = h + m p
//! which is linear in the ten parameters: from sum m (r . r E - r r^T) with r_a = R_ab r_b + p_ab.

use crate::vector::{Vector3, dot, product, scaled, transposed, turned};

pub use crate::vector::Matrix3;

/// Placement of a frame b in a frame a: `R_ab` orientation (rows), `p_ab` position, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// R_ab, row by row: column k is axis k of b in a.
    pub rotation: Matrix3,
    /// p_ab: the origin of b in a, m.
    pub position: [f64; 3],
}

impl Pose {
    /// The placement of a frame in itself.
    pub const IDENTITY: Pose =
        Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], position: [0.0; 3] };

    /// aTc from `self` = aTb and `next` = bTc.
    #[inline]
    pub fn compose(&self, next: &Pose) -> Pose {
        let p = turned(&self.rotation, next.position);
        Pose { rotation: product(&self.rotation, &next.rotation), position: [0, 1, 2].map(|i| self.position[i] + p[i]) }
    }

    /// bTa from `self` = aTb.
    pub fn inverse(&self) -> Pose {
        let rotation = transposed(&self.rotation);
        Pose { rotation, position: turned(&rotation, self.position).map(|x| -x) }
    }
}

/// A rigid part of a link, from its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The part's name in the file (a URDF link).
    pub name: String,
    /// The pose of its inertial frame (origin at the centre of mass) in the link frame.
    pub pose: Pose,
    /// Mass, kg.
    pub mass: f64,
    /// Inertia about the centre of mass, in the inertial frame, kg m^2: xx xy xz yy yz zz.
    pub inertia: [f64; 6],
}

impl Part {
    /// XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the link frame, in the link frame.
    pub fn parameters(&self) -> [f64; 10] {
        let mut x = [0.0; 10];
        x[..6].copy_from_slice(&self.inertia);
        x[9] = self.mass;
        transform_inertial(&x, &self.pose)
    }

    /// The part with the ten `parameters` about the origin of the link frame, where `rotation` is the orientation of its
    /// inertial frame in the link frame. `None` without a mass, when no centre exists.
    pub(crate) fn from_parameters(name: String, parameters: &[f64; 10], rotation: Matrix3) -> Option<Part> {
        let mass = parameters[9];
        if mass == 0.0 {
            return None;
        }
        let centre = [0, 1, 2].map(|i| parameters[6 + i] / mass);
        let pose = Pose { rotation, position: centre };
        let about_centre = transform_inertial(parameters, &pose.inverse());
        let inertia: [f64; 6] = std::array::from_fn(|k| about_centre[k]);
        Some(Part { name, pose, mass, inertia })
    }
}

/// XX .. M of a body about and in frame a, from its XX .. M `x` about and in frame b; `pose` is
/// the placement of b in a.
pub fn transform_inertial(x: &[f64; 10], pose: &Pose) -> [f64; 10] {
    let [xx, xy, xz, yy, yz, zz, mx, my, mz, m] = *x;
    let r = &pose.rotation;
    let p: Vector3 = pose.position;
    let inertia = product(&product(r, &[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), &transposed(r));
    let h = turned(r, [mx, my, mz]);
    let trace = 2.0 * dot(p, h) + m * dot(p, p);
    let entry = |i: usize, j: usize| {
        let diagonal = if i == j { trace } else { 0.0 };
        inertia[i][j] + diagonal - (p[i] * h[j] + h[i] * p[j]) - m * p[i] * p[j]
    };
    let [mx, my, mz] = [0, 1, 2].map(|i| h[i] + scaled(p, m)[i]);
    [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2), mx, my, mz, m]
}

/// The 10 x 10 matrix (rows) of [`transform_inertial`]: x_a = matrix x_b.
pub fn inertial_matrix(pose: &Pose) -> [[f64; 10]; 10] {
    let mut matrix = [[0.0; 10]; 10];
    for j in 0..10 {
        let mut unit = [0.0; 10];
        unit[j] = 1.0;
        let column = transform_inertial(&unit, pose);
        for i in 0..10 {
            matrix[i][j] = column[i];
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::rotation_about;

    fn pose(k: f64) -> Pose {
        let axis = scaled([1.0, -2.0, 0.5 * k], 1.0 / (5.0 + 0.25 * k * k).sqrt());
        Pose { rotation: rotation_about(axis, 0.7 + k), position: [0.3, -0.2 * k, 0.5] }
    }

    const X: [f64; 10] = [0.31, -0.02, 0.05, 0.42, 0.03, 0.27, 0.4, -0.3, 0.9, 2.5];

    fn close(a: &[f64], b: &[f64]) {
        let scale = b.iter().fold(0.0f64, |s, x| s.max(x.abs()));
        for (a, b) in a.iter().zip(b) {
            // Rounding of about thirty operations.
            assert!((a - b).abs() <= 1e-14 * scale, "{a} {b}");
        }
    }

    #[test]
    fn two_changes_are_one() {
        let twice = transform_inertial(&transform_inertial(&X, &pose(1.0)), &pose(2.0));
        close(&transform_inertial(&X, &pose(2.0).compose(&pose(1.0))), &twice);
    }

    #[test]
    fn point_masses_give_their_sums() {
        // sum m, sum m r, sum m (r.r E - r r^T), in both frames.
        let masses = [(1.5, [0.1, 0.2, -0.3]), (0.4, [-0.5, 0.1, 0.7]), (2.0, [0.3, -0.6, 0.2])];
        let sums = |place: &dyn Fn(Vector3) -> Vector3| {
            let mut x = [0.0; 10];
            for (m, r) in masses {
                let r = place(r);
                let e = |i: usize, j: usize| m * (if i == j { dot(r, r) } else { 0.0 } - r[i] * r[j]);
                let of_mass = [e(0, 0), e(0, 1), e(0, 2), e(1, 1), e(1, 2), e(2, 2), m * r[0], m * r[1], m * r[2], m];
                for i in 0..10 {
                    x[i] += of_mass[i];
                }
            }
            x
        };
        let pose = pose(2.0);
        let moved = sums(&|r| [0, 1, 2].map(|i| turned(&pose.rotation, r)[i] + pose.position[i]));
        close(&transform_inertial(&sums(&|r| r), &pose), &moved);
    }

    #[test]
    fn the_matrix_is_the_map() {
        let matrix = inertial_matrix(&pose(1.0));
        let x: Vec<f64> = matrix.iter().map(|row| row.iter().zip(&X).map(|(a, b)| a * b).sum()).collect();
        close(&x, &transform_inertial(&X, &pose(1.0)));
    }

    #[test]
    fn parts_survive_the_round_trip() {
        let part = Part { name: "p".into(), pose: pose(3.0), mass: 2.0, inertia: [0.3, 0.01, 0.02, 0.4, 0.03, 0.5] };
        let back = Part::from_parameters("p".into(), &part.parameters(), part.pose.rotation).unwrap();
        close(&back.inertia, &part.inertia);
        close(&back.pose.position, &part.pose.position);
        assert!(Part::from_parameters("p".into(), &[0.0; 10], part.pose.rotation).is_none());
    }
}
