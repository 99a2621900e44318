//! The order of the columns that makes the description predict the log, for all signals, the motions or the torques.
//!
//! A robot of few joints is tried in all its orders. With more joints only orders that people make are tried: joints by
//! the alphabet, from the tip to the base, turned round by some places, and any three in a circle. An order is a
//! product of exchanges: (a b c ..) = (a b)(b c)... Some samples rank the orders, and all of them say how well the best
//! one explains.

use std::convert::Infallible;

use processor::{in_order, threads};

use crate::estimate::passport::change::{Change, misfits};
use crate::estimate::passport::regression::Partial;
use crate::estimate::passport::search::{Search, Sum};
use crate::estimate::passport::trials::Trials;

/// Robots of at most so many joints are tried in all orders. Seven joints have 5 040.
const MAX_JOINTS_FOR_ALL_ORDERS: usize = 7;

/// Samples that rank the orders.
const RANKING_SAMPLES: usize = 100;

/// An exchange of something of two joints.
type Exchange = fn(usize, usize) -> Change;

/// Exchanges of all signals, of motions and of torques. The first two exchange the same motions.
const EXCHANGE_KINDS: [Exchange; 3] = [Change::SwappedJoints, Change::SwappedMotions, Change::SwappedTorques];

impl Search<'_> {
    /// The order that leaves least, as exchanges, with its misfits; `None` for a single joint.
    pub(super) fn order(&self, as_it_is: &[Partial], sum: Sum) -> Option<(Vec<Change>, Vec<f64>)> {
        let few: Vec<usize> = self.rows.iter().step_by((self.rows.len() / RANKING_SAMPLES).max(1)).copied().collect();
        let few = Trials::new(self.description, &self.samples.kept, &few);
        let unmoved = few.described(&[]);
        let rough = few.partials_of(&unmoved, &[]);
        let orders = orders(self.description.regressor.coordinates());
        let left = |_, order: &Vec<usize>| {
            let [joints, motions, torques] = EXCHANGE_KINDS.map(|kind| exchanges(order, kind));
            let moved = few.described(&motions);
            [(joints, &moved), (motions, &moved), (torques, &unmoved)].map(|(changes, described)| {
                sum(&misfits(&few.partials_of(described, &changes), &rough, &changes, self.scale))
            })
        };
        let mut least: Option<(f64, Vec<Change>)> = None;
        let ranked = in_order(&orders, threads(), left, |i, found| {
            for (left, kind) in found.into_iter().zip(EXCHANGE_KINDS) {
                if least.as_ref().is_none_or(|(least, _)| left.total_cmp(least).is_lt()) {
                    least = Some((left, exchanges(&orders[i], kind)));
                }
            }
            Ok::<(), Infallible>(())
        });
        ranked.ok()?;
        let (_, best) = least?;
        let misfits = self.all_tried(&best, as_it_is);
        Some((best, misfits))
    }
}

/// The orders to try, without the one as it is; `order[k]` is the joint whose columns are those of joint k.
fn orders(coordinates: &[String]) -> Vec<Vec<usize>> {
    let n = coordinates.len();
    let mut found = match n <= MAX_JOINTS_FOR_ALL_ORDERS {
        true => all(n),
        false => usual(coordinates),
    };
    found.retain(|order| order.iter().enumerate().any(|(k, of)| k != *of));
    found
}

/// All orders of n joints.
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

/// The exchanges that, one after the other, put the columns of joint `order[k]` to joint k.
fn exchanges(order: &[usize], kind: Exchange) -> Vec<Change> {
    let mut now: Vec<usize> = (0..order.len()).collect();
    let mut made = Vec::new();
    for k in 0..order.len() {
        // An order has every joint once, so a joint that is not in its place stands behind.
        let Some(at) = (k..order.len()).find(|&l| now[l] == order[k]) else { continue };
        if at != k {
            now.swap(k, at);
            made.push(kind(k, at));
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::passport::change::{motion_of, torque_of};

    #[test]
    fn exchanges_make_their_order() {
        for n in 1..6 {
            let orders = all(n);
            assert_eq!(orders.len(), (1..=n).product::<usize>());
            for order in &orders {
                let changes = exchanges(order, Change::SwappedJoints);
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
        // 8 * 7 * 6 / 3 circles of three, 7 turns, the alphabet both ways, and the way back.
        assert_eq!(found.len(), 112 + 7 + 3);
        for order in &found {
            let mut sorted = order.clone();
            sorted.sort();
            assert_eq!(sorted, (0..8).collect::<Vec<_>>());
        }
        assert_eq!(found[0], [6, 1, 3, 4, 5, 0, 7, 2]);
    }
}
