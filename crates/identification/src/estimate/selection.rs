//! Chooses the friction model of all joints by cross-validation.
//!
//! Each tenth of the record is predicted by a fit to the other tenths. Of the models whose error is within 1 % of the smallest
//! error, the model with the fewest columns is chosen. The residual of the fit cannot decide, because more columns always
//! reduce this residual.

use std::fmt;

use linear_model::friction::terms::FrictionTerm;
use linear_model::regressor::Regressor;
use logs::Error;

use crate::estimate::held_out::{cross_validate, residuals};
use crate::estimate::options::Options;
use crate::estimate::residuals::Residuals;
use crate::estimators::weighted::fit;
use crate::rows::observation::Observation;
use crate::signals::preparation::Preparation;
use crate::signals::records::Records;

/// A candidate friction model and its errors.
#[derive(Clone, Debug)]
pub struct FrictionCandidate {
    /// Friction terms that every joint has.
    pub terms: Vec<FrictionTerm>,
    /// Number of friction columns of all joints together.
    pub columns: usize,
    /// Relative residual |tau - W X| / |tau| of the fit.
    pub fitted: f64,
    /// Residuals of cross-validation: each tenth of the record is predicted by a fit to the other tenths.
    pub predicted: Residuals,
}

/// The compared friction models and the index of the chosen one.
#[derive(Clone, Debug)]
pub struct FrictionSelection {
    /// All candidates, in the order given.
    pub candidates: Vec<FrictionCandidate>,
    /// Index of the chosen candidate.
    pub chosen: usize,
}

/// Models count as equally good if their error of cross-validation is at most the smallest error times this factor.
const EQUIVALENT_ERROR_RATIO: f64 = 1.01;

/// Speed parameters of smooth Coulomb and Stribeck friction, as shares of the largest speed of the fastest joint.
const FRICTION_SPEED_SHARES: [f64; 4] = [0.003, 0.01, 0.03, 0.1];

/// The default candidates: lists of friction terms. `fastest`: largest speed of the fastest joint, rad/s (m/s); speed
/// parameters are shares of this speed.
///
/// Load-dependent friction is no candidate here, because its column contains the torque that is to be predicted.
pub fn friction_candidates(fastest: f64) -> Vec<Vec<FrictionTerm>> {
    use FrictionTerm::*;
    let mut out = vec![vec![Viscous, Offset], vec![Viscous, Coulomb, Offset], vec![Asymmetric]];
    for share in FRICTION_SPEED_SHARES {
        out.push(vec![Viscous, SmoothCoulomb(share * fastest), Offset]);
        out.push(vec![Viscous, Coulomb, Offset, Stribeck(share * fastest)]);
    }
    out
}

/// How records are prepared so that they contain the signals for the friction columns of all candidates.
pub fn preparation(options: &Options, candidates: &[Vec<FrictionTerm>]) -> Preparation {
    let mut preparation = options.preparation();
    for &term in candidates.iter().flatten().filter(|term| term.is_bent()) {
        if !preparation.friction.contains(&term) {
            preparation.friction.push(term);
        }
    }
    preparation
}

/// Compares friction models on records that were prepared with [`preparation`]. All other options come from `options`.
///
/// Fails if a record cannot be read, or if there are no candidates.
pub fn select_friction<R: Records + ?Sized>(
    regressor: &dyn Regressor,
    records: &R,
    options: &Options,
    candidates: &[Vec<FrictionTerm>],
) -> Result<FrictionSelection, Error> {
    let mut out = Vec::with_capacity(candidates.len());
    for terms in candidates {
        let model = options.linear_model_with(regressor, terms);
        let observation = Observation::of_records(&model, records, None)?;
        let joints = observation.joints(|_| true);
        let (solution, _) = fit(&joints, options.weights);
        out.push(FrictionCandidate {
            terms: terms.clone(),
            columns: model.p() - regressor.parameters().len(),
            fitted: residuals(&model, &joints, &solution.x).total,
            predicted: cross_validate(&model, &observation, options.weights),
        });
    }
    let best = out.iter().map(|c| c.predicted.total).fold(f64::INFINITY, f64::min);
    let good = (0..out.len()).filter(|&i| out[i].predicted.total <= EQUIVALENT_ERROR_RATIO * best);
    let key = |&i: &usize| (out[i].columns, i);
    let chosen = good.min_by_key(key).ok_or_else(|| Error::new("no friction model is given to choose from"))?;
    Ok(FrictionSelection { candidates: out, chosen })
}

impl fmt::Display for FrictionSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "   columns   fitted  predicted  by joint, friction model")?;
        for (i, c) in self.candidates.iter().enumerate() {
            let mark = if i == self.chosen { '*' } else { ' ' };
            let joints: Vec<String> = c.predicted.joints.iter().map(|j| format!("{:.3}", j.relative)).collect();
            let terms: Vec<String> = c.terms.iter().map(|t| t.to_string()).collect();
            writeln!(
                f,
                "{mark}  {:>7}  {:>7.4}  {:>9.4}  {}  {}",
                c.columns,
                c.fitted,
                c.predicted.total,
                joints.join(" "),
                terms.join(",")
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::preparation::states;
    use crate::signals::signal_options::Signal;
    use crate::test_arm::Pendulum;
    use logs::{Effort, Log};
    use random::Random;

    fn log(friction: impl Fn(f64, usize) -> f64) -> Log {
        let arm = Pendulum::new();
        let states = arm.states(3000);
        let mut random = Random::new(41);
        let tau: Vec<f64> =
            (0..states.len()).map(|r| states.tau[r] + friction(states.dq[r], r) + 0.02 * random.normal()).collect();
        crate::test_arm::log(states.t, vec![states.q], vec![tau], Effort::Torque)
    }

    #[test]
    fn the_friction_that_is_there_is_chosen() {
        let arm = Pendulum::new();
        let candidates = friction_candidates(3.0);
        let signal = Signal { filtered_sign: true, ..Signal::default() };
        let options = Options { signal, ..Options::default() };
        let plain = log(|dq, _| 0.3 * dq + 0.5 * dq.signum());
        let select = |log: Log| {
            let records = states(&arm, &log, &preparation(&options, &candidates)).unwrap();
            select_friction(&arm, records.as_slice(), &options, &candidates).unwrap()
        };
        let chosen = select(plain);
        let terms = &chosen.candidates[chosen.chosen].terms;
        assert_eq!(terms[..2], [FrictionTerm::Viscous, FrictionTerm::Coulomb], "{chosen}");
        let asymmetric = log(|dq, _| if dq > 0.0 { 0.3 * dq + 0.5 } else { 0.6 * dq - 0.9 });
        let chosen = select(asymmetric);
        assert_eq!(chosen.candidates[chosen.chosen].terms, [FrictionTerm::Asymmetric], "{chosen}");
        assert!(select_friction(&arm, [].as_slice(), &Options::default(), &candidates).is_err());
    }
}
