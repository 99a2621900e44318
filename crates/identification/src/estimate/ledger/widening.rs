//! Deviations that allow for faults which are told and explain too little to be named, and for faults and rotors that the
//! data do not exclude.
//!
//! With x the fit and u one unknown more (`hypotheses`), of those beyond `WIDENING_FAULT_SIGMAS` of their deviations,
//!
//! ```text
//! sigma_i^2 + max_u (x_i with u - x_i without)^2
//! ```
//! The largest counts and not the sum: faults of one log explain each other. A zero, a spring or a drift of fewer deviations
//! may be there, as large as its value and deviation say, s(u) = value sqrt(1 + (deviation/value)^2), and moves the
//! parameters by d_i(u) = (x_i with u - x_i without) s(u)/value. So may any rotor: nobody spoke of it, and it is no fault.
//!
//! ```text
//! sigma_i^2 + sum_rotors d_i^2 + max_faults d_i^2
//! ```
//! A spring that bodies nearly explain in the range of the log is an example: the log cannot tell it from their weight, so
//! the weight is as unsure as the spring. The scale of a joint is not among them: parameters are in the units of the log.
//! Torques of such motions as were logged hardly change with what is not told, so these count in no error of torques.

use crate::estimate::artefact::Estimate;
use crate::estimate::identified::Identified;
use crate::estimate::ledger::claims_of_faults::statement;
use crate::estimate::ledger::hypotheses::Tested;
use crate::estimate::topics::ROTOR;

/// A fault beyond so many of its deviations is part of those of the parameters. Fewer than one in a hundred of those that
/// are not there are, by t of the nine freedoms of the jackknife.
const WIDENING_FAULT_SIGMAS: f64 = 4.0;

fn is_likely(tested: &Tested) -> bool {
    tested.value.abs() > WIDENING_FAULT_SIGMAS * tested.deviation
}

fn is_rotor(tested: &Tested) -> bool {
    tested.of.kind().topic == ROTOR
}

/// The faults that widen the deviations of these parameters.
fn likely<'a>(faults: &'a [Tested], estimate: &Estimate) -> Vec<&'a Tested> {
    let of_these = |f: &&Tested| f.effect.len() == estimate.parameters.len() && !is_rotor(f);
    faults.iter().filter(of_these).filter(|f| is_likely(f)).collect()
}

/// By how much each of the faults by which [`widen_by_faults`] widens moves the parameters.
pub fn effects_of_faults(estimate: &Estimate, faults: &[Tested]) -> Vec<Vec<f64>> {
    likely(faults, estimate).into_iter().map(|f| f.effect.clone()).collect()
}

/// Widens deviations and covariance by faults, and says it of the one that changes most. An estimate of other parameters
/// than the faults were tested with stays as it is.
pub fn widen_by_faults(estimate: &mut Estimate, faults: &[Tested]) {
    let faults = likely(faults, estimate);
    let strength = |f: &Tested| {
        let ratio = |(effect, p): (&f64, &Identified)| effect.abs() / p.sigma_or_infinity();
        f.effect.iter().zip(&estimate.parameters).map(ratio).fold(0.0, f64::max)
    };
    let unnamed = faults.iter().filter(|f| f.is_told() && !f.is_found());
    let most = unnamed.max_by(|a, b| strength(a).total_cmp(&strength(b)));
    let remark = most.map(|f| {
        let fault = statement(f, &estimate.joints);
        format!("{fault}; that explains too little of the torque to be sure, and the deviations allow for it")
    });
    estimate.widen(|c| faults.iter().map(|f| f.effect[c].abs()).fold(0.0, f64::max));
    estimate.remarks.extend(remark);
}

/// Widens deviations and covariance by rotors, and by the zeros, springs and drifts that the data do not exclude; those for
/// which [`widen_by_faults`] does it already do not count twice.
pub fn widen_by_what_may_be_there(estimate: &mut Estimate, tested: &[Tested]) {
    let is_held = |f: &&&Tested| !is_likely(f) && f.of.kind().may_be_there;
    let counts = |f: &&Tested| f.effect.len() == estimate.parameters.len() && f.value != 0.0;
    let (rotors, faults): (Vec<&Tested>, Vec<&Tested>) = tested.iter().filter(counts).partition(|f| is_rotor(f));
    let square = |f: &&Tested, c: usize| (f.effect[c] * (f.deviation / f.value).hypot(1.0)).powi(2);
    let widest = |c: usize| faults.iter().filter(is_held).map(|f| square(f, c)).fold(0.0, f64::max);
    estimate.widen(|c| (rotors.iter().map(|f| square(f, c)).sum::<f64>() + widest(c)).sqrt());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::identified::Deviations;
    use crate::estimate::ledger::hypotheses::Hypothesis;
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

    fn scale(value: f64, effect: f64) -> Tested {
        let of = Hypothesis::Scale(0);
        Tested {
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

    /// A fault of twenty deviations widens what it moves, and its row and column of the covariance; the correlation stays.
    #[test]
    fn what_a_fault_would_change_is_part_of_the_deviation() {
        let mut wide = estimate();
        widen_by_faults(&mut wide, &[scale(0.02, 0.04), scale(-0.02, -0.03)]);
        assert!((wide.parameters[0].sigma.unwrap() - 0.05).abs() < 1e-15, "{:?}", wide.parameters[0]);
        assert_eq!(wide.parameters[1].sigma, Some(0.01));
        let rho = |c: &[Vec<f64>]| c[0][1] / (c[0][0] * c[1][1]).sqrt();
        assert!((wide.covariance[0][0] - 25e-4).abs() < 1e-15 && wide.covariance[0][1] == wide.covariance[1][0]);
        assert!((rho(&wide.covariance) - rho(&estimate().covariance)).abs() < 1e-12);
        assert!(wide.remarks.len() == 1 && wide.remarks[0].contains("q1") && wide.remarks[0].contains("allow for it"));
    }

    #[test]
    fn what_may_be_there_is_part_of_the_deviation() {
        let rotor = Tested { of: Hypothesis::Rotor(0), deviation: 0.02, ..scale(0.01, 0.04) };
        let mut wide = estimate();
        widen_by_faults(&mut wide, std::slice::from_ref(&rotor));
        assert_eq!(wide, estimate());
        widen_by_what_may_be_there(&mut wide, std::slice::from_ref(&rotor));
        // sqrt(0.03^2 + 0.04^2 (1 + 2^2))
        assert!((wide.parameters[0].sigma.unwrap() - 0.0089f64.sqrt()).abs() < 1e-15, "{:?}", wide.parameters[0]);
        assert!(wide.parameters[1].sigma == Some(0.01) && wide.remarks.is_empty());
        let spring = Tested { of: Hypothesis::Spring(0), deviation: 0.03, ..scale(0.01, 0.01) };
        let mut wide = estimate();
        let lesser = Tested { effect: vec![0.005, 0.0], ..spring.clone() };
        let told = Tested { of: Hypothesis::Spring(0), ..scale(0.02, 0.2) };
        let scale = Tested { deviation: 0.03, ..scale(0.01, 0.02) };
        widen_by_what_may_be_there(&mut wide, &[rotor, spring, lesser, told, scale]);
        // and 0.01^2 (1 + 3^2); neither the lesser spring counts, nor one that is told, nor the scale.
        assert!((wide.parameters[0].sigma.unwrap() - 0.0099f64.sqrt()).abs() < 1e-15, "{:?}", wide.parameters[0]);
    }

    #[test]
    fn what_is_not_told_widens_nothing() {
        for faults in [vec![], vec![scale(0.0039, 0.04)], vec![Tested { effect: vec![0.1], ..scale(0.02, 0.0) }]] {
            let mut same = estimate();
            widen_by_faults(&mut same, &faults);
            assert_eq!(same, estimate());
        }
    }
}
