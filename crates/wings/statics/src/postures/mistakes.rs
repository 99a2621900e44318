//! Mistakes of columns that explain postures: signs, exchanged torques and units; and a zero or a mount that is far off. Where
//! several do, all are named.
//!
//! With T the torque of the described bodies at the changed positions and tau the changed torque, both without their means,
//! ```text
//! left^2 = mean over joints of min_s |tau_j - s T_j|^2 / |tau_j|^2     s from one half to two
//! ```
//! over the joints of whose torque something explains a part. A mistake is named where it leaves much less than the postures as
//! they are do, and nearly as little as the best one. Where the described bodies explain nothing so, bodies of their own do:
//! with a mistake undone they leave much less than without.

use claims::significant;
use identification::estimate::hypothesis::Hypothesis::{
    self, Degrees, MotionSign, Reversed, Scale, SwappedTorques, TorqueSign, Zero,
};
use identification::estimate::options::Options;
use identification::estimate::passport::{AS_WELL_RATIO, Change};
use logs::Postures;
use nalgebra::{DVector, Vector3};

use crate::postures::turned_joint::turned_joint;

/// What a mistake leaves, over what the postures leave as they are, below which it explains them, in squares.
const EXPLAINED_RATIO: f64 = 0.16;
/// Nor does it explain them where it leaves more than this.
pub(super) const EXPLAINED: f64 = 0.25;
/// One that leaves less than this more than the best one explains as well, in squares: as much is of the bodies.
const AS_WELL: f64 = 0.002;
/// What bodies of their own leave of one joint with a mistake undone, over what they leave as it is, below which it is needed, in
/// squares.
const NEEDED_RATIO: f64 = 0.64;
/// The same of a wrong scale, of which some number takes up a part of any other fault; and of the description with a zero far off.
const NEEDED_SCALE_RATIO: f64 = 0.25;
/// A joint counts where something leaves no more of its torque, in squares: of others noise is most.
const TOLD: f64 = 0.2;
/// What bodies of their own leave with a mistake undone, over what they leave as it is or with another undone, in squares and the
/// joints one times the other, below which they tell it from that.
const TOLD_BY_FREE: f64 = 0.01;
/// A zero beyond this is none of centres of mass that are off, rad.
const FAR_TURN: f64 = 0.7;
/// Common scales within these are errors of the described bodies.
const NOMINAL_SCALES: std::ops::Range<f64> = 0.25..4.0;
/// Scales of one joint beside those of the others within these are; and a common one beside a power of ten is that.
const NOMINAL_JOINT_SCALES: std::ops::Range<f64> = 0.6..1.67;

/// A mistake that explains the postures.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// What is wrong.
    pub fault: String,
    /// What mends it.
    pub remedy: String,
    /// Share of the torques that bodies leave as they are, and with the mistake undone.
    pub left: [f64; 2],
    /// Whether these are bodies that are free, and not those of the description.
    pub by_free_bodies: bool,
}

/// The torque of the described bodies at a position under gravity in the frame of the base, N m (N) of each joint.
pub(super) type Described<'a> = &'a dyn Fn(&[f64], &Vector3<f64>) -> Vec<f64>;

/// What bodies of their own leave of the torque of each joint at positions, in squares.
pub(super) type Free<'a> = &'a dyn Fn(&[Vec<f64>], &[DVector<f64>]) -> Vec<f64>;

/// What postures are held against.
pub(super) struct Look<'a> {
    pub postures: &'a Postures,
    /// N m (N) of each joint, one per posture.
    pub torques: &'a [DVector<f64>],
    pub described: Described<'a>,
    pub free: Free<'a>,
    /// Those by which the postures were read.
    pub options: &'a Options,
    /// Whether each joint turns.
    pub turns: &'a [bool],
    /// As described, m/s^2.
    pub gravity: Vector3<f64>,
    /// Another mount that explains the torques best, and the line that says it; `None`: zeros and mount are looked at elsewhere.
    pub mount: Option<(Vector3<f64>, String)>,
}

/// What may be wrong.
struct Candidate {
    /// What undoes it; a mount has none.
    changes: Vec<Change>,
    fault: String,
    /// What is left of the torque of each joint, in squares.
    shares: Vec<f64>,
}

impl Look<'_> {
    /// Looks for them.
    pub(super) fn mistakes(&self) -> Vec<Mistake> {
        let as_it_is = self.candidate(Vec::new(), String::new(), &self.gravity);
        let unit = self.unit();
        let of_unit = unit.as_ref().map(|(changes, _)| self.candidate(changes.clone(), String::new(), &self.gravity));
        let all = self.candidates(unit.as_ref());
        let counts = |j: &usize| all.iter().chain([&as_it_is]).any(|one| one.shares[*j] <= TOLD);
        let counted: Vec<usize> = (0..self.torques.len()).filter(counts).collect();
        let left = |one: &Candidate| {
            let sum: f64 = counted.iter().map(|&j| one.shares[j]).sum();
            if counted.is_empty() { 1.0 } else { sum / counted.len() as f64 }
        };
        let before = left(&as_it_is);
        // A fault beside a unit is needed where the unit alone explains less.
        let beside = |one: &Candidate| of_unit.as_ref().filter(|unit| one.changes.len() > unit.changes.len());
        let is_explained = |one: &&Candidate| {
            let of = |one: &Candidate| if is_of_all(one, &counted) { median(one, &counted) } else { left(one) };
            let than = beside(one)
                .map_or_else(|| if is_of_all(one, &counted) { median(&as_it_is, &counted) } else { before }, left);
            let explains = is_scale(&one.changes) || of(one) <= EXPLAINED_RATIO * than;
            of(one) <= EXPLAINED * EXPLAINED && explains && self.is_needed(one, &as_it_is, &counted)
        };
        let explained: Vec<&Candidate> = all.iter().filter(is_explained).collect();
        let by_free_bodies = explained.is_empty();
        let mistake = |one: &Candidate, left: [f64; 2]| Mistake {
            fault: one.fault.clone(),
            remedy: self.remedy(one),
            left: left.map(f64::sqrt),
            by_free_bodies,
        };
        if by_free_bodies {
            let some = all.iter().filter(|one| of_unit.is_none() && !one.changes.is_empty()).collect();
            let mean = |shares: &[f64]| shares.iter().map(|x| x.min(1.0)).sum::<f64>() / shares.len().max(1) as f64;
            let (as_it_is, tried) = self.told_by_free(some, TOLD_BY_FREE);
            return tried.iter().map(|(one, shares)| mistake(one, [mean(&as_it_is), mean(shares)])).collect();
        }
        let mut tried: Vec<&Candidate> =
            self.told_by_free(explained, f64::INFINITY).1.into_iter().map(|one| one.0).collect();
        tried.sort_by(|a, b| left(a).total_cmp(&left(b)));
        let least = tried.first().map_or(f64::INFINITY, |one| left(one));
        tried.retain(|one| left(one) <= AS_WELL_RATIO * least + AS_WELL);
        tried.into_iter().map(|one| mistake(one, [before, left(one)])).collect()
    }

    /// What mends it. Gravity upside down is no change of columns.
    fn remedy(&self, one: &Candidate) -> String {
        let of_mount = self.mount.as_ref().filter(|_| one.changes.is_empty()).map(|(_, line)| line.clone());
        let said = || self.options.undoing(&one.changes, &self.postures.names, self.turns)?.remedy_beside(self.options);
        of_mount.or_else(said).unwrap_or_else(|| "[base=3.14159,0,0]".into())
    }

    /// Whether bodies of their own do not explain the postures as they are as well. Of all torques alike they explain any sign and
    /// unit, with masses below zero or of tons; and a far turned joint or base with centres of mass that nobody would describe so.
    /// A wrist alone is turned by a centimetre of its centre of mass: a zero far off shows in other joints too.
    fn is_needed(&self, one: &Candidate, as_it_is: &Candidate, counted: &[usize]) -> bool {
        let mended = counted.iter().filter(|&&j| one.shares[j] < NEEDED_SCALE_RATIO * as_it_is.shares[j]).count();
        match one.changes[..] {
            [Change { of: Zero(_), size }] if size.abs() > FAR_TURN && mended >= counted.len().min(2) => return true,
            [Change { of: Zero(_), .. }] => {}
            _ if is_of_all(one, counted) || counted.len() == 1 => return true,
            _ => {}
        }
        let (q, torques) = undone(&one.changes, &self.postures.q, self.torques, self.turns);
        let needed = if is_scale(&one.changes) { NEEDED_SCALE_RATIO } else { NEEDED_RATIO };
        let ratios = ratios(&(self.free)(&q, &torques), &(self.free)(&self.postures.q, self.torques));
        ratios.iter().any(|ratio| *ratio < needed) && ratios.iter().product::<f64>() < 1.0
    }

    /// What bodies of their own leave as it is; and the candidates with which they explain the postures about as well as with the
    /// best one, the best first, with what they leave. `most`: over that without, the joints one times the other.
    fn told_by_free<'b>(&self, all: Vec<&'b Candidate>, most: f64) -> (Vec<f64>, Vec<(&'b Candidate, Vec<f64>)>) {
        let as_it_is = (self.free)(&self.postures.q, self.torques);
        let ratio = |one: &'b Candidate| {
            let (q, torques) = undone(&one.changes, &self.postures.q, self.torques, self.turns);
            let shares = (self.free)(&q, &torques);
            (ratios(&shares, &as_it_is).iter().product::<f64>(), one, shares)
        };
        let mut tried: Vec<(f64, &Candidate, Vec<f64>)> =
            all.into_iter().map(ratio).filter(|one| one.0 < most).collect();
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = tried.first().map_or(f64::INFINITY, |one| one.0);
        tried.retain(|one| one.0 <= least / TOLD_BY_FREE);
        (as_it_is, tried.into_iter().map(|(_, one, shares)| (one, shares)).collect())
    }

    /// The changes of a common unit that is not that of the description, and how large it is.
    fn unit(&self) -> Option<(Vec<Change>, f64)> {
        let scale = self.common_scale();
        let power = 10f64.powf(scale.log10().round());
        let scale = if NOMINAL_JOINT_SCALES.contains(&(scale / power)) { power } else { scale };
        let changes = (0..self.torques.len()).map(|k| Change { of: Scale(k), size: scale - 1.0 }).collect();
        (!NOMINAL_SCALES.contains(&scale)).then_some((changes, scale))
    }

    /// What may be wrong, each with the changes that undo it.
    fn candidates(&self, unit: Option<&(Vec<Change>, f64)>) -> Vec<Candidate> {
        let n = self.torques.len();
        let change = |of: Hypothesis, size: f64| Change { of, size };
        let mut all = Vec::new();
        let units = unit.map_or(&[][..], |(changes, _)| changes);
        let said = unit.map_or(String::new(), |(_, scale)| {
            let power = scale.log10().round();
            let times = if *scale == 10f64.powf(power) { format!("10^{power}") } else { significant(*scale, 2) };
            format!("the torques are in another unit: {times} times those of the description")
        });
        let mut push = |changes: Vec<Change>, fault: String| {
            let fault = [&said, &fault].into_iter().filter(|s| !s.is_empty()).cloned().collect::<Vec<_>>().join("; ");
            all.push(self.candidate([units, &changes].concat(), fault, &self.gravity));
        };
        if unit.is_some() {
            push(Vec::new(), String::new());
        }
        let of_all = (0..n).map(|k| change(TorqueSign(k), 0.0)).collect();
        push(
            of_all,
            "the torques of all joints have the wrong sign, or the base hangs upside down ([base=3.14159,0,0])".into(),
        );
        push(vec![change(Degrees, 0.0)], Degrees.statement("", &["the positions of joints that turn are"]));
        self.of_joints(unit.map_or(1.0, |unit| unit.1), &mut push);
        // A unit that one joint tells may be that of this joint.
        let told: Vec<usize> = (0..n).filter(|k| self.slope(*k) > 0.0).collect();
        if let ([k], Some(_)) = (&told[..], unit) {
            let size = self.slope(*k) - 1.0;
            let fault = Scale(*k).statement(&format!("{:.0} %", 100.0 * size), &[&self.postures.coordinates[*k]]);
            all.push(self.candidate(vec![Change { of: Scale(*k), size }], fault, &self.gravity));
        }
        if unit.is_none() {
            // Nearer ones stand beside each other where zeros and mount are looked at.
            let is_meant = |one: &Candidate| self.mount.is_some() || one.changes[0].size.abs() > FAR_TURN;
            let zeros = (0..n).filter(|k| self.turns[*k]).filter_map(|k| self.zero(k));
            all.extend(zeros.filter(is_meant));
        }
        if let (None, Some((gravity, _))) = (unit, &self.mount) {
            all.push(self.candidate(Vec::new(), "the base is mounted otherwise than described".into(), gravity));
        }
        all
    }

    /// What may be wrong with one joint, or with two. `scale`: of all torques.
    fn of_joints(&self, scale: f64, push: &mut impl FnMut(Vec<Change>, String)) {
        let n = self.torques.len();
        let names: Vec<&str> = self.postures.coordinates.iter().map(String::as_str).collect();
        for k in 0..n {
            let slope = self.slope(k) / scale;
            if slope > 0.0 && !NOMINAL_JOINT_SCALES.contains(&slope) {
                let off = format!("{:.0} %", 100.0 * (slope - 1.0));
                push(vec![Change { of: Scale(k), size: slope - 1.0 }], Scale(k).statement(&off, &[names[k]]));
            }
            for of in [TorqueSign(k), MotionSign(k), Reversed(k)] {
                push(vec![Change { of, size: 0.0 }], of.statement("", &[names[k]]));
            }
            for l in k + 1..n {
                let of = SwappedTorques(k, l);
                push(vec![Change { of, size: 0.0 }], of.statement("", &[names[k], names[l]]));
            }
        }
    }

    /// The zero of a joint, where one explains more than none.
    fn zero(&self, k: usize) -> Option<Candidate> {
        let left = |size: f64| {
            let (q, torques) = undone(&[Change { of: Zero(k), size }], &self.postures.q, self.torques, self.turns);
            self.shares(&q, &torques, &self.gravity).iter().sum::<f64>()
        };
        let size = turned_joint(&left)?;
        let off = format!("{:.0} degrees", -size.to_degrees());
        let fault = Zero(k).statement(&off, &[&self.postures.coordinates[k]]);
        Some(self.candidate(vec![Change { of: Zero(k), size }], fault, &self.gravity))
    }

    fn candidate(&self, changes: Vec<Change>, fault: String, gravity: &Vector3<f64>) -> Candidate {
        let (q, torques) = undone(&changes, &self.postures.q, self.torques, self.turns);
        let shares = self.shares(&q, &torques, gravity);
        Candidate { changes, fault, shares }
    }

    /// Measured per described torque, the median of the joints that tell it.
    fn common_scale(&self) -> f64 {
        let mut sizes: Vec<f64> = (0..self.torques.len()).map(|k| self.slope(k).abs()).filter(|s| *s > 0.0).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.get(sizes.len() / 2).copied().unwrap_or(1.0)
    }

    /// Measured per described torque of a joint; 0 where the description explains less than half of it.
    fn slope(&self, k: usize) -> f64 {
        let (described, measured) = (&self.at(&self.postures.q, &self.gravity)[k], centred(&self.torques[k]));
        let (square, both) = (described.norm_squared(), described.dot(&measured));
        let is_told = both * both > 0.5 * square * measured.norm_squared();
        if is_told { both / square } else { 0.0 }
    }

    /// The described torques at the positions of these postures, without their means.
    fn at(&self, postures: &[Vec<f64>], gravity: &Vector3<f64>) -> Vec<DVector<f64>> {
        let rows: Vec<Vec<f64>> = postures.iter().map(|q| (self.described)(q, gravity)).collect();
        let joint = |j: usize| centred(&DVector::from_iterator(rows.len(), rows.iter().map(|row| row[j])));
        (0..self.torques.len()).map(joint).collect()
    }

    /// The share of the torque of each joint that the description leaves, in squares.
    fn shares(&self, q: &[Vec<f64>], torques: &[DVector<f64>], gravity: &Vector3<f64>) -> Vec<f64> {
        let of_joint = |(described, torque): (&DVector<f64>, &DVector<f64>)| {
            let torque = centred(torque);
            let (whole, square) = (torque.norm_squared(), described.norm_squared());
            if whole == 0.0 || square == 0.0 {
                return 1.0;
            }
            let slope = (described.dot(&torque) / square).clamp(0.5, 2.0);
            ((torque - slope * described).norm_squared() / whole).min(1.0)
        };
        self.at(q, gravity).iter().zip(torques).map(of_joint).collect()
    }
}

/// Positions and torques with changes undone.
fn undone(
    changes: &[Change],
    q: &[Vec<f64>],
    torques: &[DVector<f64>],
    turns: &[bool],
) -> (Vec<Vec<f64>>, Vec<DVector<f64>>) {
    let (mut q, mut torques) = (q.to_vec(), torques.to_vec());
    for change in changes {
        let undo = |q: &mut Vec<f64>| match change.of {
            MotionSign(k) | Reversed(k) => q[k] = -q[k],
            Zero(k) => q[k] += change.size,
            Degrees => q.iter_mut().zip(turns).filter(|(_, turns)| **turns).for_each(|(q, _)| *q = q.to_radians()),
            _ => {}
        };
        q.iter_mut().for_each(undo);
        match change.of {
            TorqueSign(k) | Reversed(k) => torques[k].neg_mut(),
            SwappedTorques(k, l) => torques.swap(k, l),
            Scale(k) => torques[k] /= 1.0 + change.size,
            _ => {}
        }
    }
    (q, torques)
}

/// A description allows slopes of a factor of two, so that a wrong scale moves what it leaves by little.
fn is_scale(changes: &[Change]) -> bool {
    matches!(changes, [Change { of: Scale(_), .. }])
}

/// What is left of each joint, over what was.
fn ratios(with: &[f64], without: &[f64]) -> Vec<f64> {
    with.iter().zip(without).map(|(a, b)| a / b).filter(|x| x.is_finite() && *x > 0.0).collect()
}

/// Whether a fault is one of all joints that count.
fn is_of_all(one: &Candidate, counted: &[usize]) -> bool {
    let of = |change: &Change, j: usize| matches!(change.of, TorqueSign(k) | Scale(k) if k == j);
    one.changes.is_empty() || counted.iter().all(|&j| one.changes.iter().any(|change| of(change, j)))
}

/// What is left of the joint in the middle: of all of them one whose bodies are other ones says nothing.
fn median(one: &Candidate, counted: &[usize]) -> f64 {
    let mut shares: Vec<f64> = counted.iter().map(|&j| one.shares[j]).collect();
    shares.sort_by(f64::total_cmp);
    shares.get(shares.len().saturating_sub(1) / 2).copied().unwrap_or(1.0)
}

fn centred(x: &DVector<f64>) -> DVector<f64> {
    x.add_scalar(-x.mean())
}
