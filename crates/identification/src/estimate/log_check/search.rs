//! Searches for faults of single joints or pairs of joints. A fault is accepted if the robot description with its nominal
//! bodies (inertial parameters) predicts the torques after the fault is undone in the log.
//!
//! Each change (one fault undone) is tried on a few hundred samples. The change with the smallest sum of misfits is accepted if
//! it reduces the sum by enough. The search then continues with this change applied. The zero of a position is searched in
//! steps of 15 degrees and then refined. If such faults do not explain the log, a permutation of its columns is searched
//! (`order`).
//!
//! Misfit of a joint: squared residual of the description, divided by the squared residual without the description; 0 to 1.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::estimate::hypothesis::ColumnKind;
use crate::estimate::hypothesis::Hypothesis::*;
use crate::estimate::log_check::change::{Change, Description, misfits, motion_of, torque_of};
use crate::estimate::log_check::finding::Fault;
use crate::estimate::log_check::regression::{COUNTED_SLOPE_SHARE, Partial};
use crate::estimate::log_check::samples::Samples;
use crate::estimate::log_check::trials::Trials;

pub(super) struct ChangeSearch<'a> {
    pub samples: &'a Samples,
    pub rows: &'a [usize],
    /// Comparison of the log with the description at the samples `rows`.
    pub trials: &'a Trials<'a>,
    pub description: &'a Description<'a>,
    /// Common scale of the torques of all joints: measured / nominal torque.
    pub scale: f64,
    /// Pairs (k, l) of different joints: the velocity of joint k is the derivative of the position of joint l.
    pub velocities: &'a [(usize, usize)],
}

/// A suspected fault. `before`, `after`: mean misfit (0 to 1) before and after the fault is undone, over the joints above
/// `COUNTED_JOINT_SHARE`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Suspicion {
    /// The change that undoes the fault; several exchanges if the fault is a permutation of columns.
    pub changes: Vec<Change>,
    pub before: f64,
    pub after: f64,
}

/// A set of suspected faults, and the misfit of each joint (error of the description, 0 to 1) after all these faults are
/// undone.
pub(super) type Explanation = (Vec<Suspicion>, Vec<f64>);

/// Largest number of faults of a log. A log with more faults is attributed to another robot.
pub(super) const MAX_MISTAKES: usize = 3;
/// The search starts from the best change (smallest sum of misfits), and in addition from at most this many other changes.
const FIRST_STEPS: usize = 6;
/// The search also starts from a change if the sum of misfits is at most the smallest sum times this factor.
const FIRST_STEP_RATIO: f64 = 2.0;
/// Largest number of joints of a robot for which the search starts from other changes than the best one.
const MAX_JOINTS_FOR_ALL_FIRSTS: usize = 12;

/// An explanation (a set of suspected faults) must reduce the sum of misfits to at most this share of the sum.
const LARGEST_MISFIT_SHARE_LEFT: f64 = 0.6;
/// Each change of an explanation must reduce the sum of misfits (one per joint, 0 to 1) by at least this value.
pub(super) const SMALLEST_MISFIT_GAIN: f64 = 0.5;
/// A zero offset with a fitted angle is compared with the best change without a fitted number. The zero offset is preferred
/// only if its sum of misfits is below the sum of the other change times this factor.
const LARGEST_SHARE_LEFT_BY_ZERO: f64 = 0.7;

/// A fault is likely if undoing it multiplies the misfit (relative squared residual) by less than this factor. The factor is
/// the square of `power::TURNED_ERROR_RATIO`, because a misfit is a squared error.
pub(super) const LIKELY_MISFIT_SHARE: f64 = 0.16;

/// A permutation explains the log if the mean misfit (relative squared residual, 0 to 1) is below this value. The limit is
/// strict, because thousands of permutations are tried.
const EXPLAINED_BY_ORDER_MISFIT: f64 = 0.15;

/// If velocities belong to the positions of other joints, an exchange of columns must reduce the sum of misfits by at least this
/// share.
const KNOWN_SWAP_GAIN_SHARE: f64 = 0.1;

/// A joint counts in the sum of misfits if the ratio squared nominal torque / squared measured torque exceeds this value. So a
/// wrist whose torque is mainly friction does not count.
pub(super) const COUNTED_JOINT_SHARE: f64 = 0.05;

/// Whether the ratio squared nominal torque / squared measured torque exceeds `share`. `scale`: factor on the nominal torque.
pub(super) fn counts(partial: &Partial, scale: f64, share: f64) -> bool {
    partial.weight() * scale * scale > share
}

/// Exchanges are tried for joints whose numbers differ by at most this value, if the robot has more joints than
/// [`MAX_JOINTS_FOR_ALL_PAIRS`].
const NEAR_PAIR_DISTANCE: usize = 3;
/// Largest number of joints for which exchanges of all pairs are tried.
const MAX_JOINTS_FOR_ALL_PAIRS: usize = 8;

/// Joint k is tried in a pair with each joint from k + 1 up to this number (exclusive). n: number of joints.
pub(super) fn last_of_pairs(k: usize, n: usize) -> usize {
    if n > MAX_JOINTS_FOR_ALL_PAIRS { (k + NEAR_PAIR_DISTANCE + 1).min(n) } else { n }
}

/// Step of the coarse search for a zero offset, rad.
const ZERO_SEARCH_STEP_RAD: f64 = PI / 12.0;
/// A zero offset is rounded to the nearest multiple of a quarter turn if it differs from this multiple by less than this angle,
/// rad.
const QUARTER_TURN_TOLERANCE_RAD: f64 = PI / 36.0;
/// The coarse search for a zero offset uses every fourth sample only.
const COARSE_SAMPLE_STEP: usize = 4;

/// Function that sums the misfits of those joints that count. The argument of the function contains the misfits of all joints.
pub(super) type MisfitSum<'a> = &'a (dyn Fn(&[f64]) -> f64 + Sync);

impl ChangeSearch<'_> {
    /// Finds sets of faults that explain the log, each with the misfits of the joints after the faults are undone. The set that
    /// starts with the best single fault comes first. If no faults explain the log, the result is one empty set. `as_it_is`:
    /// regression of the unchanged log.
    pub(super) fn best(&self, as_it_is: &[Partial]) -> Vec<Explanation> {
        let counted: Vec<bool> = as_it_is.iter().map(|p| counts(p, self.scale, COUNTED_JOINT_SHARE)).collect();
        let sum = |misfits: &[f64]| misfits.iter().zip(&counted).filter(|(_, c)| **c).map(|(m, _)| m).sum::<f64>();
        let unchanged = misfits(as_it_is, as_it_is, &[], self.scale);
        let n = counted.iter().filter(|c| **c).count().max(1) as f64;
        // If velocities belong to the positions of other joints, only an exchange of these columns is searched.
        let (firsts, gain) = match self.velocities.is_empty() {
            true => (self.firsts(as_it_is, &sum), SMALLEST_MISFIT_GAIN),
            false => {
                let known = self.least(&self.pairs(), &[], as_it_is, &sum);
                (known.into_iter().collect(), KNOWN_SWAP_GAIN_SHARE * sum(&unchanged))
            }
        };
        let begun = firsts.into_iter().filter(|(_, misfits)| sum(&unchanged) - sum(misfits) >= gain);
        let mut found: Vec<Explanation> = begun.map(|first| self.from(first, &unchanged, n, as_it_is, &sum)).collect();
        let whole = sum(&unchanged);
        let left = found.first().map_or(whole, |(_, misfits)| sum(misfits));
        // No permutation is searched if a single fault explains the log well and is not an exchange itself.
        let is_part = |one: &Suspicion| one.changes.iter().any(|change| change.of.exchanges().is_some());
        let is_single = found.first().is_some_and(|(set, _)| set.len() == 1 && !set.iter().any(is_part));
        if whole >= SMALLEST_MISFIT_GAIN && (!is_single || left > EXPLAINED_BY_ORDER_MISFIT * n) {
            let ordered = self
                .order(as_it_is, &sum)
                .filter(|(_, m)| sum(m) < (EXPLAINED_BY_ORDER_MISFIT * n).min(LARGEST_SHARE_LEFT_BY_ZERO * left));
            if let Some((changes, misfits)) = ordered {
                return vec![(vec![Suspicion { changes, before: whole / n, after: sum(&misfits) / n }], misfits)];
            }
        }
        // The first fault alone may explain little, but all faults together must explain most of the misfit.
        found.retain(|(_, misfits)| sum(misfits) <= LARGEST_MISFIT_SHARE_LEFT * whole);
        match found.is_empty() {
            true => vec![(Vec::new(), unchanged)],
            false => found.into_iter().map(|(set, misfits)| (merged(set), misfits)).collect(),
        }
    }

    /// The changes from which the search starts (each undoes one fault), the best first. Each change comes with the misfits of
    /// the joints after this change.
    fn firsts(&self, as_it_is: &[Partial], sum: MisfitSum) -> Vec<(Change, Vec<f64>)> {
        let n = as_it_is.len();
        if sum(&misfits(as_it_is, as_it_is, &[], self.scale)) < SMALLEST_MISFIT_GAIN {
            return Vec::new();
        }
        let best = self.next(&[], as_it_is, sum);
        let most = if n > MAX_JOINTS_FOR_ALL_FIRSTS { 0 } else { FIRST_STEPS };
        let plain = self.plain(n).into_iter().map(|change| (change, self.all_tried(&[change], as_it_is)));
        let mut others: Vec<(Change, Vec<f64>)> = plain.collect();
        others.sort_by(|a, b| sum(&a.1).total_cmp(&sum(&b.1)));
        let is_other = |one: &(Change, Vec<f64>)| best.as_ref().is_none_or(|best| best.0 != one.0);
        let least = best.as_ref().map_or(0.0, |best| sum(&best.1));
        others.retain(|one| is_other(one) && sum(&one.1) <= FIRST_STEP_RATIO * least);
        others.truncate(most);
        best.into_iter().chain(others).collect()
    }

    /// Builds the explanation (set of faults) that starts with the change `first`. Further changes are added as long as each
    /// change reduces the misfits by enough.
    fn from(
        &self,
        first: (Change, Vec<f64>),
        unchanged: &[f64],
        n: f64,
        as_it_is: &[Partial],
        sum: MisfitSum,
    ) -> Explanation {
        let (mut found, mut undone, mut current) = (Vec::new(), Vec::new(), unchanged.to_vec());
        let mut next = Some(first);
        while let Some((change, misfits)) = next {
            let (before, after) = (sum(&current), sum(&misfits));
            if !found.is_empty() && before - after < SMALLEST_MISFIT_GAIN {
                break;
            }
            found.push(Suspicion { changes: vec![change], before: before / n, after: after / n });
            undone.push(change);
            current = misfits;
            let goes_on = found.len() < MAX_MISTAKES && after >= SMALLEST_MISFIT_GAIN;
            next = if goes_on { self.next(&undone, as_it_is, sum) } else { None };
        }
        (found, current)
    }

    /// Of all changes that can follow the changes `undone`: the change with the smallest sum of misfits, and the misfits of the
    /// joints after this change.
    fn next(&self, undone: &[Change], as_it_is: &[Partial], sum: MisfitSum) -> Option<(Change, Vec<f64>)> {
        let plain = self.least(&self.plain(as_it_is.len()), undone, as_it_is, sum)?;
        let is_angle = |k: &usize| !self.description.regressor.is_prismatic(*k);
        let zeros: Vec<Change> =
            (0..as_it_is.len()).filter(is_angle).map(|k| self.zero(k, undone, as_it_is, sum)).collect();
        match self.least(&zeros, undone, as_it_is, sum) {
            Some(zero) if sum(&zero.1) < LARGEST_SHARE_LEFT_BY_ZERO * sum(&plain.1) => Some(zero),
            _ => Some(plain),
        }
    }

    fn least(
        &self,
        changes: &[Change],
        undone: &[Change],
        as_it_is: &[Partial],
        sum: MisfitSum,
    ) -> Option<(Change, Vec<f64>)> {
        let tried = changes.iter().map(|&change| (change, self.all_tried(&[undone, &[change]].concat(), as_it_is)));
        tried.min_by(|a, b| sum(&a.1).total_cmp(&sum(&b.1)))
    }

    /// The possible exchanges of position columns or of velocity columns. A pair of joints is exchanged if the velocity of each
    /// joint is the derivative of the position of the other joint.
    fn pairs(&self) -> Vec<Change> {
        let both = |&(k, l): &(usize, usize)| [SwappedPositions(k, l), SwappedVelocities(k, l)].map(Change::of);
        self.velocities.iter().filter(|(k, l)| k < l && self.velocities.contains(&(*l, *k))).flat_map(both).collect()
    }

    /// All changes that are tried and have no fitted size (zero offsets: quarter turns only). n: number of joints.
    fn plain(&self, n: usize) -> Vec<Change> {
        let mut all = [Degrees, GravityCompensated].map(Change::of).to_vec();
        for k in 0..n {
            all.extend([TorqueSign(k), MotionSign(k), Reversed(k)].map(Change::of));
            if !self.description.regressor.is_prismatic(k) {
                all.extend([FRAC_PI_2, PI, -FRAC_PI_2].map(|angle| Change::turned(k, angle)));
            }
            for l in k + 1..last_of_pairs(k, n) {
                all.extend([SwappedMotions(k, l), SwappedTorques(k, l), SwappedJoints(k, l)].map(Change::of));
            }
        }
        all
    }

    /// The misfit of each joint after these changes.
    pub(super) fn all_tried(&self, changes: &[Change], as_it_is: &[Partial]) -> Vec<f64> {
        misfits(&self.trials.partials(changes), as_it_is, changes, self.scale)
    }

    /// Finds the zero offset of joint k with the smallest sum of misfits, and returns the change that undoes this offset. The
    /// changes `undone` are applied first.
    fn zero(&self, k: usize, undone: &[Change], as_it_is: &[Partial], sum: MisfitSum) -> Change {
        // The coarse search uses few samples; the refinement uses all.
        let few: Vec<usize> = self.rows.iter().step_by(COARSE_SAMPLE_STEP).copied().collect();
        let few = Trials::new(self.description, &self.samples.kept, &few);
        let rough = few.partials(&[]);
        let turned = |angle: f64| [undone, &[Change::turned(k, angle)]].concat();
        let least = |angle: f64| {
            let changes = turned(angle);
            sum(&misfits(&few.partials(&changes), &rough, &changes, self.scale))
        };
        let left = |angle: f64| sum(&self.all_tried(&turned(angle), as_it_is));
        let steps = (2.0 * PI / ZERO_SEARCH_STEP_RAD).round() as i32;
        let coarse = (1..steps).map(|i| ZERO_SEARCH_STEP_RAD * f64::from(i));
        let best = coarse.map(|a| (a, least(a))).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |b| b.0);
        let (mut low, mut high) = (best - ZERO_SEARCH_STEP_RAD, best + ZERO_SEARCH_STEP_RAD);
        for _ in 0..ZERO_SEARCH_ROUNDS {
            let third = (high - low) / 3.0;
            if left(low + third) < left(high - third) {
                high -= third;
            } else {
                low += third;
            }
        }
        let angle = 0.5 * (low + high);
        let quarter = (angle / FRAC_PI_2).round() * FRAC_PI_2;
        let angle =
            if quarter != 0.0 && (angle - quarter).abs() < QUARTER_TURN_TOLERANCE_RAD { quarter } else { angle };
        Change::turned(k, if angle > PI { angle - 2.0 * PI } else { angle })
    }
}

/// Range of the slope (measured / nominal torque) of one joint, relative to the slopes of the other joints, that wrong nominal
/// inertials can explain.
const JOINT_FACTORS: std::ops::Range<f64> = 0.6..1.67;

/// Least number of periods (there and back) of a joint for a test of its scale. In a shorter motion, any scale can be explained
/// by other bodies (inertial parameters) than the nominal ones.
const LEAST_PERIODS_FOR_SCALE: f64 = 1.5;

/// The scale of a joint is tested only if at least this many other joints have meaningful slopes.
const LEAST_COMPARED_JOINTS: usize = 2;

impl ChangeSearch<'_> {
    /// Finds joints with a wrong scale of the torque, after the faults `found` are undone: their slopes (measured / nominal
    /// torque) differ from the slopes of the other joints by more than wrong nominal bodies explain.
    pub(super) fn scaled(&self, found: &[Suspicion], as_it_is: &[Partial]) -> Vec<Suspicion> {
        let undone: Vec<Change> = found.iter().flat_map(|one| one.changes.iter().copied()).collect();
        let partials = self.trials.partials(&undone);
        let is_meaningful = |p: &Partial| p.share() > COUNTED_SLOPE_SHARE && p.slope() * self.scale > 0.0;
        let mut sizes: Vec<f64> =
            partials.iter().filter(|p| is_meaningful(p)).map(|p| p.slope() / self.scale).collect();
        if sizes.len() <= LEAST_COMPARED_JOINTS {
            return Vec::new();
        }
        sizes.sort_by(f64::total_cmp);
        let middle = sizes[sizes.len() / 2];
        let n = as_it_is.len() as f64;
        let one = |(k, p): (usize, &Partial)| {
            // The slope must differ from the median and also from 1, because the median itself is wrong if half of the joints
            // are wrong.
            let slope = p.slope() / self.scale;
            let factor = slope / middle;
            let moves = self.samples.periods(k) >= LEAST_PERIODS_FOR_SCALE;
            let is_off =
                moves && is_meaningful(p) && !JOINT_FACTORS.contains(&factor) && !JOINT_FACTORS.contains(&slope);
            let share = |slope: f64| p.residual(slope) / n;
            is_off.then(|| Suspicion {
                changes: vec![Change { of: Scale(k), size: factor - 1.0 }],
                before: share(middle * self.scale),
                after: share(p.slope()),
            })
        };
        partials.iter().enumerate().filter_map(one).collect()
    }
}

/// If all suspected faults are exchanges of one kind of columns, these exchanges are merged into one permutation.
fn merged(found: Vec<Suspicion>) -> Vec<Suspicion> {
    let all: Vec<Change> = found.iter().flat_map(|f| f.changes.iter().copied()).collect();
    let kind = all.first().and_then(|change| change.of.exchanges());
    match (found.first(), found.last()) {
        (Some(first), Some(last)) if kind.is_some() && all.iter().all(|change| change.of.exchanges() == kind) => {
            vec![Suspicion { changes: all, before: first.before, after: last.after }]
        }
        _ => found,
    }
}

/// Iterations of the ternary search for a zero offset between two coarse steps; accurate to half a degree.
const ZERO_SEARCH_ROUNDS: usize = 10;

impl Suspicion {
    /// Numbers of the joints that the fault concerns. n: number of joints of the robot.
    pub(super) fn joints(&self, n: usize) -> Vec<usize> {
        match self.changes.as_slice() {
            [one] => one.of.joints(),
            _ => (0..n).filter(|&k| self.source(k) != k).collect(),
        }
    }

    /// Number of the joint in the log whose columns belong to joint k.
    pub(super) fn source(&self, k: usize) -> usize {
        match motion_of(&self.changes, k) {
            same if same == k => torque_of(&self.changes, k).0,
            other => other,
        }
    }

    pub(super) fn fault(&self) -> Fault {
        let Some(&first) = self.changes.first() else { return Fault::OtherRobot };
        if self.changes.len() > 1 {
            return Fault::Permuted(first.of.exchanges().unwrap_or(ColumnKind::All));
        }
        Fault::Of(first.of, first.size)
    }
}
