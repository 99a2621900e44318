//! Columns that are independent, but too weak for a motion to show them.
//!
//! Where two axes are parallel but for an angle a, some columns stand out of the span of the others by a or a^2 of their
//! norm, which a double cannot tell from rounding, or no measurement from noise. The finite field finds them independent;
//! the numbers drop them. So do they where two lengths agree by chance, which is another matter: there the columns are
//! ordinary ones of almost every robot. The two are told apart by changing all numbers.

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

/// What relations may leave out of a column, relative to the largest: a torque to six digits.
pub(crate) const MOST_LEFT_OUT: f64 = 1e-6;
/// The numbers draw their line clearly where weak columns are named: of those that are kept, the weakest stands out this
/// many times more than any that is dropped. What is dropped wrongly has its name.
pub(crate) const WEAK_GAP: f64 = 1e2;

/// What the relations of these columns leave out of them at the sampled state where it is most. It is compared with the root mean
/// square of the largest column of the same joint, and the most of all joints counts: a wrist is weaker than a shoulder.
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

/// Lengths, and what angles differ by from a twelfth of pi, are changed by up to this part of themselves.
const CHANGE: f64 = 0.25;
/// Distance, and share of the largest column, of a column that stays weak where all numbers are changed: a hundred and ten
/// times what the numbers drop, because it grows with the second power of an angle or the fourth of a length.
const STAYS_WEAK: (f64, f64) = (100.0 * INDEPENDENT, 1e-8);

/// Whether columns that the numbers drop are nearly in the span of the others at other numbers too: an angle that is
/// nearly, but not quite, zero makes such. Columns that two equal lengths tie together are not. Of loops, which close at
/// few other numbers, those are weak that stand out by more than rounding.
pub(crate) fn are_weak(robot: &Robot, regressor: &Function, numeric: &Scan, weak: &[usize]) -> bool {
    if !robot.passive.is_empty() {
        return weak.iter().all(|&c| numeric.distance[c] > CLEAR_GAP * SCAN_ROUNDING);
    }
    let constants = regressor.constants();
    let graph = regressor.graph();
    let is_angle = |e: Expr| graph.nodes().iter().any(|n| matches!(n, Node::Sin(a) | Node::Cos(a) if *a == e));
    let mut random = SplitMix(2001);
    let changed = |(e, _, x): &(Expr, String, f64)| {
        let twelfth = std::f64::consts::PI / 12.0;
        let special = if is_angle(*e) { (x / twelfth).round() * twelfth } else { 0.0 };
        special + (x - special) * (1.0 + CHANGE * random.unit())
    };
    let values: Vec<f64> = constants.iter().map(changed).collect();
    let names: Vec<String> = constants.into_iter().map(|(_, name, _)| name).collect();
    let function = regressor.with_constants_as_input("constants", &names);
    let triangle = triangle(&sampled(&function, None, &values), regressor.outputs[0].rows);
    let stays = |scan: &Scan| weak.iter().all(|&c| scan.distance[c] < STAYS_WEAK.0 || scan.share[c] < STAYS_WEAK.1);
    scan(&triangle, Some(&numeric.kept)).is_ok_and(|scan| stays(&scan))
}
