//! Proves that a motion keeps its limits, also between the samples. If it violates a limit, the time of the violation is found.
//!
//! For each segment of the motion, subdivision of an enclosure ([`numerics::range`]) finds the range of each limited quantity.
//! Position to jerk use the enclosures of the motion ([`crate::excitation::enclosure`]). The torque uses the second-order
//! enclosure of the torque function along the motion ([`numerics::jet`]), with the nominal friction: tau = Y X + FV dq + OFF, and
//! FS in both directions (Y: regressor, X: its parameters, FV: viscous friction, OFF: offset, FS: dry friction). The power of a
//! drive, tau dq + FS |dq|, uses the same enclosure. The proof follows from the motion, the limits and the description alone.
//!
//! Not here: distances of bodies ([`crate::excitation::gap_proof`]); torques that the description does not determine.

use std::fmt;

use numerics::interruption::Interruption;
use numerics::interval::Interval;
use numerics::range::{Enclosed, Extreme, Range, RangeGoal, Subdivision, ranges};
use serde::{Deserialize, Serialize};

use crate::excitation::enclosed_drives::{DriveEnclosure, drives_on, dry, limited_drives};
use crate::excitation::limits::{CoordinateLimits, LimitKind};
pub use crate::excitation::nominal_torque::{EnclosedTorque, IdentifiedTorque, NominalFriction, NominalTorque};
use crate::excitation::trajectory::{Trajectory, TrajectorySegment};

/// The result of the proof of one limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitProof {
    /// It is proved that the motion keeps the limit at all times.
    Proven,
    /// The motion violates the limit at the time in the certificate row.
    Violated,
    /// Open: no violation was found, but the proof did not succeed.
    Open,
}

/// A row of a certificate: one limit of a coordinate or of bodies, with the result of its proof.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertificateRow {
    /// The kind of limit.
    pub limit: LimitKind,
    /// Name of the coordinate, or names of the bodies: `forearm and base`, `forearm at the floor`.
    pub subject: String,
    /// Time after the start of the motion at which `value` is reached, s. For a repeated period it is the time in the first
    /// repetition.
    pub time_s: f64,
    /// The value of the limited quantity nearest to its bound, or farthest beyond it, in the unit of the kind of limit.
    pub value: f64,
    /// The bound of the quantity, in the unit of `value`; for a distance it includes `margin`.
    pub bound: f64,
    /// The part of the bound of a distance that covers errors of joints and bodies, m.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub margin: f64,
    /// Proved bound of the quantity over the whole motion, in the unit of `value`: the quantity is never beyond it.
    pub nowhere_beyond: f64,
    /// Whether the limit is proved, violated, or neither.
    pub kept: LimitProof,
    /// The method of the proof, in words.
    pub how: String,
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

impl CertificateRow {
    /// Distance between the value and its bound; negative if the limit is violated.
    pub fn room(&self) -> f64 {
        let distance = (self.bound - self.value).abs();
        if self.kept == LimitProof::Violated { -distance } else { distance }
    }
}

impl fmt::Display for CertificateRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.in_words(None))
    }
}

/// Tolerance of the proof of a kinematic limit: distance between the proved bound and the reached value, relative to the width of
/// the limits.
pub const KINEMATIC_PROOF_TOLERANCE: f64 = 1e-6;
/// Tolerance of the proof of a torque or power limit: distance between the proved bound and the reached value, relative to the
/// limit. It is larger than the kinematic tolerance, because torque enclosures are wider.
const TORQUE_PROOF_TOLERANCE: f64 = 1e-3;
/// Greatest number of interval evaluations per segment in the proof of the kinematic limits.
const KINEMATIC_ENCLOSURES: usize = 50_000;
/// Greatest number of interval evaluations per segment to find the exact range of torques and powers.
const TORQUE_ENCLOSURES: usize = 20_000;
/// Greatest number of interval evaluations per segment to prove only that torques are within their limits. This proof comes
/// first: with many joints the enclosures are wide, and exact ranges need too many evaluations.
const TORQUE_ENCLOSURES_WITHIN_LIMITS: usize = 100_000;

/// Proves the kinematic limits and gives one certificate row per limit, coordinate by coordinate. An infinite limit has no row.
pub fn prove_motion(course: &dyn Trajectory, limits: &[CoordinateLimits], names: &[String]) -> Vec<CertificateRow> {
    let enclosed = course.enclosed();
    let size = |l: &CoordinateLimits, kind: LimitKind| l.bounds(kind).map_or(1.0, |(low, high)| high - low);
    let sought: Vec<RangeGoal> = limits
        .iter()
        .flat_map(|l| LimitKind::KINEMATIC.map(|kind| RangeGoal::to(KINEMATIC_PROOF_TOLERANCE * size(l, kind))))
        .collect();
    let stretches = over_stretches(course, (KINEMATIC_ENCLOSURES, 0), &sought, |i, part: Interval| {
        let on = |part| enclosed.on(i, part).iter().flat_map(|x| x[..4].to_vec()).collect();
        Enclosed { over: on(part), middle: on(Interval::point(part.middle())) }
    });
    let mut rows = Vec::new();
    for (k, (limits, name)) in limits.iter().zip(names).enumerate() {
        for (d, kind) in LimitKind::KINEMATIC.into_iter().enumerate() {
            let bounds = limits.bounds(kind).filter(|(low, high)| low.is_finite() && high.is_finite());
            let Some(bounds) = bounds else { continue };
            let found = stretches.iter().map(|(stretch, ranges)| (*stretch, ranges[4 * k + d]));
            rows.extend(row(kind, name, bounds, found, |stretch| stretch.method.into()));
        }
    }
    rows
}

/// The range of a quantity on a segment that was not evaluated: nothing is reached and nothing is proved.
const UNKNOWN: Range = Range {
    least: Extreme { reached: f64::INFINITY, time: 0.0, proved: f64::NEG_INFINITY },
    greatest: Extreme { reached: f64::NEG_INFINITY, time: 0.0, proved: f64::INFINITY },
};

/// Finds the range of each limited quantity on each segment of a trajectory. `enclose` encloses the quantities on a time
/// interval. Uses at most `enclosures_within` evaluations to prove the limits alone, then at most `enclosures` for the exact
/// ranges.
fn over_stretches(
    course: &dyn Trajectory,
    (enclosures, enclosures_within): (usize, usize),
    sought: &[RangeGoal],
    enclose: impl Fn(usize, Interval) -> Enclosed + Sync,
) -> Vec<(TrajectorySegment, Vec<Range>)> {
    let one = |(i, stretch): (usize, TrajectorySegment)| {
        if Interruption::check().is_err() {
            return (stretch, vec![UNKNOWN; sought.len()]);
        }
        let subdivision = Subdivision { parts: stretch.parts, enclosures, enclosures_within };
        (stretch, ranges(Interval::new(0.0, stretch.length), subdivision, sought, |part| enclose(i, part)))
    };
    course.stretches().into_iter().enumerate().map(one).collect()
}

/// Proves the limits of torques and powers and gives one certificate row per limit.
///
/// If there is a payload, each row is the worse of two proofs, with and without the payload: torques are linear in the
/// payload's mass, so a smaller mass gives values in between.
pub fn prove_torque(
    course: &dyn Trajectory,
    limits: &[CoordinateLimits],
    names: &[String],
    described: &NominalTorque,
) -> Vec<CertificateRow> {
    let without = prove_torque_of(course, limits, names, described);
    let Some(loaded) = described.with_payload() else { return without };
    let with = prove_torque_of(course, limits, names, &loaded);
    let worse = |(without, with): (CertificateRow, CertificateRow)| {
        let size = |row: &CertificateRow| row.nowhere_beyond.abs();
        let is_worse = rank(&with).cmp(&rank(&without)).then(size(&without).total_cmp(&size(&with))).is_lt();
        match is_worse {
            true => CertificateRow { how: format!("{}, with the payload", with.how), ..with },
            false => CertificateRow { how: format!("{}, without the payload", without.how), ..without },
        }
    };
    without.into_iter().zip(with).map(worse).collect()
}

/// Rank of a certificate row, the worst first: violated, unproven, proven.
fn rank(row: &CertificateRow) -> u8 {
    match row.kept {
        LimitProof::Violated => 0,
        LimitProof::Open => 1,
        LimitProof::Proven => 2,
    }
}

fn prove_torque_of(
    course: &dyn Trajectory,
    limits: &[CoordinateLimits],
    names: &[String],
    described: &NominalTorque,
) -> Vec<CertificateRow> {
    let enclosed = course.enclosed();
    let limited = limited_drives(limits, described);
    if limited.is_empty() {
        return vec![];
    }
    // The subdivision of intervals ends at this tolerance, or earlier if the bound is proved.
    let sought = |&(.., bound): &(usize, LimitKind, f64)| RangeGoal {
        tolerance: TORQUE_PROOF_TOLERANCE * bound.abs(),
        enough: bound,
    };
    let sought: Vec<RangeGoal> = limited.iter().map(sought).collect();
    let enclosures = (TORQUE_ENCLOSURES, TORQUE_ENCLOSURES_WITHIN_LIMITS);
    let stretches = over_stretches(course, enclosures, &sought, |i, part| {
        let (over, middle) = drives_on(enclosed.as_ref(), i, part, described);
        let of = |all: DriveEnclosure| -> Vec<Interval> {
            let one = |&(k, kind, _): &(usize, LimitKind, f64)| match kind {
                LimitKind::Power => all[k].1,
                _ => all[k].0,
            };
            limited.iter().map(one).collect()
        };
        Enclosed { over: of(over), middle: of(middle) }
    });
    // The limits of a drive are symmetric about zero: -bound to bound.
    let one = |(i, &(k, kind, bound)): (usize, &(usize, LimitKind, f64))| {
        let found = stretches.iter().map(|(stretch, ranges)| (*stretch, ranges[i]));
        let how = match kind {
            LimitKind::Power => "Taylor enclosures of the nominal torque times velocity, with dry friction".into(),
            _ => {
                format!("Taylor enclosures of the nominal torque; {} N m of dry friction kept free", dry(described, k))
            }
        };
        row(kind, &names[k], (-bound, bound), found, |_| how.clone())
    };
    limited.iter().enumerate().filter_map(one).collect()
}

/// The certificate row of a limit from the quantity's ranges over the segments: the worse of the lower and the upper end. `None`
/// if there are no segments.
fn row(
    limit: LimitKind,
    subject: &str,
    (low, high): (f64, f64),
    found: impl Iterator<Item = (TrajectorySegment, Range)>,
    how: impl Fn(TrajectorySegment) -> String,
) -> Option<CertificateRow> {
    let rows = found.flat_map(|(stretch, range)| {
        let ends = [(low, range.least, -1.0), (high, range.greatest, 1.0)];
        let how = how(stretch);
        ends.map(|(bound, end, sign)| CertificateRow {
            limit,
            subject: subject.to_string(),
            time_s: stretch.start + end.time,
            value: end.reached,
            bound,
            margin: 0.0,
            nowhere_beyond: end.proved,
            kept: match (sign * (end.proved - bound) <= 0.0, sign * (end.reached - bound) > 0.0) {
                (true, _) => LimitProof::Proven,
                (false, true) => LimitProof::Violated,
                (false, false) => LimitProof::Open,
            },
            how: how.clone(),
        })
    });
    // The worst row: by the result of the proof, then by the distance to the bound; the first one if rows are equal.
    rows.min_by(|a, b| rank(a).cmp(&rank(b)).then(a.room().total_cmp(&b.room())))
}

#[cfg(test)]
pub(crate) mod tests {
    use numerics::jet::Jet;

    use super::*;
    use crate::excitation::motion::Motion;
    use crate::excitation::motion::tests::motions;
    use crate::excitation::search;

    /// Least and greatest position, velocity, acceleration and jerk of each coordinate, from dense samples.
    fn sampled(motion: &Motion) -> Vec<[(f64, f64); 4]> {
        let mut found = vec![[(f64::INFINITY, f64::NEG_INFINITY); 4]; motion.joints.len()];
        for i in 0..=200_000 {
            for (found, x) in found.iter_mut().zip(motion.at(motion.duration() * f64::from(i) / 200_000.0)) {
                for d in 0..4 {
                    found[d] = (found[d].0.min(x[d]), found[d].1.max(x[d]));
                }
            }
        }
        found
    }

    fn limits(found: &[[(f64, f64); 4]], factor: f64) -> Vec<CoordinateLimits> {
        let size = |x: (f64, f64)| factor * x.1.max(-x.0);
        let position = |x: (f64, f64)| (x.0 - (factor - 1.0), x.1 + (factor - 1.0));
        found.iter().map(|x| search::tests::limits(position(x[0]), [x[1], x[2], x[3]].map(size))).collect()
    }

    #[test]
    fn proofs_are_sharp() {
        let names = ["q1".to_string(), "q2".to_string()];
        for motion in motions() {
            let found = sampled(&motion);
            // Samples 5e-5 s apart miss a peak by less than 1e-6 of its value; near the jumps of the jerk they miss it by 1e-4.
            let rows = prove_motion(&motion, &limits(&found, 1.001), &names);
            assert_eq!(rows.len(), 8);
            assert!(rows.iter().all(|r| r.kept == LimitProof::Proven && r.room() > 0.0), "{rows:?}");
            let rows = prove_motion(&motion, &limits(&found, 0.999), &names);
            for row in rows {
                assert!(row.kept == LimitProof::Violated && row.room() < 0.0, "{row:?}");
                let joint = names.iter().position(|n| *n == row.subject).unwrap();
                let d = LimitKind::KINEMATIC.iter().position(|k| *k == row.limit).unwrap();
                let near = |t: f64| (motion.at(t)[joint][d] - row.value).abs() < 1e-6 * (1.0 + row.value.abs());
                // The jerk jumps between segments, so there the value belongs to one of the two neighbouring segments.
                assert!(near(row.time_s) || near(row.time_s - 1e-9) || near(row.time_s + 1e-9), "{row:?}");
            }
        }
    }

    /// Torque of an inertia of 2 kg m^2 on a spring of 3 N m/rad, for each coordinate.
    pub(crate) struct Spring;

    impl EnclosedTorque for Spring {
        fn torque(&self, q: &[Jet], _: &[Jet], ddq: &[Jet]) -> Vec<Jet> {
            let constant = |x: f64| Jet::constant(Interval::point(x));
            q.iter().zip(ddq).map(|(q, ddq)| *ddq * constant(2.0) + *q * constant(3.0)).collect()
        }
    }

    #[test]
    fn proofs_of_torque_and_power_are_sharp() {
        let names = ["q1".to_string(), "q2".to_string()];
        let friction = NominalFriction { viscous: 0.7, coulomb: 0.4, offset: -0.2 };
        let described = NominalTorque { torque: &Spring, friction: vec![friction; 2], share: 0.8, loaded: None };
        for motion in motions() {
            let drive = |x: [f64; 4]| {
                let tau = 2.0 * x[2] + 3.0 * x[0] + 0.7 * x[1] - 0.2;
                [tau.abs() + 0.4, (tau * x[1] + 0.4 * x[1].abs()).abs()]
            };
            let mut greatest = [[0.0_f64; 2]; 2];
            for i in 0..=100_000 {
                for (greatest, x) in greatest.iter_mut().zip(motion.at(motion.duration() * f64::from(i) / 100_000.0)) {
                    (0..2).for_each(|d| greatest[d] = greatest[d].max(drive(x)[d]));
                }
            }
            // A torque proof stops within a thousandth of the limit, so limits 0.2 % above and below the peak are tested.
            for (factor, kept) in [(1.002, LimitProof::Proven), (0.998, LimitProof::Violated)] {
                let mut limits = limits(&sampled(&motion), 1.0);
                for (limits, [effort, power]) in limits.iter_mut().zip(greatest) {
                    // Only the effort minus the dry friction of 0.4 N m is usable.
                    limits.effort = Some((0.4 + factor * (effort - 0.4)) / 0.8);
                    limits.power = Some(factor * power / 0.8);
                }
                let rows = prove_torque(&motion, &limits, &names, &described);
                assert_eq!(rows.len(), 4);
                for row in rows {
                    assert_eq!(row.kept, kept, "{row:?}");
                    let joint = names.iter().position(|n| *n == row.subject).unwrap();
                    let place = usize::from(row.limit == LimitKind::Power);
                    let there = drive(motion.at(row.time_s)[joint])[place];
                    let free = if place == 0 { 0.4 } else { 0.0 };
                    // Tolerance: the time in the row is rounded, and the values are some hundreds.
                    assert!((row.value.abs() + free - there).abs() < 1e-6 * (1.0 + there), "{row:?} {there}");
                }
            }
        }
    }

    /// The torque of `Spring` with artificially wide enclosures, like the enclosures of a robot with many joints.
    struct WideEnclosure;

    impl EnclosedTorque for WideEnclosure {
        fn torque(&self, q: &[Jet], dq: &[Jet], ddq: &[Jet]) -> Vec<Jet> {
            // The enclosures are made wider in proportion to the width of the interval, so at an instant (width zero) they stay
            // exact. The exact ranges need more than 20 000 enclosures; a proof of loose limits needs less than 100 000.
            let wide = |q: &Jet| Interval::new(-3e8, 3e8) * Interval::point(q.0[0].width());
            let spring = Spring.torque(q, dq, ddq).into_iter().zip(q);
            spring.map(|(Jet([x, dx, ddx]), q)| Jet([x + wide(q), dx + wide(q), ddx + wide(q) * wide(q)])).collect()
        }
    }

    #[test]
    fn what_has_room_needs_no_exact_range() {
        let names = ["q1".to_string(), "q2".to_string()];
        let with = |torque, friction| NominalTorque { torque, friction, share: 1.0, loaded: None };
        let friction = vec![NominalFriction::default(); 2];
        let (sharp, loose) = (with(&Spring, friction.clone()), with(&WideEnclosure, friction));
        let motion = &motions()[0];
        let mut limits = limits(&sampled(motion), 1.0);
        limits.iter_mut().for_each(|l| (l.effort, l.power) = (Some(1e4), None));
        let reached: Vec<f64> = prove_torque(motion, &limits, &names, &sharp).iter().map(|r| r.value.abs()).collect();
        let of = |room: f64| {
            let bounds = reached.iter().map(|reached| Some(reached * room));
            let limits: Vec<_> =
                limits.iter().zip(bounds).map(|(l, effort)| CoordinateLimits { effort, ..l.clone() }).collect();
            prove_torque(motion, &limits, &names, &loose)
        };
        for (row, reached) in of(1.5).iter().zip(&reached) {
            assert_eq!(row.kept, LimitProof::Proven, "{row:?}");
            // The limits are proved, but the exact range is not found.
            assert!(row.nowhere_beyond.abs() > 1.01 * reached, "{row:?} {reached}");
        }
        assert!(of(1.0 + 1e-9).iter().all(|row| row.kept != LimitProof::Proven));
        assert!(of(0.999).iter().all(|row| row.kept == LimitProof::Violated));
    }
}
