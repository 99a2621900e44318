//! Transforms the ten inertial parameters between frames; defines the rigid bodies (parts) of a link.
//!
//! A body is given in frame b: inertia I_b about the origin of b, first moment h_b, mass m. R_ab and p = p_ab are orientation and
//! position of b in a. E is the identity matrix. With h = R_ab h_b, the parameters in frame a are
//! I_a = R_ab I_b R_ab^T + 2 (p . h) E - (p h^T + h p^T) + m (p . p E - p p^T)
//! h_a = h + m p
//! These equations are linear in the ten parameters. They follow from I = sum m (r . r E - r r^T) with r_a = R_ab r_b + p_ab (r:
//! position of a point mass m).

use crate::vector::{Vector3, dot, product, scaled, transposed, turned};

pub use crate::vector::Matrix3;

/// Pose of a frame b in a frame a: orientation `R_ab` and position `p_ab`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// R_ab, row by row. Column k is axis k of b, expressed in a.
    pub rotation: Matrix3,
    /// p_ab: the origin of b, expressed in a, m.
    pub position: [f64; 3],
}

impl Pose {
    /// The pose of a frame relative to itself.
    pub const IDENTITY: Pose =
        Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], position: [0.0; 3] };

    /// The transform aTc from `self` = aTb and `next` = bTc.
    #[inline]
    pub fn compose(&self, next: &Pose) -> Pose {
        let p = turned(&self.rotation, next.position);
        Pose { rotation: product(&self.rotation, &next.rotation), position: [0, 1, 2].map(|i| self.position[i] + p[i]) }
    }

    /// The inverse transform bTa from `self` = aTb.
    pub fn inverse(&self) -> Pose {
        let rotation = transposed(&self.rotation);
        Pose { rotation, position: turned(&rotation, self.position).map(|x| -x) }
    }
}

/// A rigid body that is part of a link, as the file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name of the body in the file (in a URDF: the link).
    pub name: String,
    /// Pose of the inertial frame in the link frame. The origin of the inertial frame is at the centre of mass.
    pub pose: Pose,
    /// Mass of the body, kg.
    pub mass: f64,
    /// Inertia about the centre of mass, in the axes of the inertial frame, kg m^2: xx xy xz yy yz zz.
    pub inertia: [f64; 6],
}

impl Part {
    /// The parameters XX XY XZ YY YZ ZZ MX MY MZ M of the body, about the origin of the link frame and in its axes.
    pub fn parameters(&self) -> [f64; 10] {
        let mut x = [0.0; 10];
        x[..6].copy_from_slice(&self.inertia);
        x[9] = self.mass;
        transform_inertial(&x, &self.pose)
    }

    /// The body with the ten `parameters` about the origin of the link frame. `rotation`: orientation of the body's inertial
    /// frame in the link frame. `None` if the mass is zero, because then there is no centre of mass.
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

/// Transforms the parameters XX .. M of a body from frame b to frame a. `x`: parameters about the origin of b, in b. `pose`:
/// pose of b in a.
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

/// The inertia xx xy xz yy yz zz in the axes of another frame. `rotation`: orientation of the given axes in this frame.
pub fn turned_inertia(six: &[f64; 6], rotation: &Matrix3) -> [f64; 6] {
    let mut x = [0.0; 10];
    x[..6].copy_from_slice(six);
    let [xx, xy, xz, yy, yz, zz, ..] = transform_inertial(&x, &Pose { position: [0.0; 3], rotation: *rotation });
    [xx, xy, xz, yy, yz, zz]
}

/// The 10 x 10 matrix (row by row) that does the same as [`transform_inertial`]: x_a = matrix x_b.
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
            // Allowance for the rounding of about thirty operations.
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
        // For point masses, sum m, sum m r, and sum m (r.r E - r r^T) are computed directly in both frames, for comparison.
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
