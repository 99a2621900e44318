//! Estimates the force and the moment of a contact, if the touched link is known.
//!
//! ```text
//! r = J' F + e          J: Jacobian of the link's frame (6 x n); F: force, then moment at its origin, in its axes
//! cov(F) = inv(J S^-2 J' + P^-2)
//! ```
//! r: external torques without the torque of a load; e: their errors; S: standard deviations of e; P: prior standard
//! deviations of F, from the largest forces and moments that are possible. A component of F is not determined if its standard
//! deviation is more than a tenth of its prior standard deviation. This happens if the link has fewer than six joints before
//! it, or if the posture is singular. If the contact is on another link, or at several places, the misfit is large.

use nalgebra::{Matrix6, Vector6};

/// Prior standard deviation of a force, N: the largest possible size.
const POSSIBLE_FORCE: f64 = 1000.0;
/// Prior standard deviation of a moment, N m: the largest possible size.
const POSSIBLE_MOMENT: f64 = 300.0;
/// A component is determined if its standard deviation is below this share of its prior standard deviation.
const DETERMINED_SHARE: f64 = 0.1;

/// Force and moment that the environment exerts on a link, at the origin of its frame and in its axes.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactWrench {
    /// Force, N, then moment, N m; `None` for a component that the torques do not determine.
    pub components: [Option<f64>; 6],
    /// Standard deviation of each component.
    pub sigma: [f64; 6],
    /// Mean square of the normalised residual of the torques. It is about 1 if the contact is on this link. `None` if there
    /// are not more joints than determined components.
    pub misfit: Option<f64>,
}

impl ContactWrench {
    /// Estimates force and moment. `jacobian`: J, row by row; `torques`: r, one per joint; `deviations`: standard deviations of
    /// e.
    pub(crate) fn new(jacobian: &[f64], torques: &[f64], deviations: &[f64]) -> ContactWrench {
        let n = torques.len();
        let possible = |c: usize| if c < 3 { POSSIBLE_FORCE } else { POSSIBLE_MOMENT };
        let mut information = Matrix6::from_diagonal(&Vector6::from_fn(|c, _| possible(c).powi(-2)));
        let mut right = Vector6::zeros();
        for j in 0..n {
            let column = Vector6::from_fn(|c, _| jacobian[c * n + j] / deviations[j]);
            information += column * column.transpose();
            right += column * (torques[j] / deviations[j]);
        }
        // The matrix is positive definite, because the prior standard deviations are finite.
        let covariance = information.cholesky().map_or(Matrix6::identity() * f64::INFINITY, |found| found.inverse());
        let wrench = covariance * right;
        let sigma: [f64; 6] = std::array::from_fn(|c| covariance[(c, c)].sqrt());
        let is_determined = |c: usize| sigma[c] < DETERMINED_SHARE * possible(c);
        let moved = (0..n).filter(|j| (0..6).any(|c| jacobian[c * n + j] != 0.0));
        let residuals = moved.map(|j| {
            let explained: f64 = (0..6).map(|c| jacobian[c * n + j] * wrench[c]).sum();
            ((torques[j] - explained) / deviations[j]).powi(2)
        });
        let (sum, joints) = residuals.fold((0.0, 0), |(sum, count), square| (sum + square, count + 1));
        let count = (0..6).filter(|c| is_determined(*c)).count();
        ContactWrench {
            components: std::array::from_fn(|c| is_determined(c).then(|| wrench[c])),
            sigma,
            misfit: (joints > count).then(|| sum / (joints - count) as f64),
        }
    }

    /// Force and moment as text.
    pub(crate) fn text(&self) -> String {
        let part = |range: std::ops::Range<usize>, unit: &str| {
            let shown = range.map(|c| match self.components[c] {
                Some(value) => format!("{value:+.2} +- {:.2}", self.sigma[c]),
                None => "not determined".into(),
            });
            format!("{} {unit}", shown.collect::<Vec<_>>().join(", "))
        };
        let misfit = self.misfit.map_or(String::new(), |misfit| format!("; misfit {misfit:.1}"));
        format!("force {}; moment {}{misfit}", part(0..3, "N"), part(3..6, "N m"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    /// A wrench on the seventh link of random Jacobians is found within its standard deviations; three joints determine no moment.
    #[test]
    fn the_wrench_is_found_where_it_is_determined() {
        let (mut random, n) = (Random::new(3), 7);
        let truth = [20.0, -5.0, 8.0, 1.0, -2.0, 0.5];
        let mut squares = 0.0;
        for _ in 0..200 {
            let jacobian: Vec<f64> = (0..6 * n).map(|_| random.normal()).collect();
            let deviations = vec![0.1; n];
            let torque = |j: usize| (0..6).map(|c| jacobian[c * n + j] * truth[c]).sum::<f64>();
            let torques: Vec<f64> = (0..n).map(|j| torque(j) + 0.1 * random.normal()).collect();
            let found = ContactWrench::new(&jacobian, &torques, &deviations);
            for c in 0..6 {
                squares += ((found.components[c].unwrap() - truth[c]) / found.sigma[c]).powi(2);
            }
        }
        // The mean of 1200 squares of independent standard normal numbers has a standard deviation of 0.041. Here, the six
        // numbers of one wrench are correlated, so the tolerance is larger.
        assert!((squares / 1200.0 - 1.0).abs() < 0.25, "{squares}");
        let three: Vec<f64> = (0..18).map(|_| random.normal()).collect();
        let found = ContactWrench::new(&three, &[1.0, 2.0, 3.0], &[0.1; 3]);
        assert!(found.components.iter().filter(|c| c.is_some()).count() <= 3, "{found:?}");
        assert!(found.text().contains("not determined"));
    }
}
