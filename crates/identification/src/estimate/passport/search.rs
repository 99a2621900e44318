//! The mistakes of single joints or pairs that, once undone, make the description predict the log.
//!
//! Each change is tried on some hundred samples. The one with the smallest sum of misfits is taken where it removes
//! enough of them, and the search goes on from there for further mistakes. A zero is searched every 15 degrees and then
//! refined. Where no such mistakes explain the log, an order of its columns is searched (`order`).

use std::f64::consts::{FRAC_PI_2, PI};

use crate::estimate::hypothesis::Columns;
use crate::estimate::hypothesis::Hypothesis::{self, *};
use crate::estimate::passport::change::{Change, Description, misfits, motion_of, torque_of};
use crate::estimate::passport::finding::Fault;
use crate::estimate::passport::regression::Partial;
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

/// More mistakes than this are another robot.
const MAX_MISTAKES: usize = 3;

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
    /// The mistakes found, and the misfits of the joints with them undone.
    pub(super) fn best(&self, as_it_is: &[Partial]) -> (Vec<Suspicion>, Vec<f64>) {
        let counted: Vec<bool> = as_it_is.iter().map(|p| counts(p, self.scale, COUNTED_JOINT_SHARE)).collect();
        let n = counted.iter().filter(|c| **c).count().max(1) as f64;
        let sum = |misfits: &[f64]| misfits.iter().zip(&counted).filter(|(_, c)| **c).map(|(m, _)| m).sum::<f64>();
        let unchanged = misfits(as_it_is, as_it_is, &[], self.scale);
        let (mut found, mut undone, mut current) = (Vec::new(), Vec::new(), unchanged.clone());
        while found.len() < MAX_MISTAKES {
            let before = sum(&current);
            // That velocities belong to other positions is known, so only the wrong columns are asked for.
            let known = found.is_empty() && !self.velocities.is_empty();
            if before < SMALLEST_MISFIT_GAIN && !known {
                break;
            }
            let next = match known {
                true => self.least(&self.pairs(), &undone, as_it_is, &sum),
                false => self.next(&undone, as_it_is, &sum),
            };
            let Some((change, misfits)) = next else { break };
            let after = sum(&misfits);
            let gain = if known { KNOWN_SWAP_GAIN_SHARE * before } else { SMALLEST_MISFIT_GAIN };
            if before - after < gain {
                break;
            }
            found.push(Suspicion { changes: vec![change], before: before / n, after: after / n });
            undone.push(change);
            current = misfits;
        }
        let (whole, left) = (sum(&unchanged), sum(&current));
        // A single mistake that explains the log well needs no order, unless it is part of one.
        let is_part = |one: &Suspicion| one.changes.iter().any(|change| change.of.exchanges().is_some());
        let is_single = found.len() == 1 && !found.iter().any(is_part);
        if whole >= SMALLEST_MISFIT_GAIN && (!is_single || left > EXPLAINED_BY_ORDER_MISFIT * n) {
            let ordered = self
                .order(as_it_is, &sum)
                .filter(|(_, m)| sum(m) < (EXPLAINED_BY_ORDER_MISFIT * n).min(LARGEST_SHARE_LEFT_BY_ZERO * left));
            if let Some((changes, misfits)) = ordered {
                return (vec![Suspicion { changes, before: whole / n, after: sum(&misfits) / n }], misfits);
            }
        }
        // A first mistake of two may explain little by itself; all together must explain most.
        if left > LARGEST_MISFIT_SHARE_LEFT * whole {
            return (Vec::new(), unchanged);
        }
        (merged(found), current)
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

    /// What undoes it, for a robot of n joints.
    ///
    /// Where that is an option with a list over the joints, the list serves all suspicions together.
    pub(super) fn remedy(&self, n: usize, all: &[Suspicion]) -> String {
        let Some(&Change { of: kind, .. }) = self.changes.first() else { return String::new() };
        let is_alike = |of: &Hypothesis| std::mem::discriminant(of) == std::mem::discriminant(&kind);
        let alike: Vec<Change> =
            all.iter().flat_map(|s| s.changes.iter().copied()).filter(|change| is_alike(&change.of)).collect();
        let size = |change: &Change| match change.of {
            Zero(_) => (1e4 * change.size).round() / 1e4,
            _ => -1.0,
        };
        let of_joint = |j: usize| alike.iter().find(|change| change.of.joint() == Some(j)).map(size);
        kind.undoing(|others| {
            let list: Vec<String> = (0..n).map(|j| of_joint(j).unwrap_or(others).to_string()).collect();
            format!("[{}]", list.join(", "))
        })
    }
}
