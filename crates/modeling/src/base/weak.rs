//! Finds columns of the regressor that are independent, but too weak in every motion.
//!
//! If two axes are parallel except for a small angle a, the distance of some columns from the span of the others is only a or
//! a^2 times their norm. Such a distance cannot be distinguished from rounding in a double, or from noise in a measurement. The
//! finite field finds these columns independent; the numeric scan drops them. The scan also drops columns if two lengths are
//! equal by chance, although these columns are not weak for almost every robot. To distinguish the two cases, all numbers are
//! changed.

use std::collections::{BTreeMap, BTreeSet};

use expr::{Expr, Function, Node};
use nalgebra::DMatrix;
use random::SplitMix;
use robot::Robot;

use crate::base::gate::SCAN_ROUNDING;
use crate::base::rank::{CLEAR_GAP, INDEPENDENT, Scan, scan};
use crate::base::regrouping::{Share, Shares};
use crate::base::samples::sampled;
use crate::base::triangle::triangle;

/// Largest component of a column that a relation may omit, relative to the largest column. Torques are then right to six digits.
pub(crate) const MOST_LEFT_OUT: f64 = 1e-6;
/// Weak columns are accepted if the smallest distance of a kept column is at least this many times the largest distance of a
/// dropped column. Columns that are dropped although the finite field keeps them are listed by name.
pub(crate) const WEAK_GAP: f64 = 1e2;

/// For each `inexact` column, the greatest component that its relation omits, over all sampled states and joints. The component
/// at a joint is divided by the rms of the largest column of this joint, because a wrist has smaller torques than a shoulder.
pub(crate) fn left_out(
    sampled: &DMatrix<f64>,
    joints: usize,
    shares: &Shares,
    inexact: &BTreeSet<usize>,
) -> BTreeMap<usize, f64> {
    let norm = |joint: usize, x: &[f64]| x.iter().skip(joint).step_by(joints).map(|x| x * x).sum::<f64>().sqrt();
    let largest =
        |joint: usize| sampled.column_iter().map(|c| norm(joint, c.as_slice())).fold(f64::MIN_POSITIVE, f64::max);
    let largest: Vec<f64> = (0..joints).map(|joint| if inexact.is_empty() { 1.0 } else { largest(joint) }).collect();
    let most = |joint: usize, x: &[f64]| {
        let of_joint = x.iter().skip(joint).step_by(joints);
        of_joint.clone().fold(0.0, |most: f64, x| most.max(x.abs())) * (of_joint.count() as f64).sqrt()
    };
    let rest = |&c: &usize| {
        let made = |rest, (kept, share): &(usize, Share)| rest - share.number * sampled.column(*kept);
        let rest = shares.get(&c).map(|row| row.iter().fold(sampled.column(c).into_owned(), made));
        let parts = (0..joints).map(|joint| rest.as_ref().map_or(0.0, |x| most(joint, x.as_slice()) / largest[joint]));
        (c, parts.fold(0.0, f64::max))
    };
    inexact.iter().map(rest).collect()
}

/// Largest relative change, in the test of weak columns, of a length and of an angle's difference from the next multiple of
/// pi/12.
const RELATIVE_CHANGE: f64 = 0.25;
/// A column stays weak if its relative distance is below this value after all numbers are changed. This value is a hundred
/// times the threshold of the scan, because the distance grows with the second power of an angle or the fourth of a length.
const WEAK_DISTANCE: f64 = 100.0 * INDEPENDENT;
/// A column also stays weak if its distance relative to the largest column is below this value. This value is ten times the
/// bound for a zero column.
const WEAK_SHARE: f64 = 1e-8;
/// Seed of the random changes of the robot's numbers.
const CHANGE_SEED: u64 = 2001;

/// Whether the `weak` columns, which the numeric scan drops, stay nearly in the span of the others when the robot's numbers
/// change. The columns stay there if an angle is almost zero, but not if two lengths are equal by chance. In a robot with
/// loops, the numbers cannot be changed freely, because the loops must close. For such a robot, a column counts as weak if its
/// distance from the span is above rounding.
pub(crate) fn are_weak(robot: &Robot, regressor: &Function, numeric: &Scan, weak: &[usize]) -> bool {
    if !robot.passive.is_empty() {
        return weak.iter().all(|&c| numeric.distance[c] > CLEAR_GAP * SCAN_ROUNDING);
    }
    let constants = regressor.constants();
    let graph = regressor.graph();
    let is_angle = |e: Expr| graph.nodes().iter().any(|n| matches!(n, Node::Sin(a) | Node::Cos(a) if *a == e));
    let mut random = SplitMix(CHANGE_SEED);
    let changed = |(e, _, x): &(Expr, String, f64)| {
        let twelfth = std::f64::consts::PI / 12.0;
        let special = if is_angle(*e) { (x / twelfth).round() * twelfth } else { 0.0 };
        special + (x - special) * (1.0 + RELATIVE_CHANGE * random.unit())
    };
    let values: Vec<f64> = constants.iter().map(changed).collect();
    let names: Vec<String> = constants.into_iter().map(|(_, name, _)| name).collect();
    let function = regressor.with_constants_as_input("constants", &names);
    let triangle = triangle(&sampled(&function, None, &values), regressor.outputs[0].rows);
    let stays = |scan: &Scan| weak.iter().all(|&c| scan.distance[c] < WEAK_DISTANCE || scan.share[c] < WEAK_SHARE);
    scan(&triangle, Some(&numeric.kept)).is_ok_and(|scan| stays(&scan))
}
