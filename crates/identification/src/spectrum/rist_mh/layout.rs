//! The order of the unknowns of RIST-MH in one vector, for s spectra and n joints.
//!
//! ```text
//! [ X | f_1 .. f_n | u_1 .. u_s | ends of 1 .. s | effects ]
//! ```
//! X: base parameters; f_j: friction coefficients of joint j; u_e: drift of spectrum e, if there is drift; ends: the jumps of
//! velocity and of position from the end of the record to its start, two unknowns per spectrum if the motion need not repeat;
//! effects: delay, ripple, springs, eccentric encoders, elastic joints, play.

use std::ops::Range;

/// The number of unknowns of each kind. Their index ranges follow from these numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Number of base parameters.
    pub base: usize,
    /// Number of joints.
    pub joints: usize,
    /// Number of friction coefficients per joint.
    pub friction_of_joint: usize,
    /// Number of drifts: one per spectrum, or 0 without drift.
    pub drift_count: usize,
    /// Number of spectra with two unknowns for the jumps at the ends of the record: all spectra, or 0 if the motion repeats.
    pub ended_spectra: usize,
    /// Number of columns of all effects.
    pub effect_columns: usize,
}

impl Layout {
    /// Indices of the base parameters X.
    pub fn parameters(&self) -> Range<usize> {
        0..self.base
    }

    /// Indices of the friction coefficients f_j of a joint.
    pub fn friction(&self, joint: usize) -> Range<usize> {
        let first = self.base + joint * self.friction_of_joint;
        first..first + self.friction_of_joint
    }

    /// Indices of the base parameters X and all friction coefficients f_j.
    pub fn parameters_and_friction(&self) -> Range<usize> {
        0..self.base + self.joints * self.friction_of_joint
    }

    /// Indices of all drifts u_e.
    pub fn drifts(&self) -> Range<usize> {
        let first = self.parameters_and_friction().end;
        first..first + self.drift_count
    }

    /// Indices of the two unknowns for the ends of a spectrum: jumps of velocity and position from the end of the record to its
    /// start.
    pub fn ends(&self, spectrum: usize) -> Range<usize> {
        let first = self.drifts().end + 2 * spectrum;
        first..first + 2
    }

    /// Indices of the unknowns of all effects, in the order of the effects.
    pub fn effects(&self) -> Range<usize> {
        let first = self.drifts().end + 2 * self.ended_spectra;
        first..first + self.effect_columns
    }

    /// Number of all unknowns.
    pub fn unknowns(&self) -> usize {
        self.effects().end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ranges_follow_each_other() {
        for (drift_count, ended_spectra) in [(0, 0), (3, 0), (0, 3), (3, 3)] {
            let layout =
                Layout { base: 5, joints: 2, friction_of_joint: 4, drift_count, ended_spectra, effect_columns: 3 };
            let friction = (0..2).flat_map(|j| layout.friction(j));
            let ends = (0..ended_spectra).flat_map(|e| layout.ends(e));
            let all = layout.parameters().chain(friction).chain(layout.drifts()).chain(ends).chain(layout.effects());
            assert_eq!(all.collect::<Vec<_>>(), (0..layout.unknowns()).collect::<Vec<_>>());
        }
    }
}
