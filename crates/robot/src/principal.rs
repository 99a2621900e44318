//! Principal moments and principal axes of inertia.

use crate::inertial::{Matrix3, Pose};
use crate::vector::{product, transposed};

/// Number of sweeps of Jacobi's method. A 3 x 3 matrix needs fewer sweeps to converge.
const JACOBI_SWEEPS: usize = 30;

/// Eigenvalues, in ascending order, of the symmetric matrix xx xy xz yy yz zz, and the matrix with the eigenvectors as
/// columns. They are computed by Jacobi's method.
pub(crate) fn principal_axes(&[xx, xy, xz, yy, yz, zz]: &[f64; 6]) -> ([f64; 3], Matrix3) {
    let mut a: Matrix3 = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let mut axes = Pose::IDENTITY.rotation;
    for _ in 0..JACOBI_SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let angle = 0.5 * (2.0 * a[p][q]).atan2(a[q][q] - a[p][p]);
            let (s, c) = angle.sin_cos();
            let mut turn = Pose::IDENTITY.rotation;
            (turn[p][p], turn[q][q], turn[p][q], turn[q][p]) = (c, c, s, -s);
            a = product(&product(&transposed(&turn), &a), &turn);
            axes = product(&axes, &turn);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
    (order.map(|i| a[i][i]), axes.map(|row| order.map(|i| row[i])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inertial::transform_inertial;
    use crate::vector::rotation_about;

    #[test]
    fn moments_and_axes_of_a_turned_body() {
        let x = [0.1, 0.0, 0.0, 0.25, 0.0, 0.2, 0.0, 0.0, 0.0, 0.0];
        let rotation = rotation_about([0.6, 0.0, 0.8], 1.1);
        let turned = transform_inertial(&x, &Pose { rotation, position: [0.0; 3] });
        let mut six = [0.0; 6];
        six.copy_from_slice(&turned[..6]);
        let (moments, axes) = principal_axes(&six);
        for (found, wanted) in moments.iter().zip([0.1, 0.2, 0.25]) {
            assert!((found - wanted).abs() < 1e-15, "{found} {wanted}");
        }
        for (found, of) in [(0, 0), (1, 2), (2, 1)] {
            let along: f64 = (0..3).map(|r| axes[r][found] * rotation[r][of]).sum();
            // Allowance for the rounding of 90 rotations.
            assert!((along.abs() - 1.0).abs() < 1e-13, "{along}");
        }
    }
}
