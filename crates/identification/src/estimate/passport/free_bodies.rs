//! Whether a log needs a change to be explained, or other bodies than the description's explain it as it is.
//!
//! The search for mistakes holds the bodies of the description (`search`). Other bodies may do without the mistake: the zero of
//! a last joint is a turn of its body. So the bodies are left free,
//! ```text
//! tau_j = Y_j(q, dq, ddq) X + a_j ddq_j + b_j dq_j + c_j direction_j + d_j
//! ```
//! and fitted to the log with the change undone and as it is. The change is needed where that lowers the error on parts left
//! out, of one joint at least below `NEEDED_ERROR_RATIO` of what it is, and over all joints in the geometric mean.
//!
//! A wrong sign of a torque or of a motion makes friction drive, and inertia less than nothing: bodies that do without it
//! cannot exist unless friction brakes. What the signals say without any bodies is needed always, and so is an exchange or a
//! sign with which the description itself, without a free number, leaves nearly nothing.

use std::f64::consts::FRAC_PI_2;

use linear_model::friction::terms::FrictionTerm;
use linear_model::linear_model::Model;
use linear_model::regressor::Regressor;

use crate::estimate::held_out::cross_validate;
use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::passport::change::{Change, torque_of};
use crate::estimate::passport::report::JointPassport;
use crate::estimate::passport::samples::Samples;
use crate::estimate::passport::search::Suspicion;
use crate::estimators::weighted::Weights;
use crate::rows::observation::Observation;

/// Samples that the bodies are fitted to: some ten times as many rows as an arm has parameters.
const FITTED_SAMPLES: usize = 1000;
/// Parts of the record, of which two are left out at a time.
const PARTS: usize = 20;
/// Error of a joint with the change undone, over that of the log as it is, below which bodies do not explain the log as well.
const NEEDED_ERROR_RATIO: f64 = 0.8;
/// The same of a wrong scale, of which some number takes up a part of any other fault.
const NEEDED_SCALE_ERROR_RATIO: f64 = 0.5;

/// A scale by the description is right within a factor of 1.5, and a hundredth is what it is worth.
const SCALE_REACH: f64 = 0.4;
const SCALE_TOLERANCE: f64 = 0.01;
/// (sqrt(5) - 1) / 2.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Misfit that a mistake leaves, of that of the log as it is, in squares, below which other bodies would have to be those of
/// the description at other places by chance. Of a zero, which is a number, some angle may suit them.
const SURE_MISFIT_SHARE: f64 = 0.04;

/// Friction and rotor of each joint, which no description has.
const OWN: [FrictionTerm; 4] =
    [FrictionTerm::Viscous, FrictionTerm::Coulomb, FrictionTerm::Offset, FrictionTerm::Rotor];

/// A log to which bodies are fitted.
pub(super) struct FreeBodies<'a> {
    pub regressor: &'a dyn Regressor,
    pub samples: &'a Samples,
    pub joints: &'a [JointPassport],
}

impl FreeBodies<'_> {
    /// Which of the suspicions the log needs; those that it does not are dropped one by one.
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
        // A description that has one zero elsewhere has others so: a quarter turn beside such a zero stands with it.
        let is_quarter = |change: &Change| matches!(change, Change { of: Hypothesis::Zero(_), size } if (size / FRAC_PI_2).fract() == 0.0);
        let are_quarters: Vec<bool> = suspicions.iter().map(|one| one.changes.iter().all(is_quarter)).collect();
        if needed.iter().zip(&are_quarters).any(|(needed, quarter)| *needed && *quarter) {
            needed.iter_mut().zip(are_quarters).for_each(|(needed, quarter)| *needed |= quarter);
        }
        needed
    }

    /// The suspicions with their wrong scales as the log has them whatever the bodies: those of least error on parts left out,
    /// by golden sections of the logarithm. The description tells a scale as far as its bodies are right.
    pub(super) fn with_scales(&self, mut suspicions: Vec<Suspicion>) -> Vec<Suspicion> {
        let places: Vec<(usize, usize)> = (0..suspicions.len())
            .flat_map(|i| (0..suspicions[i].changes.len()).map(move |c| (i, c)))
            .filter(|&(i, c)| matches!(suspicions[i].changes[c].of, Hypothesis::Scale(_)))
            .collect();
        for (i, c) in places {
            let described = suspicions[i].changes[c].size.ln_1p();
            let error = |suspicions: &mut Vec<Suspicion>, scale: f64| {
                suspicions[i].changes[c].size = scale.exp_m1();
                let all: Vec<Change> = suspicions.iter().flat_map(|one| one.changes.iter().copied()).collect();
                self.errors(&all).iter().filter(|error| **error > 0.0).map(|error| error.ln()).sum::<f64>()
            };
            let (mut low, mut high) = (described - SCALE_REACH, described + SCALE_REACH);
            let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
            let [mut a, mut b] = inner(low, high);
            let (mut at_a, mut at_b) = (error(&mut suspicions, a), error(&mut suspicions, b));
            while high - low > SCALE_TOLERANCE {
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

    /// Whether bodies that can exist may do without a mistake.
    fn may_be_bodies(&self, suspicion: &Suspicion) -> bool {
        let brakes = |k: usize| self.joints[k].friction.is_some_and(|f| f.brakes > f.deviation);
        let is_sure = suspicion.after < SURE_MISFIT_SHARE * suspicion.before;
        suspicion.changes.iter().all(|change| change.of.may_be_bodies(brakes, is_sure))
    }

    /// By column of torque, the error on parts left out, relative, with these changes done.
    fn errors(&self, changes: &[Change]) -> Vec<f64> {
        let step = self.samples.kept.len() / FITTED_SAMPLES;
        let states = Change::all_done(changes, &self.samples.kept, &self.samples.every(step), self.regressor);
        let model = Model::new(self.regressor, &OWN, &[]);
        let found = cross_validate(&model, &Observation::of(&model, &states, PARTS), Weights::Joint);
        let mut errors = vec![0.0; states.n];
        for (j, joint) in found.joints.iter().enumerate() {
            errors[torque_of(changes, j).0] = joint.relative;
        }
        errors
    }
}

/// Whether the first errors are lower than the second by far: that of one joint at least by this ratio.
fn is_lower(with: &[f64], without: &[f64], needed: f64) -> bool {
    let ratios = with.iter().zip(without).filter(|(_, without)| **without > 0.0).map(|(with, without)| with / without);
    let ratios: Vec<f64> = ratios.collect();
    ratios.iter().any(|ratio| *ratio < needed) && ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() < 0.0
}
