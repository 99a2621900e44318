//! The mistakes of single joints or pairs that, once undone, make the description predict the log.
//!
//! Each change is tried on some hundred samples. The one with the smallest sum of misfits is taken where it removes
//! enough of them, and the search goes on from there for further mistakes. A zero is searched every 15 degrees and then
//! refined. Where no such mistakes explain the log, an order of its columns is searched (`order`).

use std::f64::consts::{FRAC_PI_2, PI};

use crate::estimate::hypothesis::Columns;
use crate::estimate::hypothesis::Hypothesis::*;
use crate::estimate::passport::change::{Change, Description, misfits, motion_of, torque_of};
use crate::estimate::passport::finding::Fault;
use crate::estimate::passport::regression::{COUNTED_SLOPE_SHARE, Partial};
use crate::estimate::passport::samples::Samples;
use crate::estimate::passport::trials::Trials;

/// Where and with what to search.
pub(super) struct Search<'a> {
    pub samples: &'a Samples,
    pub rows: &'a [usize],
    /// The trials at `rows`.
    pub trials: &'a Trials<'a>,
    pub description: &'a Description<'a>,
    /// Measured per described torque, common to all joints.
    pub scale: f64,
    /// Joints whose velocity is the slope of another joint's position, with that joint.
    pub velocities: &'a [(usize, usize)],
}

/// A mistake that explains the log, with the mean misfit of the joints that count before and after.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Suspicion {
    /// One change, or the exchanges that make up an order.
    pub changes: Vec<Change>,
    pub before: f64,
    pub after: f64,
}

/// Mistakes, and the misfits of the joints with them undone.
pub(super) type Explanation = (Vec<Suspicion>, Vec<f64>);

/// More mistakes than this are another robot.
pub(super) const MAX_MISTAKES: usize = 3;
/// Changes beside the best one from which a search begins, in robots of at most so many joints; they leave at most so many
/// times what that leaves.
const FIRST_STEPS: usize = 6;
const FIRST_STEP_RATIO: f64 = 2.0;
const MAX_JOINTS_FOR_ALL_FIRSTS: usize = 12;

/// All changes together must leave less than this share of the misfits.
const LARGEST_MISFIT_SHARE_LEFT: f64 = 0.6;
/// Each change must remove so much of the sum of the misfits.
pub(super) const SMALLEST_MISFIT_GAIN: f64 = 0.5;
/// An arbitrary zero must leave less than this share of what the plain changes leave.
const LARGEST_SHARE_LEFT_BY_ZERO: f64 = 0.7;

/// Misfit that a mistake leaves, of that of the log as it is, below which the description asks for it: in squares, as
/// `power::TURNED_ERROR_RATIO` has it.
pub(super) const LIKELY_MISFIT_SHARE: f64 = 0.16;

/// Mean misfit below which an order of the columns, one of thousands, explains the log.
const EXPLAINED_BY_ORDER_MISFIT: f64 = 0.15;

/// Share of the misfits that a swap must remove, where velocities are known to belong to other positions.
const KNOWN_SWAP_GAIN_SHARE: f64 = 0.1;

/// A joint counts where the description's torque is more than this share of the measured one, in squares. A wrist that
/// is all friction does not count.
pub(super) const COUNTED_JOINT_SHARE: f64 = 0.05;

/// Whether the description's torque is more than a share of the measured one, in squares.
pub(super) fn counts(partial: &Partial, scale: f64, share: f64) -> bool {
    partial.weight() * scale * scale > share
}

/// Pairs farther apart along the coordinates are not tried in robots of more joints than [`MAX_JOINTS_FOR_ALL_PAIRS`].
const NEAR_PAIR_DISTANCE: usize = 3;
/// Robots of at most so many joints are searched for exchanges of all pairs.
const MAX_JOINTS_FOR_ALL_PAIRS: usize = 8;

/// Behind the last joint that is tried in pairs with joint k of n.
pub(super) fn last_of_pairs(k: usize, n: usize) -> usize {
    if n > MAX_JOINTS_FOR_ALL_PAIRS { (k + NEAR_PAIR_DISTANCE + 1).min(n) } else { n }
}

/// Steps of the search for a zero, rad.
const ZERO_SEARCH_STEP_RAD: f64 = PI / 12.0;
/// How near a zero must be to a quarter turn to count as one, rad.
const QUARTER_TURN_TOLERANCE_RAD: f64 = PI / 36.0;

/// The sum of those misfits that count.
pub(super) type Sum<'a> = &'a (dyn Fn(&[f64]) -> f64 + Sync);

impl Search<'_> {
    /// Sets of mistakes that explain the log, each with the misfits of the joints with it undone: that of the best first step,
    /// then those of the next best. One without a mistake where none explains it.
    pub(super) fn best(&self, as_it_is: &[Partial]) -> Vec<Explanation> {
        let counted: Vec<bool> = as_it_is.iter().map(|p| counts(p, self.scale, COUNTED_JOINT_SHARE)).collect();
        let sum = |misfits: &[f64]| misfits.iter().zip(&counted).filter(|(_, c)| **c).map(|(m, _)| m).sum::<f64>();
        let unchanged = misfits(as_it_is, as_it_is, &[], self.scale);
        let n = counted.iter().filter(|c| **c).count().max(1) as f64;
        // That velocities belong to other positions is known, so only the wrong columns are asked for.
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
        // A single mistake that explains the log well needs no order, unless it is part of one.
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
        // A first mistake of two may explain little by itself; all together must explain most.
        found.retain(|(_, misfits)| sum(misfits) <= LARGEST_MISFIT_SHARE_LEFT * whole);
        match found.is_empty() {
            true => vec![(Vec::new(), unchanged)],
            false => found.into_iter().map(|(set, misfits)| (merged(set), misfits)).collect(),
        }
    }

    /// The changes that leave least, the best first.
    fn firsts(&self, as_it_is: &[Partial], sum: Sum) -> Vec<(Change, Vec<f64>)> {
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

    /// The mistakes that follow a first one, as long as each explains much.
    fn from(
        &self,
        first: (Change, Vec<f64>),
        unchanged: &[f64],
        n: f64,
        as_it_is: &[Partial],
        sum: Sum,
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

    /// The change that leaves least beside those undone.
    fn next(&self, undone: &[Change], as_it_is: &[Partial], sum: Sum) -> Option<(Change, Vec<f64>)> {
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
        sum: Sum,
    ) -> Option<(Change, Vec<f64>)> {
        let tried = changes.iter().map(|&change| (change, self.all_tried(&[undone, &[change]].concat(), as_it_is)));
        tried.min_by(|a, b| sum(&a.1).total_cmp(&sum(&b.1)))
    }

    /// Exchanges of positions or of velocities, for joints whose velocities belong to each other's positions.
    fn pairs(&self) -> Vec<Change> {
        let both = |&(k, l): &(usize, usize)| [SwappedPositions(k, l), SwappedVelocities(k, l)].map(Change::of);
        self.velocities.iter().filter(|(k, l)| k < l && self.velocities.contains(&(*l, *k))).flat_map(both).collect()
    }

    /// Changes that need no search for a number.
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

    /// The misfits with these changes.
    pub(super) fn all_tried(&self, changes: &[Change], as_it_is: &[Partial]) -> Vec<f64> {
        misfits(&self.trials.partials(changes), as_it_is, changes, self.scale)
    }

    /// The best zero of joint k.
    fn zero(&self, k: usize, undone: &[Change], as_it_is: &[Partial], sum: Sum) -> Change {
        // Few samples show where the zero is, and all of them how far.
        let few: Vec<usize> = self.rows.iter().step_by(4).copied().collect();
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

/// Slopes of one joint beside those of the others within these may be errors of nominal inertials.
const JOINT_FACTORS: std::ops::Range<f64> = 0.6..1.67;

/// Of a joint that went there and back less often, any scale suits some bodies.
const PERIODS_OF_SCALE: f64 = 1.5;

/// Joints whose slopes tell, beside which that of another is judged.
const JOINTS_BESIDE: usize = 2;

impl Search<'_> {
    /// The joints whose torque has another scale than those of the others, with `found` undone: their slopes are beyond what
    /// bodies of a description are off by.
    pub(super) fn scaled(&self, found: &[Suspicion], as_it_is: &[Partial]) -> Vec<Suspicion> {
        let undone: Vec<Change> = found.iter().flat_map(|one| one.changes.iter().copied()).collect();
        let partials = self.trials.partials(&undone);
        let tells = |p: &Partial| p.share() > COUNTED_SLOPE_SHARE && p.slope() * self.scale > 0.0;
        let mut sizes: Vec<f64> = partials.iter().filter(|p| tells(p)).map(|p| p.slope() / self.scale).collect();
        if sizes.len() <= JOINTS_BESIDE {
            return Vec::new();
        }
        sizes.sort_by(f64::total_cmp);
        let middle = sizes[sizes.len() / 2];
        let n = as_it_is.len() as f64;
        let one = |(k, p): (usize, &Partial)| {
            // Beside the others, and beside the description: half of the joints may be wrong.
            let slope = p.slope() / self.scale;
            let factor = slope / middle;
            let moves = self.samples.periods(k) >= PERIODS_OF_SCALE;
            let is_off = moves && tells(p) && !JOINT_FACTORS.contains(&factor) && !JOINT_FACTORS.contains(&slope);
            let share = |slope: f64| p.left(slope) / n;
            is_off.then(|| Suspicion {
                changes: vec![Change { of: Scale(k), size: factor - 1.0 }],
                before: share(middle * self.scale),
                after: share(p.slope()),
            })
        };
        partials.iter().enumerate().filter_map(one).collect()
    }
}

/// Merges exchanges of one kind into one order.
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

/// Rounds of the search between two steps, which give half a degree.
const ZERO_SEARCH_ROUNDS: usize = 10;

impl Suspicion {
    /// The joints that were changed, of n.
    pub(super) fn joints(&self, n: usize) -> Vec<usize> {
        match self.changes.as_slice() {
            [one] => one.of.joints(),
            _ => (0..n).filter(|&k| self.source(k) != k).collect(),
        }
    }

    /// The joint whose columns are those of joint k.
    pub(super) fn source(&self, k: usize) -> usize {
        match motion_of(&self.changes, k) {
            same if same == k => torque_of(&self.changes, k).0,
            other => other,
        }
    }

    pub(super) fn fault(&self) -> Fault {
        let Some(&first) = self.changes.first() else { return Fault::OtherRobot };
        if self.changes.len() > 1 {
            return Fault::Permuted(first.of.exchanges().unwrap_or(Columns::All));
        }
        Fault::Of(first.of, first.size)
    }
}
