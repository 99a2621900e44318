//! Tests whether a suspected fault is needed to explain a log, or whether other bodies than the nominal ones explain the
//! unchanged log. Bodies: the inertial parameters of the links; nominal: from the robot description.
//!
//! The search for faults (`search`) uses the nominal bodies. Other bodies may explain the log without a fault: for example, a
//! wrong zero of the last joint is equivalent to a rotation of its body. So the following equations are fitted twice: to the
//! unchanged log, and to the log with the fault undone. X: free parameters of the bodies; a_j: rotor inertia; b_j, c_j: viscous
//! and Coulomb friction; d_j: offset.
//! ```text
//! tau_j = Y_j(q, dq, ddq) X + a_j ddq_j + b_j dq_j + c_j direction_j + d_j
//! ```
//! The fault is needed if undoing it multiplies the error of cross-validation of at least one joint by less than
//! `NEEDED_ERROR_RATIO`, and reduces the geometric mean over all joints.
//!
//! Some faults are needed without this test: a wrong sign, if friction does not dissipate in the unchanged log; faults that
//! the signals show without bodies; and an exchange or a wrong sign, if the description predicts the corrected log nearly
//! exactly without fitted numbers.

use std::f64::consts::FRAC_PI_2;

use linear_model::friction::terms::FrictionTerm;
use linear_model::linear_model::Model;
use linear_model::regressor::Regressor;

use crate::estimate::held_out::cross_validate;
use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::log_check::change::{Change, torque_of};
use crate::estimate::log_check::report::JointCheck;
use crate::estimate::log_check::samples::Samples;
use crate::estimate::log_check::search::Suspicion;
use crate::estimators::weighted::Weights;
use crate::rows::observation::Observation;

/// Least number of samples to which bodies are fitted (if the log has so many); at most twice this number is used. An arm then
/// has about ten times as many rows as parameters.
const FITTED_SAMPLES: usize = 1000;
/// Number of blocks of the record. Cross-validation leaves out two blocks at a time.
const CROSS_VALIDATION_BLOCKS: usize = 20;
/// A fault is needed if undoing it multiplies the error of cross-validation of a joint by less than this value.
const NEEDED_ERROR_RATIO: f64 = 0.8;
/// A scale error is needed if undoing it multiplies the error of cross-validation of a joint by less than this value. The limit
/// is stricter than for other faults: if the log has another fault, some wrong scale also reduces the error.
const NEEDED_SCALE_ERROR_RATIO: f64 = 0.5;

/// Half width of the search interval of ln(scale). The interval is centred at the scale found with nominal bodies, which is
/// right within a factor of 1.5.
const LOG_SCALE_RANGE: f64 = 0.4;
/// The search for a scale ends when the interval of ln(scale) is shorter than this value.
const LOG_SCALE_TOLERANCE: f64 = 0.01;
/// Golden section, (sqrt(5) - 1) / 2.
const GOLDEN_STEP: f64 = 0.618_033_988_749_894_9;

/// A fault is certain if undoing it multiplies the misfit (error of the description) by less than this factor, because other
/// bodies rarely explain a log that well. Wrong zeros of positions are never certain, because some angle may fit by chance.
const SURE_MISFIT_SHARE: f64 = 0.04;

/// Friction and rotor terms that are fitted for each joint, because the description does not contain them.
const FITTED_TERMS: [FrictionTerm; 4] =
    [FrictionTerm::Viscous, FrictionTerm::Coulomb, FrictionTerm::Offset, FrictionTerm::Rotor];

/// A log to which bodies are fitted.
pub(super) struct FreeBodies<'a> {
    pub regressor: &'a dyn Regressor,
    pub samples: &'a Samples,
    pub joints: &'a [JointCheck],
}

impl FreeBodies<'_> {
    /// For each suspicion (suspected fault), whether the fault is needed to explain the log. The suspicions are tested one
    /// after the other. A fault that is not needed is left out when the next suspicions are tested.
    pub(super) fn needed(&self, suspicions: &[Suspicion]) -> Vec<bool> {
        let mut needed = vec![true; suspicions.len()];
        let open: Vec<usize> = (0..suspicions.len()).filter(|&k| self.may_be_bodies(&suspicions[k])).collect();
        if open.is_empty() {
            return needed;
        }
        let all = |needed: &[bool]| -> Vec<Change> {
            let kept = suspicions.iter().zip(needed).filter(|(_, needed)| **needed);
            kept.flat_map(|(suspicion, _)| suspicion.changes.iter().copied()).collect()
        };
        let mut with = self.errors(&all(&needed));
        for k in open {
            needed[k] = false;
            let without = self.errors(&all(&needed));
            let is_scale = suspicions[k].changes.iter().any(|change| matches!(change.of, Hypothesis::Scale(_)));
            if is_lower(&with, &without, if is_scale { NEEDED_SCALE_ERROR_RATIO } else { NEEDED_ERROR_RATIO }) {
                needed[k] = true;
            } else {
                with = without;
            }
        }
        // If the description has one zero that is wrong by quarter turns, other zeros are often wrong by quarter turns too. So
        // if one such zero is needed, all such zeros are kept.
        let is_quarter = |change: &Change| matches!(change, Change { of: Hypothesis::Zero(_), size } if (size / FRAC_PI_2).fract() == 0.0);
        let are_quarters: Vec<bool> = suspicions.iter().map(|one| one.changes.iter().all(is_quarter)).collect();
        if needed.iter().zip(&are_quarters).any(|(needed, quarter)| *needed && *quarter) {
            needed.iter_mut().zip(are_quarters).for_each(|(needed, quarter)| *needed |= quarter);
        }
        needed
    }

    /// Estimates the scales of suspected faults again, with free bodies, because scales found with nominal bodies contain the
    /// errors of these bodies. The scale with the smallest error of cross-validation is taken (golden-section search in
    /// ln(scale)).
    pub(super) fn with_scales(&self, mut suspicions: Vec<Suspicion>) -> Vec<Suspicion> {
        let places: Vec<(usize, usize)> = (0..suspicions.len())
            .flat_map(|i| (0..suspicions[i].changes.len()).map(move |c| (i, c)))
            .filter(|&(i, c)| matches!(suspicions[i].changes[c].of, Hypothesis::Scale(_)))
            .collect();
        for (i, c) in places {
            // The size of a scale error is scale - 1, so ln(scale) = ln(1 + size).
            let described = suspicions[i].changes[c].size.ln_1p();
            let error = |suspicions: &mut Vec<Suspicion>, scale: f64| {
                suspicions[i].changes[c].size = scale.exp_m1();
                let all: Vec<Change> = suspicions.iter().flat_map(|one| one.changes.iter().copied()).collect();
                // The sum of ln(error_j) over the joints j has the same minimum as the geometric mean of the errors.
                self.errors(&all).iter().filter(|error| **error > 0.0).map(|error| error.ln()).sum::<f64>()
            };
            let (mut low, mut high) = (described - LOG_SCALE_RANGE, described + LOG_SCALE_RANGE);
            let inner = |low: f64, high: f64| [high - GOLDEN_STEP * (high - low), low + GOLDEN_STEP * (high - low)];
            let [mut a, mut b] = inner(low, high);
            let (mut at_a, mut at_b) = (error(&mut suspicions, a), error(&mut suspicions, b));
            // Golden-section search: one of the inner points a, b is also an inner point of the shorter interval. So each step
            // needs only one new fit.
            while high - low > LOG_SCALE_TOLERANCE {
                if at_a < at_b {
                    (high, b, at_b) = (b, a, at_a);
                    a = inner(low, high)[0];
                    at_a = error(&mut suspicions, a);
                } else {
                    (low, a, at_a) = (a, b, at_b);
                    b = inner(low, high)[1];
                    at_b = error(&mut suspicions, b);
                }
            }
            suspicions[i].changes[c].size = (0.5 * (low + high)).exp_m1();
        }
        suspicions
    }

    /// Whether physically consistent bodies may explain the log without the suspected fault. If not, the fault is needed without
    /// a test.
    fn may_be_bodies(&self, suspicion: &Suspicion) -> bool {
        let brakes = |k: usize| self.joints[k].friction.is_some_and(|f| f.brakes > f.deviation);
        let is_sure = suspicion.after < SURE_MISFIT_SHARE * suspicion.before;
        suspicion.changes.iter().all(|change| change.of.may_be_bodies(brakes, is_sure))
    }

    /// Relative errors of cross-validation of the joints in the changed log. The errors are in the order of the torque columns
    /// of the unchanged log.
    fn errors(&self, changes: &[Change]) -> Vec<f64> {
        let step = self.samples.kept.len() / FITTED_SAMPLES;
        let states = Change::all_done(changes, &self.samples.kept, &self.samples.every(step), self.regressor);
        let model = Model::new(self.regressor, &FITTED_TERMS, &[]);
        let found = cross_validate(&model, &Observation::of(&model, &states, CROSS_VALIDATION_BLOCKS), Weights::Joint);
        let mut errors = vec![0.0; states.n];
        for (j, joint) in found.joints.iter().enumerate() {
            errors[torque_of(changes, j).0] = joint.relative;
        }
        errors
    }
}

/// Whether the geometric mean of the errors `with` is lower than the geometric mean of the errors `without`, and at least one
/// joint has an error that is lower by the factor `needed`.
fn is_lower(with: &[f64], without: &[f64], needed: f64) -> bool {
    let ratios = with.iter().zip(without).filter(|(_, without)| **without > 0.0).map(|(with, without)| with / without);
    let ratios: Vec<f64> = ratios.collect();
    ratios.iter().any(|ratio| *ratio < needed) && ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() < 0.0
}
