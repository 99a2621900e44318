//! Detects torques that were logged without their sign: |tau| in place of tau.
//!
//! A torque that is never negative may be right, for example if a joint always carries weight in the same direction. The sign
//! is missing if two conditions hold: the nominal torque has both signs, and the description explains the torque after each
//! sample i got a sign s_i = +-1:
//! ```text
//! s_i |tau_i| = a T_i + b dq_i + c direction_i + d + e_i      s_i: sign of the right-hand side, from the previous pass
//! ```
//! T: nominal torque, N m (N); b: viscous friction, c: Coulomb friction, d: offset, e: residual.

use linear_model::states::States;

use crate::estimate::log_check::change::column;
use crate::estimate::log_check::finding::{Fault, Finding};
use crate::estimate::log_check::regression::{Basis, square};

/// A nominal torque takes both signs if its positive and its negative values each contribute at least this share of its squared
/// norm.
const MIN_SHARE_OF_A_SIGN: f64 = 0.02;
/// A torque counts as never negative if its negative values contribute at most this share of its squared norm. Such values
/// occur because a filter overshoots where an absolute value has a kink.
const ROUNDED_SHARE: f64 = 1e-3;
/// The signs explain the torque if the squared residual is at most this share of the squared torque.
const MAX_RESIDUAL_SHARE: f64 = 0.1;
/// The signs are needed if the squared residual with the found signs is at most this share of the squared residual of the
/// torques as logged.
const MAX_SHARE_OF_SIGNED_RESIDUAL: f64 = 0.3;
/// Passes of the search for the signs. Each pass lowers the residual, which converges after a few passes.
const PASSES: usize = 10;

/// Whether the torques at the samples `rows` were logged without their sign. `torques`: nominal torques of these samples, n per
/// sample.
pub(super) fn are_without_sign(states: &States, rows: &[usize], torques: &[f64]) -> bool {
    let n = states.n;
    let measured = |j: usize| column(&states.tau, n, j, rows);
    let negative = |x: &[f64]| x.iter().filter(|x| **x < 0.0).map(|x| x * x).sum::<f64>();
    let has_sign = |j: usize| negative(&measured(j)) > ROUNDED_SHARE * square(&measured(j));
    if (0..n).any(has_sign) {
        return false;
    }
    let all: Vec<usize> = (0..rows.len()).collect();
    let lacks_sign = |j: usize| {
        let (tau, nominal) = (measured(j), column(torques, n, j, &all));
        // First condition: the nominal torque T has both signs. The smaller of its two parts (T < 0, T >= 0) has a significant
        // share of the squared norm.
        let (negative, whole) = (negative(&nominal), square(&nominal));
        if negative.min(whole - negative) < MIN_SHARE_OF_A_SIGN * whole {
            return false;
        }
        let basis = Basis::of(vec![
            nominal.clone(),
            column(&states.dq, n, j, rows),
            column(&states.direction, n, j, rows),
            vec![1.0; rows.len()],
        ]);
        // signed: squared residual of the torques as logged, that is, with all s_i = 1.
        let signed = square(&basis.without(tau.clone()));
        let mut fit = nominal;
        let mut residual = signed;
        // s_i = sign(fit_i), where fit is the right-hand side of the previous pass. The first pass uses s_i = sign(T_i).
        for _ in 0..PASSES {
            let with_sign: Vec<f64> = tau.iter().zip(&fit).map(|(tau, fit)| tau * fit.signum()).collect();
            let rest = basis.without(with_sign.clone());
            residual = square(&rest);
            fit = with_sign.iter().zip(rest).map(|(tau, rest)| tau - rest).collect();
        }
        residual < MAX_RESIDUAL_SHARE * square(&tau) && residual < MAX_SHARE_OF_SIGNED_RESIDUAL * signed
    };
    (0..n).any(lacks_sign)
}

/// The finding that the torques are absolute values.
pub(super) fn without_sign() -> Finding {
    let evidence = "no torque of the log is negative, and with the signs of the nominal torque and of friction the description \
                    explains it";
    let remedy = "log the torques with their sign; of a register whose sign is a bit of its own, give the bit \
                  in [options.units]: `torque: signbit(10)`";
    Finding::of_all(Fault::AbsoluteTorque, evidence.into(), remedy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_lost_signs_are_reported() {
        let rows: Vec<usize> = (0..400).collect();
        let of = |torque: &dyn Fn(f64) -> f64, nominal: &dyn Fn(f64) -> f64| {
            let mut states = States { n: 1, ..States::default() };
            let mut nominals = Vec::new();
            for &row in &rows {
                let t = 0.02 * row as f64;
                let dq = 3.0 * (3.0 * t).cos();
                states.dq.push(dq);
                states.direction.push(dq.signum());
                states.tau.push(torque(t) + 0.4 * dq + 0.3 * dq.signum());
                nominals.push(nominal(t));
            }
            (states, nominals)
        };
        let swings = |t: f64| 5.0 * (2.0 * t).sin();
        let lost = |(mut states, nominals): (States, Vec<f64>)| {
            states.tau.iter_mut().for_each(|tau| *tau = tau.abs());
            are_without_sign(&states, &rows, &nominals)
        };
        assert!(lost(of(&swings, &swings)));
        // Three torques that do not lack their sign: a torque with its sign, a torque of a joint that always carries weight,
        // and a torque that the description does not explain.
        let (states, nominals) = of(&swings, &swings);
        assert!(!are_without_sign(&states, &rows, &nominals));
        let weight = |t: f64| 9.0 + (2.0 * t).sin();
        assert!(!lost(of(&weight, &weight)));
        assert!(!lost(of(&|t| 5.0 * (7.3 * t).sin(), &swings)));
    }
}
