//! Finds mistakes in the columns of a table of postures: wrong signs, exchanged torques, wrong units, a large error of a joint's
//! zero position or of the orientation of the base (mount). If several mistakes explain the postures, all are named.
//!
//! For each possible mistake (candidate), the table is changed so that the mistake is corrected. T: torque of the nominal bodies
//! at the changed positions; tau: changed torque; both without their means; s: scale factor of joint j:
//! ```text
//! residual^2 = mean over joints of min_s |tau_j - s T_j|^2 / |tau_j|^2     s from one half to two
//! ```
//! The mean is over the joints for which some candidate explains most of the torque. A mistake is named if its residual is much
//! smaller than the residual of the unchanged postures, and nearly as small as the smallest one. If the nominal bodies do not
//! explain the torques, bodies with free parameters ("free bodies") are fitted: their residual must be much smaller after the
//! mistake is corrected.

use claims::significant;
use identification::estimate::hypothesis::Hypothesis::{
    self, Degrees, MotionSign, Reversed, Scale, SwappedTorques, TorqueSign, Zero,
};
use identification::estimate::log_check::{AS_WELL_RATIO, Change};
use identification::estimate::options::Options;
use logs::Postures;
use nalgebra::{DVector, Vector3};

use crate::postures::turned_joint::turned_joint;

/// A mistake explains the postures if the squared residual after its correction is below this fraction of the squared residual
/// before the correction.
const EXPLAINED_RATIO: f64 = 0.16;
/// A mistake does not explain the postures if the residual after its correction exceeds this fraction of the torque.
pub(super) const EXPLAINED: f64 = 0.25;
/// A mistake explains the postures equally well as the best mistake if its squared relative residual is larger by less than
/// this value. Errors of the nominal bodies cause differences of this size.
const EQUAL_RESIDUAL: f64 = 0.002;
/// A mistake is necessary if bodies with free parameters do not explain the table equally well without it. For at least one
/// joint, the correction of the mistake must reduce the squared residual of the fit of such bodies to less than this fraction.
const NEEDED_RATIO: f64 = 0.64;
/// The limit `NEEDED_RATIO` for two other cases: for a wrong scale, because a scale also reduces the residual of any other fault;
/// and for the nominal bodies with a large zero error.
const NEEDED_SCALE_RATIO: f64 = 0.25;
/// A joint is considered if the correction of some possible mistake reduces the squared relative residual of the joint's torque
/// to at most this value. The torques of other joints are mostly noise.
const COUNTED_RESIDUAL: f64 = 0.2;
/// Two possible mistakes are distinguishable in fits of bodies with free parameters if the ratio of their squared residuals
/// (product over the joints) is below this value.
const DISTINGUISHED_BY_FREE: f64 = 0.01;
/// A zero error above this value (rad) cannot be caused by errors of the centres of mass.
const FAR_ZERO_RAD: f64 = 0.7;
/// A common scale of all torques in this range may be caused by errors of the nominal bodies.
const NOMINAL_SCALES: std::ops::Range<f64> = 0.25..4.0;
/// The scale of one joint relative to the other joints may be caused by errors of the nominal bodies if it is in this range. A
/// common scale that differs from a power of ten by a factor in this range counts as this power of ten.
const NOMINAL_JOINT_SCALES: std::ops::Range<f64> = 0.6..1.67;

/// A mistake in the table that explains the postures.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// Description of what is wrong.
    pub fault: String,
    /// The option that corrects the mistake.
    pub remedy: String,
    /// Relative residuals of the torques: [with the table as it is, with the mistake corrected].
    pub left: [f64; 2],
    /// Whether the residuals are for bodies with free parameters instead of the nominal bodies.
    pub by_free_bodies: bool,
}

/// A function for the torques of the nominal bodies, N m (N) for each joint. Arguments: position, and gravity in the base frame.
pub(super) type Described<'a> = &'a dyn Fn(&[f64], &Vector3<f64>) -> Vec<f64>;

/// A function that fits bodies with free parameters to torques at positions. The function returns the squared relative residual
/// of each joint.
pub(super) type Free<'a> = &'a dyn Fn(&[Vec<f64>], &[DVector<f64>]) -> Vec<f64>;

/// The postures, and the models with which they are compared.
pub(super) struct MistakeSearch<'a> {
    pub postures: &'a Postures,
    /// For each joint, its torques at all postures, N m (N).
    pub torques: &'a [DVector<f64>],
    pub described: Described<'a>,
    pub free: Free<'a>,
    /// The options with which the postures were read.
    pub options: &'a Options,
    /// Whether each joint is revolute.
    pub turns: &'a [bool],
    /// Nominal gravity in the base frame, m/s^2.
    pub gravity: Vector3<f64>,
    /// The base orientation other than the nominal one that explains the torques best: the gravity vector in the base frame, and
    /// the option that sets the orientation. `None` if zeros and base orientation are estimated elsewhere.
    pub mount: Option<(Vector3<f64>, String)>,
}

/// A possible mistake, with the residuals after its correction.
struct MistakeCandidate {
    /// The changes that correct the mistake; empty for a wrong orientation of the base.
    changes: Vec<Change>,
    fault: String,
    /// For each joint, the squared relative residual with the mistake corrected.
    shares: Vec<f64>,
}

impl MistakeSearch<'_> {
    /// Finds all mistakes that explain the postures.
    pub(super) fn mistakes(&self) -> Vec<Mistake> {
        let as_it_is = self.candidate(Vec::new(), String::new(), &self.gravity);
        let unit = self.unit();
        let of_unit = unit.as_ref().map(|(changes, _)| self.candidate(changes.clone(), String::new(), &self.gravity));
        let all = self.candidates(unit.as_ref());
        let counts = |j: &usize| all.iter().chain([&as_it_is]).any(|one| one.shares[*j] <= COUNTED_RESIDUAL);
        let counted: Vec<usize> = (0..self.torques.len()).filter(counts).collect();
        let residual = |one: &MistakeCandidate| {
            let sum: f64 = counted.iter().map(|&j| one.shares[j]).sum();
            if counted.is_empty() { 1.0 } else { sum / counted.len() as f64 }
        };
        let before = residual(&as_it_is);
        // If the torques have a wrong unit, a second mistake is named only if it reduces the residual further than the correction
        // of the unit alone.
        let with_unit = |one: &MistakeCandidate| of_unit.as_ref().filter(|unit| one.changes.len() > unit.changes.len());
        let is_explained = |one: &&MistakeCandidate| {
            let of =
                |one: &MistakeCandidate| if is_of_all(one, &counted) { median(one, &counted) } else { residual(one) };
            let than = with_unit(one)
                .map_or_else(|| if is_of_all(one, &counted) { median(&as_it_is, &counted) } else { before }, residual);
            let explains = is_scale(&one.changes) || of(one) <= EXPLAINED_RATIO * than;
            of(one) <= EXPLAINED * EXPLAINED && explains && self.is_needed(one, &as_it_is, &counted)
        };
        let explained: Vec<&MistakeCandidate> = all.iter().filter(is_explained).collect();
        let by_free_bodies = explained.is_empty();
        let mistake = |one: &MistakeCandidate, left: [f64; 2]| Mistake {
            fault: one.fault.clone(),
            remedy: self.remedy(one),
            left: left.map(f64::sqrt),
            by_free_bodies,
        };
        if by_free_bodies {
            let some = all.iter().filter(|one| of_unit.is_none() && !one.changes.is_empty()).collect();
            let mean = |shares: &[f64]| shares.iter().map(|x| x.min(1.0)).sum::<f64>() / shares.len().max(1) as f64;
            let (as_it_is, tried) = self.identifiable_by_free(some, DISTINGUISHED_BY_FREE);
            return tried.iter().map(|(one, shares)| mistake(one, [mean(&as_it_is), mean(shares)])).collect();
        }
        let mut tried: Vec<&MistakeCandidate> =
            self.identifiable_by_free(explained, f64::INFINITY).1.into_iter().map(|one| one.0).collect();
        tried.sort_by(|a, b| residual(a).total_cmp(&residual(b)));
        let least = tried.first().map_or(f64::INFINITY, |one| residual(one));
        tried.retain(|one| residual(one) <= AS_WELL_RATIO * least + EQUAL_RESIDUAL);
        tried.into_iter().map(|one| mistake(one, [before, residual(one)])).collect()
    }

    /// The option that corrects a mistake. A base that hangs upside down is not a change of columns, so the option then sets the
    /// orientation of the base.
    fn remedy(&self, one: &MistakeCandidate) -> String {
        let of_mount = self.mount.as_ref().filter(|_| one.changes.is_empty()).map(|(_, line)| line.clone());
        let said =
            || self.options.undoing(&one.changes, &self.postures.names, self.turns)?.remedy_added_to(self.options);
        of_mount.or_else(said).unwrap_or_else(|| "[base=3.14159,0,0]".into())
    }

    /// Whether the mistake is necessary. A mistake is not necessary if bodies with free parameters explain the postures equally
    /// well without it.
    ///
    /// Some mistakes need other tests, because free bodies can explain them with unrealistic parameters. Negative or very large
    /// masses explain a change of all torques in the same way. Unrealistic centres of mass explain a joint or a base that is
    /// rotated by a large angle. If only the wrist is loaded, a centimetre of its centre of mass is equivalent to a rotation.
    /// So a large zero error must reduce the residuals of other joints too.
    fn is_needed(&self, one: &MistakeCandidate, as_it_is: &MistakeCandidate, counted: &[usize]) -> bool {
        let mended = counted.iter().filter(|&&j| one.shares[j] < NEEDED_SCALE_RATIO * as_it_is.shares[j]).count();
        match one.changes[..] {
            [Change { of: Zero(_), size }] if size.abs() > FAR_ZERO_RAD && mended >= counted.len().min(2) => {
                return true;
            }
            [Change { of: Zero(_), .. }] => {}
            _ if is_of_all(one, counted) || counted.len() == 1 => return true,
            _ => {}
        }
        let (q, torques) = undone(&one.changes, &self.postures.q, self.torques, self.turns);
        let needed = if is_scale(&one.changes) { NEEDED_SCALE_RATIO } else { NEEDED_RATIO };
        let ratios = ratios(&(self.free)(&q, &torques), &(self.free)(&self.postures.q, self.torques));
        ratios.iter().any(|ratio| *ratio < needed) && ratios.iter().product::<f64>() < 1.0
    }

    /// Fits bodies with free parameters. Returns the squared residuals of the unchanged postures, and the possible mistakes that
    /// explain the postures nearly as well as the best one, sorted by their residuals. `most`: upper limit of the ratio of the
    /// residuals with and without the correction, multiplied over the joints.
    fn identifiable_by_free<'b>(
        &self,
        all: Vec<&'b MistakeCandidate>,
        most: f64,
    ) -> (Vec<f64>, Vec<(&'b MistakeCandidate, Vec<f64>)>) {
        let as_it_is = (self.free)(&self.postures.q, self.torques);
        let ratio = |one: &'b MistakeCandidate| {
            let (q, torques) = undone(&one.changes, &self.postures.q, self.torques, self.turns);
            let shares = (self.free)(&q, &torques);
            (ratios(&shares, &as_it_is).iter().product::<f64>(), one, shares)
        };
        let mut tried: Vec<(f64, &MistakeCandidate, Vec<f64>)> =
            all.into_iter().map(ratio).filter(|one| one.0 < most).collect();
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = tried.first().map_or(f64::INFINITY, |one| one.0);
        tried.retain(|one| one.0 <= least / DISTINGUISHED_BY_FREE);
        (as_it_is, tried.into_iter().map(|(_, one, shares)| (one, shares)).collect())
    }

    /// If the torques have another unit than the nominal torques: the changes that correct the unit, and the ratio of the
    /// units. Otherwise `None`.
    fn unit(&self) -> Option<(Vec<Change>, f64)> {
        let scale = self.common_scale();
        let power = 10f64.powf(scale.log10().round());
        let scale = if NOMINAL_JOINT_SCALES.contains(&(scale / power)) { power } else { scale };
        let changes = (0..self.torques.len()).map(|k| Change { of: Scale(k), size: scale - 1.0 }).collect();
        (!NOMINAL_SCALES.contains(&scale)).then_some((changes, scale))
    }

    /// All possible mistakes, each with the changes that correct it and the residuals after the correction. `unit`: changes and
    /// ratio of a wrong unit, which then is a part of each candidate.
    fn candidates(&self, unit: Option<&(Vec<Change>, f64)>) -> Vec<MistakeCandidate> {
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
        // The unit of a joint's torque is visible only if gravity loads the joint enough. If gravity loads only one joint
        // enough, the error may also be the scale of this joint alone.
        let counted: Vec<usize> = (0..n).filter(|k| self.slope(*k) > 0.0).collect();
        if let ([k], Some(_)) = (&counted[..], unit) {
            let size = self.slope(*k) - 1.0;
            let fault = Scale(*k).statement(&format!("{:.0} %", 100.0 * size), &[&self.postures.coordinates[*k]]);
            all.push(self.candidate(vec![Change { of: Scale(*k), size }], fault, &self.gravity));
        }
        if unit.is_none() {
            // If the base orientation is estimated elsewhere (`mount` is `None`), small zero errors are estimated there,
            // together with this orientation. Then only large zero errors are tried here.
            let is_meant = |one: &MistakeCandidate| self.mount.is_some() || one.changes[0].size.abs() > FAR_ZERO_RAD;
            let zeros = (0..n).filter(|k| self.turns[*k]).filter_map(|k| self.zero(k));
            all.extend(zeros.filter(is_meant));
        }
        if let (None, Some((gravity, _))) = (unit, &self.mount) {
            all.push(self.candidate(
                Vec::new(),
                "the base is mounted otherwise than in the description".into(),
                gravity,
            ));
        }
        all
    }

    /// Adds the possible mistakes that concern one joint or two joints. `scale`: common scale of all torques.
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

    /// The zero error of joint k that reduces the residual most. `None` if no zero error reduces it enough.
    fn zero(&self, k: usize) -> Option<MistakeCandidate> {
        let residual = |size: f64| {
            let (q, torques) = undone(&[Change { of: Zero(k), size }], &self.postures.q, self.torques, self.turns);
            self.shares(&q, &torques, &self.gravity).iter().sum::<f64>()
        };
        let size = turned_joint(&residual)?;
        let off = format!("{:.0} degrees", -size.to_degrees());
        let fault = Zero(k).statement(&off, &[&self.postures.coordinates[k]]);
        Some(self.candidate(vec![Change { of: Zero(k), size }], fault, &self.gravity))
    }

    fn candidate(&self, changes: Vec<Change>, fault: String, gravity: &Vector3<f64>) -> MistakeCandidate {
        let (q, torques) = undone(&changes, &self.postures.q, self.torques, self.turns);
        let shares = self.shares(&q, &torques, gravity);
        MistakeCandidate { changes, fault, shares }
    }

    /// The ratio of measured to nominal torque: the median over the joints for which the ratio can be determined.
    fn common_scale(&self) -> f64 {
        let mut sizes: Vec<f64> = (0..self.torques.len()).map(|k| self.slope(k).abs()).filter(|s| *s > 0.0).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.get(sizes.len() / 2).copied().unwrap_or(1.0)
    }

    /// The ratio of measured to nominal torque of joint k; 0 if the nominal bodies explain less than half of its squared torque.
    fn slope(&self, k: usize) -> f64 {
        let (described, measured) = (&self.at(&self.postures.q, &self.gravity)[k], centred(&self.torques[k]));
        let (square, both) = (described.norm_squared(), described.dot(&measured));
        let is_told = both * both > 0.5 * square * measured.norm_squared();
        if is_told { both / square } else { 0.0 }
    }

    /// The nominal torques at these positions, with their means removed, one vector per joint.
    fn at(&self, postures: &[Vec<f64>], gravity: &Vector3<f64>) -> Vec<DVector<f64>> {
        let rows: Vec<Vec<f64>> = postures.iter().map(|q| (self.described)(q, gravity)).collect();
        let joint = |j: usize| centred(&DVector::from_iterator(rows.len(), rows.iter().map(|row| row[j])));
        (0..self.torques.len()).map(joint).collect()
    }

    /// For each joint, the squared residual of its torque relative to the squared torque. The means are removed, and the nominal
    /// torque is scaled by the best factor from 0.5 to 2.
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

/// Positions and torques after the changes, which correct a mistake.
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

/// Whether the mistake is a wrong scale of one joint. The residual is computed with a free scale from 0.5 to 2, so such a mistake
/// changes the residual little.
fn is_scale(changes: &[Change]) -> bool {
    matches!(changes, [Change { of: Scale(_), .. }])
}

/// For each joint, the ratio of the residual with the changes to the residual without the changes. Joints whose ratio is not
/// finite and positive are left out.
fn ratios(with: &[f64], without: &[f64]) -> Vec<f64> {
    with.iter().zip(without).map(|(a, b)| a / b).filter(|x| x.is_finite() && *x > 0.0).collect()
}

/// Whether a mistake concerns all joints that are considered.
fn is_of_all(one: &MistakeCandidate, counted: &[usize]) -> bool {
    let of = |change: &Change, j: usize| matches!(change.of, TorqueSign(k) | Scale(k) if k == j);
    one.changes.is_empty() || counted.iter().all(|&j| one.changes.iter().any(|change| of(change, j)))
}

/// The median of the squared relative residuals over the joints. This median is used for a mistake of all joints, so that one
/// joint with wrong nominal bodies does not determine the result.
fn median(one: &MistakeCandidate, counted: &[usize]) -> f64 {
    let mut shares: Vec<f64> = counted.iter().map(|&j| one.shares[j]).collect();
    shares.sort_by(f64::total_cmp);
    shares.get(shares.len().saturating_sub(1) / 2).copied().unwrap_or(1.0)
}

fn centred(x: &DVector<f64>) -> DVector<f64> {
    x.add_scalar(-x.mean())
}
