//! Mistakes of columns that explain postures: signs, exchanged torques and units. Where several do, all are named.
//!
//! With T the torque of the described bodies at the changed positions and tau the changed torque, both without their means,
//! ```text
//! left^2 = mean over joints of min_s |tau_j - s T_j|^2 / |tau_j|^2     s from one half to two
//! ```
//! A mistake is named where it leaves much less than the postures as they are do, and nearly as little as the best one.

use identification::estimate::hypothesis::Hypothesis::{self, MotionSign, Reversed, Scale, SwappedTorques, TorqueSign};
use identification::estimate::options::Options;
use identification::estimate::passport::{AS_WELL_RATIO, Change};
use logs::Postures;
use nalgebra::DVector;

/// What a mistake leaves, over what the postures leave as they are, below which it explains them, in squares.
const EXPLAINED_RATIO: f64 = 0.16;
/// Nor does it explain them where it leaves more than this.
const EXPLAINED: f64 = 0.25;
/// What bodies of their own leave of one joint with a mistake undone, over what they leave as it is, below which it is needed, in
/// squares.
const NEEDED_RATIO: f64 = 0.64;
/// The same of a wrong scale, of which some number takes up a part of any other fault.
const NEEDED_SCALE_RATIO: f64 = 0.25;
/// A joint counts where the described torque is more than this share of the measured one, in squares.
const COUNTED: f64 = 0.05;
/// Common scales within these are errors of the described bodies.
const NOMINAL_SCALES: std::ops::Range<f64> = 0.25..4.0;
/// Scales of one joint beside those of the others within these are.
const NOMINAL_JOINT_SCALES: std::ops::Range<f64> = 0.6..1.67;

/// A mistake that explains the postures.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// What is wrong.
    pub fault: String,
    /// What mends it.
    pub remedy: String,
    /// Share of the torques that the description leaves as they are, and with the mistake undone.
    pub left: [f64; 2],
}

/// The torque of the described bodies at a position, N m (N) of each joint.
pub(super) type Described<'a> = &'a dyn Fn(&[f64]) -> Vec<f64>;

/// What bodies of their own leave of the torque of each joint at positions, in squares.
pub(super) type Free<'a> = &'a dyn Fn(&[Vec<f64>], &[DVector<f64>]) -> Vec<f64>;

/// Looks for them. `torques`: N m (N) of each joint, one per posture; `options`: those by which the postures were read.
pub(super) fn mistakes(
    postures: &Postures,
    torques: &[DVector<f64>],
    described: Described,
    free: Free,
    options: &Options,
    turns: &[bool],
) -> Vec<Mistake> {
    let look = Look { postures, torques, described };
    let scale = look.common_scale();
    let before = look.left(&[]);
    let all = look.candidates(scale);
    let mut tried: Vec<(f64, Vec<Change>, String)> =
        all.into_iter().map(|(changes, fault)| (look.left(&changes), changes, fault)).collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A description allows slopes of a factor of two, so that a wrong scale moves what it leaves by little.
    let is_scale = |changes: &[Change]| matches!(changes, [Change { of: Scale(_), .. }]);
    tried.retain(|(left, changes, _)| {
        *left <= EXPLAINED * EXPLAINED && (is_scale(changes) || *left <= EXPLAINED_RATIO * before)
    });
    // Bodies of their own explain postures as they are, unless something else is wrong. Of all torques alike they explain any
    // sign and unit, with masses below zero or of tons.
    let as_it_is = free(&postures.q, torques);
    let is_of_all = |changes: &[Change]| changes.len() >= torques.len();
    tried.retain(|(_, changes, _)| {
        let (q, torques) = undone(changes, &postures.q, torques);
        let needed = if is_scale(changes) { NEEDED_SCALE_RATIO } else { NEEDED_RATIO };
        is_of_all(changes) || is_lower(&free(&q, &torques), &as_it_is, needed)
    });
    // At least a rounding: exact torques leave nothing.
    let least = tried.first().map_or(f64::INFINITY, |one| one.0);
    tried.retain(|one| one.0 <= AS_WELL_RATIO * least + 1e-9);
    let said = |changes: &[Change]| options.undoing(changes, &postures.names, turns)?.remedy_beside(options);
    let mistake = |(left, changes, fault): (f64, Vec<Change>, String)| Mistake {
        fault,
        remedy: said(&changes).unwrap_or_else(|| "[base=3.14159,0,0]".into()),
        left: [before.sqrt(), left.sqrt()],
    };
    tried.into_iter().map(mistake).collect()
}

struct Look<'a> {
    postures: &'a Postures,
    torques: &'a [DVector<f64>],
    described: Described<'a>,
}

impl Look<'_> {
    /// What may be wrong, each with the changes that undo it. Gravity upside down has none: no column of a table has it.
    fn candidates(&self, scale: f64) -> Vec<(Vec<Change>, String)> {
        let n = self.torques.len();
        let names: Vec<&str> = self.postures.coordinates.iter().map(String::as_str).collect();
        let change = |of: Hypothesis, size: f64| Change { of, size };
        let units: Vec<Change> = match NOMINAL_SCALES.contains(&scale) {
            true => Vec::new(),
            false => (0..n).map(|k| change(Scale(k), scale - 1.0)).collect(),
        };
        let mut all = Vec::new();
        let mut push = |changes: Vec<Change>, fault: String| match units.is_empty() {
            true => all.push((changes, fault)),
            false => {
                let power = scale.log10().round();
                let unit = format!("the torques are in another unit: 10^{power} times those of the description");
                all.push((
                    [units.clone(), changes].concat(),
                    if fault.is_empty() { unit } else { format!("{unit}; {fault}") },
                ));
            }
        };
        if !units.is_empty() {
            push(Vec::new(), String::new());
        }
        let of_all = (0..n).map(|k| change(TorqueSign(k), 0.0)).collect();
        push(
            of_all,
            "the torques of all joints have the wrong sign, or the base hangs upside down ([base=3.14159,0,0])".into(),
        );
        for k in 0..n {
            let slope = self.slope(k) / scale;
            if slope > 0.0 && !NOMINAL_JOINT_SCALES.contains(&slope) {
                let off = format!("{:.0} %", 100.0 * (slope - 1.0));
                push(vec![change(Scale(k), slope - 1.0)], Scale(k).statement(&off, &[names[k]]));
            }
            for of in [TorqueSign(k), MotionSign(k), Reversed(k)] {
                push(vec![change(of, 0.0)], of.statement("", &[names[k]]));
            }
            for l in k + 1..n {
                push(
                    vec![change(SwappedTorques(k, l), 0.0)],
                    SwappedTorques(k, l).statement("", &[names[k], names[l]]),
                );
            }
        }
        all
    }

    /// Measured per described torque, the median of the joints that count.
    fn common_scale(&self) -> f64 {
        let mut sizes: Vec<f64> = (0..self.torques.len()).map(|k| self.slope(k).abs()).filter(|s| *s > 0.0).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.get(sizes.len() / 2).copied().unwrap_or(1.0)
    }

    /// Measured per described torque of a joint; 0 where the description explains less than half of it.
    fn slope(&self, k: usize) -> f64 {
        let (described, measured) = (&self.at(&self.postures.q)[k], centred(&self.torques[k]));
        let (square, both) = (described.norm_squared(), described.dot(&measured));
        let is_told = both * both > 0.5 * square * measured.norm_squared();
        if is_told { both / square } else { 0.0 }
    }

    /// The described torques at the positions of these postures, without their means.
    fn at(&self, postures: &[Vec<f64>]) -> Vec<DVector<f64>> {
        let rows: Vec<Vec<f64>> = postures.iter().map(|q| (self.described)(q)).collect();
        let joint = |j: usize| centred(&DVector::from_iterator(rows.len(), rows.iter().map(|row| row[j])));
        (0..self.torques.len()).map(joint).collect()
    }

    /// The share of the torques that the description leaves with changes undone, joints alike, in squares.
    fn left(&self, changes: &[Change]) -> f64 {
        let (q, torques) = undone(changes, &self.postures.q, self.torques);
        let of_joint = |(described, torque): (&DVector<f64>, &DVector<f64>)| {
            let torque = centred(torque);
            let (whole, square) = (torque.norm_squared(), described.norm_squared());
            if whole == 0.0 || square < COUNTED * whole {
                return None;
            }
            let slope = (described.dot(&torque) / square).clamp(0.5, 2.0);
            Some(((torque - slope * described).norm_squared() / whole).min(1.0))
        };
        let all: Vec<f64> = self.at(&q).iter().zip(&torques).filter_map(of_joint).collect();
        if all.is_empty() { 1.0 } else { all.iter().sum::<f64>() / all.len() as f64 }
    }
}

/// Positions and torques with changes undone.
fn undone(changes: &[Change], q: &[Vec<f64>], torques: &[DVector<f64>]) -> (Vec<Vec<f64>>, Vec<DVector<f64>>) {
    let (mut q, mut torques) = (q.to_vec(), torques.to_vec());
    for change in changes {
        if let MotionSign(k) | Reversed(k) = change.of {
            q.iter_mut().for_each(|q| q[k] = -q[k]);
        }
        match change.of {
            TorqueSign(k) | Reversed(k) => torques[k].neg_mut(),
            SwappedTorques(k, l) => torques.swap(k, l),
            Scale(k) => torques[k] /= 1.0 + change.size,
            _ => {}
        }
    }
    (q, torques)
}

/// Whether the first are lower than the second: one of them by far, and all in the geometric mean.
fn is_lower(with: &[f64], without: &[f64], needed: f64) -> bool {
    let ratios: Vec<f64> = with.iter().zip(without).map(|(a, b)| a / b).filter(|x| x.is_finite() && *x > 0.0).collect();
    ratios.iter().any(|ratio| *ratio < needed) && ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() < 0.0
}

fn centred(x: &DVector<f64>) -> DVector<f64> {
    x.add_scalar(-x.mean())
}
