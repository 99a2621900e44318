//! How much position errors of bodies and joints can reduce the distance (gap) between two bodies.
//!
//! Position errors reduce the distance between two bodies by at most 2 c + sum of R_j e_j, and the distance between a body and a
//! half-space by at most c + sum of R_j e_j. c: largest error of a point of a body. e_j: largest error of joint j. R_j: largest
//! speed of the body per speed of joint j, at any configuration.

use crate::clearance::Clearance;

/// The largest position errors of the bodies and of the joints.
#[derive(Clone, Debug, Default)]
pub struct BodyErrors {
    /// Largest error of the position of each joint, rad (m). Empty: no errors.
    pub joints: Vec<f64>,
    /// Largest absolute value of each coordinate during the motion, rad (m). The loss of distance is computed for this range.
    pub farthest: Vec<f64>,
    /// Largest position error of a point of a body relative to its link, m.
    pub bodies: f64,
}

impl BodyErrors {
    /// Whether any error is larger than zero.
    pub(crate) fn is_any(&self) -> bool {
        self.bodies > 0.0 || self.joints.iter().any(|by| *by > 0.0)
    }
}

impl Clearance {
    /// Computes the largest rate of change of each gap (distance of a body) with each coordinate. Then raises the least allowed
    /// distance of each gap by the position errors: the errors of the bodies, plus each joint error times this rate. A constant
    /// gap keeps its least allowed distance.
    pub(crate) fn with_rates(mut self, errors: &BodyErrors) -> Clearance {
        self.rates = self.rates(&self.given_ranges);
        let far = |k: usize| errors.farthest.get(k).copied().unwrap_or(0.0) + errors.joints.get(k).unwrap_or(&0.0);
        let ranges: Vec<f64> = self.given_ranges.iter().enumerate().map(|(k, given)| given.max(far(k))).collect();
        let rates = self.rates(&ranges);
        for (gap, rate) in self.gaps.iter_mut().zip(rates) {
            let sides = if gap.is_own { 2.0 } else { 1.0 };
            let of_joints: f64 = rate.iter().zip(&errors.joints).map(|(rate, by)| rate * by).sum();
            gap.margin = if gap.is_constant { 0.0 } else { sides * errors.bodies + of_joints };
            gap.bound += gap.margin;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gaps::tests::{clearance, situation};
    use crate::gaps::{ClearanceRules, FloorRule};

    #[test]
    fn a_gap_loses_no_more_than_its_margin() {
        let rules = |errors| ClearanceRules {
            distance: Some(0.02),
            floor: FloorRule::At(-0.15),
            errors,
            ..ClearanceRules::default()
        };
        let (joints, bodies) = (vec![0.03, 0.05, 0.02], 0.004);
        let errors = BodyErrors { joints: joints.clone(), farthest: vec![3.0; 3], bodies };
        let (without, with) = (clearance(&rules(BodyErrors::default())).unwrap(), clearance(&rules(errors)).unwrap());
        let all: Vec<usize> = (0..with.gaps().len()).collect();
        let mut most: f64 = 0.0;
        for (k, q) in situation().poses.iter().enumerate().take(300) {
            let wave = |j: usize| joints[j] * ((k * 7 + j * 3) as f64).sin().signum();
            let off = [q[0] + wave(0), q[1] + wave(1), q[2] + wave(2)];
            let (there, here) = (with.rooms(&off, &[0.0; 3], &all), with.rooms(q, &[0.0; 3], &all));
            for (g, (there, here)) in there.iter().zip(&here).enumerate() {
                let (gap, sides) = (&with.gaps()[g], if with.gaps()[g].is_own { 2.0 } else { 1.0 });
                let lost = here.reached - there.reached + sides * bodies;
                assert!(lost <= gap.margin + 1e-9, "{}: {lost} {}", gap.subject, gap.margin);
                assert!((gap.bound - gap.margin - without.gaps()[g].bound).abs() < 1e-15, "{gap:?}");
                most = most.max(lost / gap.margin);
            }
        }
        // `most`: greatest ratio of the loss of distance to the margin. A margin is not much larger than the loss that the
        // errors cause.
        assert!(most > 0.3, "{most}");
        assert!(without.gaps().iter().all(|gap| gap.margin == 0.0));
    }
}
