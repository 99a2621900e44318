//! Inflates the standard deviations sigma_i of the parameters x_i by faults of the log that are not corrected. These are
//! significant faults that explain too little to be named in a claim, and faults and rotors that the data do not exclude.
//!
//! Each fault u was fitted as one additional unknown (`hypotheses`). Faults beyond `LIKELY_FAULT_SIGMAS` of their standard
//! deviations inflate the variance of x_i to
//!
//! ```text
//! sigma_i^2 + max_u (x_i with u - x_i without)^2
//! ```
//! The maximum is used and not the sum, because the columns of the faults of one log are correlated.
//!
//! A zero offset, a spring or a drift below `LIKELY_FAULT_SIGMAS` may still exist. Any rotor that the description does not
//! contain may exist too. For such a u, with its fitted value and standard deviation (`value`, `deviation`), the rms of the
//! possible size is s(u) = sqrt(value^2 + deviation^2). The parameter x_i may then change by d_i(u) = (x_i with u - x_i
//! without) s(u)/value. These changes inflate the variance further to
//!
//! ```text
//! sigma_i^2 + sum_rotors d_i^2 + max_faults d_i^2
//! ```
//! Example: in the range of the log, a spring may be hardly separable from the weight of a body. Then the weight is as uncertain
//! as the spring. The scale of a joint torque is excluded, since parameters are in the torque unit of the log. Errors of
//! predicted torques do not include these unknowns, because torques of motions similar to the log hardly depend on them.

use crate::estimate::artefact::Estimate;
use crate::estimate::claims::claims_of_faults::statement;
use crate::estimate::claims::hypotheses::HypothesisTest;
use crate::estimate::identified::Identified;
use crate::estimate::topics::ROTOR;

/// A fault inflates the standard deviations of the parameters if its size exceeds this many of its own standard deviations.
/// Without a fault, the chance of such a size is below 1 % (Student's t, nine degrees of freedom of the jackknife).
const LIKELY_FAULT_SIGMAS: f64 = 4.0;

fn is_likely(tested: &HypothesisTest) -> bool {
    tested.value.abs() > LIKELY_FAULT_SIGMAS * tested.deviation && tested.is_possible()
}

fn is_rotor(tested: &HypothesisTest) -> bool {
    tested.of.kind().topic == ROTOR
}

/// The likely faults (beyond `LIKELY_FAULT_SIGMAS`), without rotors, that were tested with the parameters of this estimate.
fn likely<'a>(faults: &'a [HypothesisTest], estimate: &Estimate) -> Vec<&'a HypothesisTest> {
    let of_these = |f: &&HypothesisTest| f.effect.len() == estimate.parameters.len() && !is_rotor(f);
    faults.iter().filter(of_these).filter(|f| is_likely(f)).collect()
}

/// Change of all parameters by each likely fault; one vector per fault. [`inflate_by_faults`] uses the same faults.
pub fn effects_of_faults(estimate: &Estimate, faults: &[HypothesisTest]) -> Vec<Vec<f64>> {
    likely(faults, estimate).into_iter().map(|f| f.effect.clone()).collect()
}

/// Inflates standard deviations and covariance by likely faults. Also adds a remark on the strongest significant fault that no
/// claim names. A fault that was tested with another list of parameters is ignored.
pub fn inflate_by_faults(estimate: &mut Estimate, faults: &[HypothesisTest]) {
    let faults = likely(faults, estimate);
    let strength = |f: &HypothesisTest| {
        let ratio = |(effect, p): (&f64, &Identified)| effect.abs() / p.sigma_or_infinity();
        f.effect.iter().zip(&estimate.parameters).map(ratio).fold(0.0, f64::max)
    };
    let unnamed = faults.iter().filter(|f| f.is_significant() && !f.is_found());
    let most = unnamed.max_by(|a, b| strength(a).total_cmp(&strength(b)));
    let remark = most.map(|f| {
        let fault = statement(f, &estimate.joints);
        format!("{fault}; that explains too little of the torque to be significant, and sigma allows for it")
    });
    estimate.inflate_sigma(|c| faults.iter().map(|f| f.effect[c].abs()).fold(0.0, f64::max));
    estimate.remarks.extend(remark);
}

/// Inflates standard deviations and covariance by rotors that the model lacks, and by zero offsets, springs and drifts that
/// the data do not exclude. Faults that [`inflate_by_faults`] uses are not used again.
pub fn inflate_by_undetected_faults(estimate: &mut Estimate, tested: &[HypothesisTest]) {
    let is_held = |f: &&&HypothesisTest| !is_likely(f) && f.of.kind().may_be_there;
    let counts = |f: &&HypothesisTest| f.effect.len() == estimate.parameters.len() && f.value != 0.0;
    let (rotors, faults): (Vec<&HypothesisTest>, Vec<&HypothesisTest>) =
        tested.iter().filter(counts).partition(|f| is_rotor(f));
    let square = |f: &&HypothesisTest, c: usize| (f.effect[c] * (f.deviation / f.value).hypot(1.0)).powi(2);
    let widest = |c: usize| faults.iter().filter(is_held).map(|f| square(f, c)).fold(0.0, f64::max);
    estimate.inflate_sigma(|c| (rotors.iter().map(|f| square(f, c)).sum::<f64>() + widest(c)).sqrt());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::claims::hypotheses::Hypothesis;
    use crate::estimate::identified::Deviations;
    use crate::estimate::residuals::{Residuals, Squares};
    use crate::test_arm::Pendulum;
    use linear_model::unit::Unit;

    fn estimate() -> Estimate {
        let one = |id: &str, sigma: f64| {
            let deviations = Deviations { sigma, white: Some(sigma), weak: false };
            Identified::new(id.parse().unwrap(), Unit::VISCOUS, 1.0, deviations)
        };
        Estimate {
            parameters: vec![one("FV1", 0.03), one("FV2", 0.01)],
            joints: Residuals::new(&Pendulum::new(), vec![Squares::default()]).joints,
            covariance: vec![vec![9e-4, 1.5e-4], vec![1.5e-4, 1e-4]],
            ..Estimate::default()
        }
    }

    fn scale(value: f64, effect: f64) -> HypothesisTest {
        let of = Hypothesis::Scale(0);
        HypothesisTest {
            of,
            value,
            deviation: 0.001,
            power: 0.1,
            held_out: Some((0.1, 0.099)),
            torque_share: 1.0,
            effect: vec![effect, 0.0],
            within: Vec::new(),
        }
    }

    /// A fault of twenty sigma inflates the standard deviations and the covariance of the parameters that the fault changes.
    /// Correlations do not change.
    #[test]
    fn what_a_fault_would_change_is_part_of_the_deviation() {
        let mut wide = estimate();
        inflate_by_faults(&mut wide, &[scale(0.02, 0.04), scale(-0.02, -0.03)]);
        assert!((wide.parameters[0].sigma.unwrap() - 0.05).abs() < 1e-15, "{:?}", wide.parameters[0]);
        assert_eq!(wide.parameters[1].sigma, Some(0.01));
        let rho = |c: &[Vec<f64>]| c[0][1] / (c[0][0] * c[1][1]).sqrt();
        assert!((wide.covariance[0][0] - 25e-4).abs() < 1e-15 && wide.covariance[0][1] == wide.covariance[1][0]);
        assert!((rho(&wide.covariance) - rho(&estimate().covariance)).abs() < 1e-12);
        assert!(
            wide.remarks.len() == 1
                && wide.remarks[0].contains("q1")
                && wide.remarks[0].contains("sigma allows for it")
        );
    }

    #[test]
    fn what_may_be_there_is_part_of_the_deviation() {
        let rotor = HypothesisTest { of: Hypothesis::Rotor(0), deviation: 0.02, ..scale(0.01, 0.04) };
        let mut wide = estimate();
        inflate_by_faults(&mut wide, std::slice::from_ref(&rotor));
        assert_eq!(wide, estimate());
        inflate_by_undetected_faults(&mut wide, std::slice::from_ref(&rotor));
        // Expected: sqrt(sigma^2 + effect^2 (1 + r^2)) with sigma = 0.03, effect = 0.04 and r = deviation/value = 2.
        assert!((wide.parameters[0].sigma.unwrap() - 0.0089f64.sqrt()).abs() < 1e-15, "{:?}", wide.parameters[0]);
        assert!(wide.parameters[1].sigma == Some(0.01) && wide.remarks.is_empty());
        let spring = HypothesisTest { of: Hypothesis::Spring(0), deviation: 0.03, ..scale(0.01, 0.01) };
        let mut wide = estimate();
        let lesser = HypothesisTest { effect: vec![0.005, 0.0], ..spring.clone() };
        let told = HypothesisTest { of: Hypothesis::Spring(0), ..scale(0.02, 0.2) };
        let scale = HypothesisTest { deviation: 0.03, ..scale(0.01, 0.02) };
        inflate_by_undetected_faults(&mut wide, &[rotor, spring, lesser, told, scale]);
        // Expected: the former variance plus effect^2 (1 + r^2) of the larger spring, with effect = 0.01 and r = deviation/value
        // = 3. The smaller spring, the significant spring and the scale have no influence.
        assert!((wide.parameters[0].sigma.unwrap() - 0.0099f64.sqrt()).abs() < 1e-15, "{:?}", wide.parameters[0]);
    }

    #[test]
    fn what_is_not_told_widens_nothing() {
        for faults in
            [vec![], vec![scale(0.0039, 0.04)], vec![HypothesisTest { effect: vec![0.1], ..scale(0.02, 0.0) }]]
        {
            let mut same = estimate();
            inflate_by_faults(&mut same, &faults);
            assert_eq!(same, estimate());
        }
    }
}
