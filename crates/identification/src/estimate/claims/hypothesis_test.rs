//! The result of the test of one hypothesis, that is, of one possible fault of a log. The fault was fitted as one additional
//! unknown u, the size of the fault. Defines when a fault is significant (u differs from zero) and when it is found (u is also
//! large enough, and the fault reduces the error of cross-validation).

use crate::estimate::hypothesis::{Counts, Hypothesis};

/// The result of the test of one hypothesis.
#[derive(Clone, Debug, PartialEq)]
pub struct HypothesisTest {
    /// The tested hypothesis.
    pub of: Hypothesis,
    /// Estimated size u of the fault, in the unit of the hypothesis.
    pub value: f64,
    /// Standard deviation of `value`; infinite if the hypothesis is not identifiable.
    pub deviation: f64,
    /// Smallest |u| that would have been found (u: size of the fault); infinite if no size would have been found.
    pub power: f64,
    /// Two relative errors of cross-validation: without the fault, and with the fault as an unknown. `None` if not computed.
    pub held_out: Option<(f64, f64)>,
    /// Norm of the weighted torque of the coordinate that the hypothesis concerns, divided by the norm of the weighted torque
    /// of all coordinates; 1 for a hypothesis without a coordinate.
    pub torque_share: f64,
    /// Change of each parameter if the fault is fitted too; empty if the hypothesis is not identifiable.
    pub effect: Vec<f64>,
    /// Indices of parameters: the column of the hypothesis is a linear combination of the columns of these parameters. Empty if
    /// the hypothesis is identifiable.
    pub within: Vec<usize>,
}

impl HypothesisTest {
    /// Makes the result for a hypothesis that is not identifiable.
    pub(super) fn not_identifiable(of: &Hypothesis) -> HypothesisTest {
        let (none, of, torque_share) = (f64::INFINITY, *of, 1.0);
        let (effect, within) = (Vec::new(), Vec::new());
        HypothesisTest { of, value: 0.0, deviation: none, power: none, held_out: None, torque_share, effect, within }
    }

    /// Whether the fault is found: the fault is significant, large enough, and reduces the error of cross-validation.
    pub(crate) fn is_found(&self) -> bool {
        let is_large = self.value.abs() > self.of.kind().least && self.is_possible();
        let is_worth_naming = |(without, with): (f64, f64)| {
            with < WORTHWHILE_ERROR_RATIO * without && self.explained() > self.of.kind().least_share
        };
        self.of.kind().counts != Counts::InDeviations
            && self.is_significant()
            && is_large
            && self.held_out.is_some_and(is_worth_naming)
    }

    /// Ratio of the errors of cross-validation (with the fault / without it); `None` if the fault is not found.
    pub fn gain(&self) -> Option<f64> {
        self.held_out.filter(|_| self.is_found()).map(|(without, with)| with / without)
    }

    /// Share of the torque that the fault explains in cross-validation, from 0 to 1; 0 if not computed.
    pub(crate) fn explained(&self) -> f64 {
        self.held_out.map_or(0.0, |(without, with)| (without * without - with * with).max(0.0).sqrt())
    }

    /// Explained share of the torque of the joint of the fault, if the fault explains nothing at other joints.
    pub(crate) fn explained_at_joint(&self) -> f64 {
        if self.torque_share > 0.0 { self.explained() / self.torque_share } else { 0.0 }
    }

    /// Whether a machine can have a fault of the fitted size. For a kind of fault whose size cannot be negative, the size must
    /// exceed the smallest reported size.
    pub(crate) fn is_possible(&self) -> bool {
        !self.of.kind().is_positive || self.value > self.of.kind().least
    }

    /// Whether the size of the fault is significantly different from zero.
    pub fn is_significant(&self) -> bool {
        self.value.abs() > FOUND_FAULT_SIGMAS * self.deviation
    }

    /// The coordinate of a rotor with a positive, significant inertia that reduces the error of cross-validation.
    pub fn significant_rotor(&self) -> Option<usize> {
        let Hypothesis::Rotor(k) = self.of else { return None };
        let is_better = self.held_out.is_some_and(|(without, with)| with < without);
        (self.is_significant() && self.value > 0.0 && is_better).then_some(k)
    }
}

/// A fault is significant if its size exceeds this many standard deviations.
pub const FOUND_FAULT_SIGMAS: f64 = 6.0;
/// A fault is found only if it multiplies the error of cross-validation by less than this value.
pub(super) const WORTHWHILE_ERROR_RATIO: f64 = 0.9;
