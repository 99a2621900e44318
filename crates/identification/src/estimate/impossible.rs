//! Finds identified base parameters that are negative although they would be positive or zero for all physically consistent
//! bodies.
//!
//! A base parameter is X_k = sum over bodies of tr(A P) + sum over rotors of c IA. P: pseudo-inertia of a body, positive
//! semidefinite; IA: rotor inertia, IA >= 0; A, c: coefficients of X_k. If every A is positive semidefinite and no c is
//! negative, X_k cannot be negative. Examples: a mass, a rotor inertia, the inertia of several bodies together.

use linear_model::parameter::ParameterId;
use linear_model::standard_map::StandardMap;
use nalgebra::Matrix4;

use crate::estimate::artefact::Estimate;
use crate::estimate::digits::significant;

/// A parameter is significantly negative if it is below -4 sigma. With normal errors and a dozen parameters near zero, a
/// parameter is below -4 sigma by chance in fewer than one of a thousand estimates.
const NEGATIVE_SIGMAS: f64 = 4.0;

/// A coefficient matrix A counts as positive semidefinite if no eigenvalue is below minus this share of the largest coefficient
/// of the base parameter. The small share allows for rounding.
const NEGATIVE_EIGENVALUE_SHARE: f64 = 1e-9;

/// Sentences on base parameters that are significantly negative although they would be positive or zero for all physically
/// consistent bodies.
pub fn impossible(map: &StandardMap, estimate: &Estimate) -> Vec<String> {
    let base = estimate.parameters.iter().filter(|p| matches!(p.id, ParameterId::Base(_)));
    let found = base.take(map.matrix.nrows()).enumerate().filter_map(|(k, p)| {
        let (value, sigma) = (p.value?, p.sigma?);
        (value < -NEGATIVE_SIGMAS * sigma && cannot_be_negative(map, k)).then(|| {
            let (value, sigma) = (significant(value), significant(sigma));
            format!("{} is {value} +- {sigma} {}, and no bodies give less than zero", p.id, p.unit)
        })
    });
    found.collect()
}

/// Whether base parameter X_k = sum tr(A P) + sum c IA is non-negative for all physically consistent bodies: every matrix A
/// is positive semidefinite, and every coefficient c of a rotor is non-negative.
fn cannot_be_negative(map: &StandardMap, k: usize) -> bool {
    let least = -NEGATIVE_EIGENVALUE_SHARE * map.matrix.row(k).amax();
    let is_possible =
        |(_, first): &(String, usize)| weights(|i| map.matrix[(k, first + i)]).symmetric_eigenvalues().min() >= least;
    map.bodies.iter().all(is_possible) && map.rotors.iter().all(|&c| map.matrix[(k, c)] >= 0.0)
}

/// The matrix A of a body with pseudo-inertia P: tr(A P) = sum_i c(i) phi_i. c: coefficients of the body's parameters phi = XX
/// XY XZ YY YZ ZZ MX MY MZ M (i from 0 to 9).
fn weights(c: impl Fn(usize) -> f64) -> Matrix4<f64> {
    let [xy, xz, yz, x, y, z] = [-c(1), -c(2), -c(4), c(6), c(7), c(8)].map(|c| 0.5 * c);
    let [xx, yy, zz, m] = [c(3) + c(5), c(0) + c(5), c(0) + c(3), c(9)];
    Matrix4::new(xx, xy, xz, x, xy, yy, yz, y, xz, yz, zz, z, x, y, z, m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::identified::{Deviations, Identified};
    use linear_model::pseudo_inertia::{Ten, parameters};
    use linear_model::unit::Unit;
    use nalgebra::DMatrix;
    use random::Random;

    /// A map from one body and one rotor to one base parameter.
    fn map(of_body: Ten, rotor: f64) -> StandardMap {
        let standard = (0..11).map(|i| format!("P{i}")).collect();
        let matrix = DMatrix::from_fn(1, 11, |_, c| if c < 10 { of_body[c] } else { rotor });
        StandardMap { standard, matrix, bodies: vec![("body".into(), 0)], rotors: vec![10] }
    }

    #[test]
    fn the_sign_is_that_of_drawn_bodies() {
        let mut random = Random::new(3);
        let mut of = |columns: &[(usize, f64)]| {
            let mut c = [0.0; 10];
            columns.iter().for_each(|&(i, x)| c[i] = x);
            let value = |root: Matrix4<f64>| {
                let ten = parameters(&(root * root.transpose()));
                ten.iter().zip(c).map(|(x, c)| x * c).sum::<f64>()
            };
            let drawn =
                (0..2000).map(|_| value(Matrix4::from_fn(|_, _| random.normal()))).fold(f64::INFINITY, f64::min);
            // Random bodies rarely reach the smallest value of the base parameter. The body that is made from the eigenvector
            // of the smallest eigenvalue reaches this value.
            let eigen = weights(|i| c[i]).symmetric_eigen();
            let last = eigen.eigenvectors.column(eigen.eigenvalues.imin());
            let least = drawn.min(value(Matrix4::from_fn(|i, j| if j == 0 { last[i] } else { 0.0 })));
            (cannot_be_negative(&map(c, 1.0), 0), least)
        };
        // Cases that cannot be negative: ZZ, a mass, ZZ about an axis at a distance of one metre, and a combination of
        // moments and a product of inertia.
        for columns in [&[(5, 1.0)][..], &[(9, 1.0)], &[(5, 1.0), (6, 2.0), (9, 1.0)], &[(0, 1.0), (3, 1.0), (1, 1.9)]]
        {
            let (is_certain, least) = of(columns);
            // The smallest value belongs to a point mass on the axis. This value is zero, up to rounding.
            assert!(is_certain && least > -1e-12, "{columns:?}: {least}");
        }
        for columns in [&[(0, 1.0), (3, -1.0)][..], &[(6, 1.0)], &[(5, 1.0), (6, 2.1), (9, 1.0)], &[(4, 1.0)]] {
            let (is_certain, least) = of(columns);
            assert!(!is_certain && least < -1e-3, "{columns:?}: {least}");
        }
        let mut c = [0.0; 10];
        c[5] = 1.0;
        assert!(!cannot_be_negative(&map(c, -1.0), 0));
    }

    #[test]
    fn only_what_is_surely_negative_is_named() {
        let mut c = [0.0; 10];
        c[5] = 1.0;
        let of = |value: f64, sigma: f64| {
            let parameter = Identified::new("ZZR1".parse().unwrap(), Unit::INERTIA, value, Deviations::white(sigma));
            impossible(&map(c, 1.0), &Estimate { parameters: vec![parameter], ..Estimate::default() })
        };
        assert_eq!(of(-0.09, 0.01), ["ZZR1 is -0.0900 +- 0.0100 kg m^2, and no bodies give less than zero"]);
        assert!(of(-0.09, 0.03).is_empty() && of(0.09, 0.01).is_empty());
    }
}
