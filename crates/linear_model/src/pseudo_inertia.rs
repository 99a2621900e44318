//! The pseudo-inertia of a body: its ten parameters as a 4 x 4 matrix, which is positive definite for a distribution of mass.
//!
//! P = [[S, h], [h', m]] with the second moments S = tr(I)/2 1 - I, the first moments h and the mass m, all about the
//! origin of the link frame. P > 0 if and only if some distribution of positive mass has these parameters
//! [Wensing, Kim, Slotine 2018]. The condition means positive mass, positive definite inertia about the centre of mass,
//! and the triangle inequalities of the principal moments.
//!
//! The ten parameters have the order XX XY XZ YY YZ ZZ MX MY MZ M. XY is the entry of the inertia matrix, not the integral of x
//! y.

use nalgebra::{Matrix3, Matrix4, Vector3};

/// The ten parameters of a body: XX XY XZ YY YZ ZZ, kg m^2; MX MY MZ, kg m; M, kg.
pub type Ten = [f64; 10];

/// The pseudo-inertia matrix P of the ten parameters of a body.
#[inline]
pub fn pseudo_inertia(x: &Ten) -> Matrix4<f64> {
    let half = 0.5 * (x[0] + x[3] + x[5]);
    Matrix4::new(
        half - x[0],
        -x[1],
        -x[2],
        x[6], //
        -x[1],
        half - x[3],
        -x[4],
        x[7], //
        -x[2],
        -x[4],
        half - x[5],
        x[8], //
        x[6],
        x[7],
        x[8],
        x[9],
    )
}

/// The ten parameters of the body with the pseudo-inertia matrix P.
#[inline]
pub fn parameters(p: &Matrix4<f64>) -> Ten {
    let trace = p[(0, 0)] + p[(1, 1)] + p[(2, 2)];
    [
        trace - p[(0, 0)],
        -p[(0, 1)],
        -p[(0, 2)],
        trace - p[(1, 1)],
        -p[(1, 2)],
        trace - p[(2, 2)],
        p[(0, 3)],
        p[(1, 3)],
        p[(2, 3)],
        p[(3, 3)],
    ]
}

/// The smallest eigenvalue of the pseudo-inertia of a body. The eigenvalue has no single unit, because the entries of the
/// matrix have the units kg m^2, kg m and kg.
pub fn smallest_eigenvalue(x: &Ten) -> f64 {
    pseudo_inertia(x).symmetric_eigenvalues().min()
}

/// The mass, centre of mass, and inertia of a body about its centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centroidal {
    /// Mass, kg.
    pub mass: f64,
    /// Position of the centre of mass in the link frame, m.
    pub centre: [f64; 3],
    /// Inertia about the centre of mass in the axes of the link frame, kg m^2: xx xy xz yy yz zz.
    pub inertia: [f64; 6],
}

/// Mass, centre of mass, and inertia about the centre of mass, from the ten parameters of a body. `None` if the mass is not
/// positive.
///
/// I_c = I - m (c'c 1 - c c'), with the centre of mass c and the inertia I about the origin of the frame.
pub fn centroidal(x: &Ten) -> Option<Centroidal> {
    let mass = x[9];
    if mass <= 0.0 || !mass.is_finite() {
        return None;
    }
    let c = Vector3::new(x[6], x[7], x[8]) / mass;
    let about_origin = Matrix3::new(x[0], x[1], x[2], x[1], x[3], x[4], x[2], x[4], x[5]);
    let i = about_origin - mass * (Matrix3::identity() * c.dot(&c) - c * c.transpose());
    Some(Centroidal {
        mass,
        centre: [c[0], c[1], c[2]],
        inertia: [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn there_and_back() {
        let x = [1.0, 0.1, -0.2, 0.9, 0.3, 0.8, 0.5, -0.4, 0.2, 3.0];
        for (a, b) in parameters(&pseudo_inertia(&x)).into_iter().zip(x) {
            assert!((a - b).abs() < 1e-15);
        }
    }

    #[test]
    fn clouds_of_mass_are_positive_definite() {
        let mut random = Random::new(3);
        for _ in 0..50 {
            let mut p = Matrix4::zeros();
            for _ in 0..5 {
                let r = nalgebra::Vector4::new(random.normal(), random.normal(), random.normal(), 1.0);
                p += random.between(0.1, 2.0) * r * r.transpose();
            }
            let x = parameters(&p);
            assert!(smallest_eigenvalue(&x) > 0.0);
            let c = centroidal(&x).unwrap();
            let [xx, xy, xz, yy, yz, zz] = c.inertia;
            let mut moments = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigenvalues();
            moments.as_mut_slice().sort_by(f64::total_cmp);
            assert!(moments[0] + moments[1] > moments[2]);
        }
    }

    #[test]
    fn the_widely_copied_puma_link_three_is_no_body() {
        // Inertia (.066, .0125, .086) kg m^2 of link 3 of the PUMA 560 in Armstrong, Khatib, Burdick 1986. This inertia
        // violates the triangle inequality.
        let x = [0.066, 0.0, 0.0, 0.0125, 0.0, 0.086, 0.0, 0.0, 0.0, 4.8];
        assert!(smallest_eigenvalue(&x) < 0.0);
        assert!(centroidal(&[0.0; 10]).is_none());
    }
}
