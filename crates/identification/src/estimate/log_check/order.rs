//! Searches for an order (permutation) of the columns of a log with which the description predicts the torques. Three
//! permutations are searched: of all columns, of the motion columns alone, and of the torque columns alone.
//!
//! For few joints all permutations are tried. For more joints only common mistakes are tried: joints in alphabetical order,
//! from the tip to the base, or rotated by some places; two to four limbs in any order; any cycle of three joints. The
//! permutations are ranked on a subset of the samples by their misfit, the relative squared error with which the description
//! predicts the torques. Then the misfit of the best permutation is computed on all samples.

use std::convert::Infallible;

use processor::{in_order, threads};

use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::log_check::change::{Change, misfits};
use crate::estimate::log_check::power::shows;
use crate::estimate::log_check::regression::Partial;
use crate::estimate::log_check::search::{ChangeSearch, LIKELY_MISFIT_SHARE, MisfitSum, Suspicion, last_of_pairs};
use crate::estimate::log_check::trials::Trials;

/// Largest number of joints for which all permutations are tried (5040 for seven joints).
const MAX_JOINTS_FOR_ALL_ORDERS: usize = 7;

/// Number of samples on which permutations are ranked.
const RANKING_SAMPLES: usize = 100;

/// A permutation counts as equally good if its sum of misfits (relative squared residuals) is at most the smallest sum times
/// this factor.
const AS_GOOD_ORDER_RATIO: f64 = 1.2;

/// An exchange that the search does not detect (`hidden_exchanges`) is not reported if the mean misfit of the unchanged log is
/// below this value (a relative error of 10 % of the torque).
const SMALLEST_EXCHANGE_MISFIT: f64 = 0.01;

/// Largest number of limbs (chains of joints, such as legs) of equal length for which all orders of the limbs are tried.
const MAX_LIMBS: usize = 4;

/// A function from the numbers of two joints to the hypothesis that the columns of these joints are exchanged.
type Exchange = fn(usize, usize) -> Hypothesis;

/// The kinds of exchanges: all signals, motions only, torques only. The function `order` relies on this sequence.
const EXCHANGE_KINDS: [Exchange; 3] =
    [Hypothesis::SwappedJoints, Hypothesis::SwappedMotions, Hypothesis::SwappedTorques];

impl ChangeSearch<'_> {
    /// The permutation with the smallest sum of misfits, as a list of exchanges, and the misfit of each joint with this
    /// permutation (error of the description, 0 to 1). `None` for a single joint. `as_it_is`: regression of the unchanged log;
    /// `sum`: function that adds the misfits of those joints that count.
    pub(super) fn order(&self, as_it_is: &[Partial], sum: MisfitSum) -> Option<(Vec<Change>, Vec<f64>)> {
        let few: Vec<usize> = self.rows.iter().step_by((self.rows.len() / RANKING_SAMPLES).max(1)).copied().collect();
        let few = Trials::new(self.description, &self.samples.kept, &few);
        let unmoved = few.nominal_torques(&[]);
        let rough = few.partials_of(&unmoved, &[]);
        let orders = orders(self.description.regressor.coordinates());
        let left = |_, order: &Vec<usize>| {
            let [joints, motions, torques] = EXCHANGE_KINDS.map(|kind| exchanges(order, kind));
            let moved = few.nominal_torques(&motions);
            [(joints, &moved), (motions, &moved), (torques, &unmoved)].map(|(changes, described)| {
                sum(&misfits(&few.partials_of(described, &changes), &rough, &changes, self.scale))
            })
        };
        let mut ranked = Vec::new();
        let Ok(()) = in_order(&orders, threads(), left, |i, found| {
            ranked
                .extend(found.into_iter().zip(EXCHANGE_KINDS).map(|(left, kind)| (left, exchanges(&orders[i], kind))));
            Ok::<(), Infallible>(())
        });
        // With equal limbs, several permutations have nearly equal misfits. The permutation with the fewest exchanges is the most
        // likely.
        let least = ranked.iter().map(|(left, _)| *left).min_by(f64::total_cmp)?;
        ranked.retain(|(left, _)| *left <= AS_GOOD_ORDER_RATIO * least);
        let (_, best) = ranked.into_iter().min_by(|a, b| a.1.len().cmp(&b.1.len()).then(a.0.total_cmp(&b.0)))?;
        let misfits = self.all_tried(&best, as_it_is);
        Some((best, misfits))
    }
}

impl ChangeSearch<'_> {
    /// The best exchange of `hidden`, as a suspicion (suspected fault); `None` if no exchange reduces the misfit by enough.
    /// `hidden`: pairs of joints, or of limbs, all of whose signals are exchanged in the log. The search does not try these
    /// exchanges, because such joints have similar bodies and so similar torques. `as_it_is`: regression of the unchanged log.
    pub(super) fn exchanged(&self, as_it_is: &[Partial], hidden: &[[Vec<usize>; 2]]) -> Option<Suspicion> {
        let mean = |misfits: &[f64]| misfits.iter().sum::<f64>() / misfits.len().max(1) as f64;
        let before = mean(&misfits(as_it_is, as_it_is, &[], self.scale));
        let one = |[a, b]: &[Vec<usize>; 2]| {
            let changes: Vec<Change> =
                a.iter().zip(b).map(|(&k, &l)| Change::of(Hypothesis::SwappedJoints(k, l))).collect();
            let after = mean(&self.all_tried(&changes, as_it_is));
            Suspicion { changes, before, after }
        };
        let best = hidden.iter().map(one).min_by(|a, b| a.after.total_cmp(&b.after))?;
        (before > SMALLEST_EXCHANGE_MISFIT && best.after < LIKELY_MISFIT_SHARE * before).then_some(best)
    }
}

/// Pairs of joints, or of limbs (chains of joints) of equal length, whose exchange would not be detected in this log. Each member
/// of a pair is a list of joints.
pub(super) fn hidden_exchanges(trials: &Trials, slopes: &[Partial]) -> Vec<[Vec<usize>; 2]> {
    let n = slopes.len();
    let lengths = (2..=MAX_LIMBS).filter(|limbs| n.is_multiple_of(*limbs) && n > *limbs).map(|limbs| n / limbs);
    let mut hidden = Vec::new();
    for length in std::iter::once(1).chain(lengths) {
        let limbs: Vec<Vec<usize>> = (0..n / length).map(|k| (k * length..(k + 1) * length).collect()).collect();
        for (k, a) in limbs.iter().enumerate() {
            let last = if length == 1 { last_of_pairs(k, n) } else { limbs.len() };
            for b in &limbs[k + 1..last] {
                let changes: Vec<Change> =
                    a.iter().zip(b).map(|(&k, &l)| Change::of(Hypothesis::SwappedJoints(k, l))).collect();
                if !shows(trials, slopes, &changes) {
                    hidden.push([a.clone(), b.clone()]);
                }
            }
        }
    }
    hidden
}

/// The permutations that are tried, without the identity. `order[k]`: number of the joint in the log whose columns belong to
/// joint k.
fn orders(coordinates: &[String]) -> Vec<Vec<usize>> {
    let n = coordinates.len();
    let mut found = match n <= MAX_JOINTS_FOR_ALL_ORDERS {
        true => all(n),
        false => usual(coordinates),
    };
    found.retain(|order| order.iter().enumerate().any(|(k, of)| k != *of));
    found
}

fn all(n: usize) -> Vec<Vec<usize>> {
    (0..n).fold(vec![Vec::new()], |shorter, last| {
        let longer = |order: &Vec<usize>| {
            let order = order.clone();
            (0..=last).map(move |place| {
                let mut longer = order.clone();
                longer.insert(place, last);
                longer
            })
        };
        shorter.iter().flat_map(longer).collect()
    })
}

fn usual(coordinates: &[String]) -> Vec<Vec<usize>> {
    let n = coordinates.len();
    let mut sorted: Vec<usize> = (0..n).collect();
    sorted.sort_by_key(|&k| &coordinates[k]);
    let mut inverse = vec![0; n];
    sorted.iter().enumerate().for_each(|(place, &k)| inverse[k] = place);
    let mut found = vec![sorted, inverse, (0..n).rev().collect()];
    found.extend((1..n).map(|by| (0..n).map(|k| (k + by) % n).collect()));
    // Limbs of equal length are tried in all orders, because messages of legged robots often have another order of legs.
    for limbs in (2..=MAX_LIMBS).filter(|limbs| n.is_multiple_of(*limbs)) {
        let length = n / limbs;
        let joints = |order: &Vec<usize>| order.iter().flat_map(|limb| limb * length..(limb + 1) * length).collect();
        found.extend(all(limbs).iter().map(joints).filter(|order: &Vec<usize>| !order.is_sorted()));
    }
    let threes = (0..n).flat_map(|a| (a + 1..n).flat_map(move |b| (b + 1..n).map(move |c| [a, b, c])));
    for [a, b, c] in threes {
        for [to_b, to_c] in [[b, c], [c, b]] {
            let mut order: Vec<usize> = (0..n).collect();
            (order[a], order[to_b], order[to_c]) = (to_b, to_c, a);
            found.push(order);
        }
    }
    found
}

/// A list of exchanges of two joints. Applied in this order, they assign the columns of joint `order[k]` to each joint k.
fn exchanges(order: &[usize], kind: Exchange) -> Vec<Change> {
    let mut now: Vec<usize> = (0..order.len()).collect();
    let mut made = Vec::new();
    for k in 0..order.len() {
        // A permutation contains every joint once. So if joint `order[k]` is not at place k, this joint is at a later place.
        let Some(at) = (k..order.len()).find(|&l| now[l] == order[k]) else { continue };
        if at != k {
            now.swap(k, at);
            made.push(Change::of(kind(k, at)));
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::log_check::change::{motion_of, torque_of};

    #[test]
    fn exchanges_make_their_order() {
        for n in 1..6 {
            let orders = all(n);
            assert_eq!(orders.len(), (1..=n).product::<usize>());
            for order in &orders {
                let changes = exchanges(order, Hypothesis::SwappedJoints);
                let made: Vec<usize> = (0..n).map(|k| motion_of(&changes, k)).collect();
                assert_eq!(&made, order);
                assert!((0..n).all(|k| torque_of(&changes, k) == (order[k], 1.0)));
            }
        }
    }

    #[test]
    fn many_joints_have_the_usual_orders_once() {
        let names: Vec<String> =
            ["left", "arm", "wrist", "elbow", "hip", "knee", "ankle", "neck"].map(Into::into).into();
        let found = orders(&names);
        // Number of permutations: 8 * 7 * 6 / 3 cycles of three joints, 7 rotations, alphabetical order and its inverse,
        // reversed order, orders of two and of four limbs.
        assert_eq!(found.len(), 112 + 7 + 3 + 1 + 23);
        for order in &found {
            let mut sorted = order.clone();
            sorted.sort();
            assert_eq!(sorted, (0..8).collect::<Vec<_>>());
        }
        assert_eq!(found[0], [6, 1, 3, 4, 5, 0, 7, 2]);
    }
}
