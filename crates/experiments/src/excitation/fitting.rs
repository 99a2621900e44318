//! A motion that a search has found, made to keep its limits for certain.
//!
//! A search looks at limits at its samples only. A motion that exceeds one in between is made smaller here about its
//! centre, by what is missing, and proved again. About a centre that keeps its distances a smaller motion keeps more of
//! them.

use numerics::interruption::Interruption;

use crate::excitation::course::Course;
use crate::excitation::gap_proof::{Surroundings, prove_gaps};
use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::motion::{Motion, scaled};
use crate::excitation::proof::{CertificateRow, DescribedTorque, Kept, prove_motion, prove_torque};
use crate::excitation::sampled_drives::sampled_excess;

/// Rounds before a proof is given up.
const MAX_PROOF_ROUNDS: usize = 16;
/// Largest share of the swing that a round leaves where a torque is not proved.
const MAX_SWING_KEPT_FOR_TORQUE: f64 = 0.996;
/// Share of the swing that a round leaves where a distance is not proved.
const SWING_KEPT_FOR_DISTANCE: f64 = 0.97;

/// What a motion has to keep.
#[derive(Clone, Copy)]
pub struct Obligations<'a> {
    /// One per coordinate.
    pub limits: &'a [CoordinateLimits],
    /// Names of the coordinates.
    pub names: &'a [String],
    /// Torques, where the description tells them.
    pub torque: Option<&'a DescribedTorque<'a>>,
    /// Distances, where the description has bodies.
    pub surroundings: Option<&'a dyn Surroundings>,
}

impl Obligations<'_> {
    /// The certificate of a motion: every limit with what proves it.
    pub fn certificate(&self, course: &dyn Course) -> Vec<CertificateRow> {
        let mut rows = prove_motion(course, self.limits, self.names);
        rows.extend(self.surroundings.into_iter().flat_map(|s| prove_gaps(course, s)));
        rows.extend(self.torque.into_iter().flat_map(|t| prove_torque(course, self.limits, self.names, t)));
        rows
    }
}

fn are_proven(rows: &[CertificateRow]) -> bool {
    rows.iter().all(|r| r.kept == Kept::Proven)
}

/// A motion that was made smaller until its limits were proved to be kept, or the rounds were over.
pub struct Fitted {
    /// The motion.
    pub motion: Motion,
    /// Every limit with what proves it.
    pub certificate: Vec<CertificateRow>,
    /// The greatest torque or power over its limit before the motion was made smaller for it, as instants showed it or a proof
    /// was short of it; 1 where all were proven at once.
    pub beyond: f64,
}

/// The motion, made smaller until its limits are proved to be kept or the rounds are over.
pub fn fitted(motion: Motion, obligations: &Obligations) -> Fitted {
    let (mut motion, mut first_beyond) = (motion, None);
    for _ in 0..MAX_PROOF_ROUNDS {
        if Interruption::check().is_err() {
            break;
        }
        let rows = prove_motion(&motion, obligations.limits, obligations.names);
        if !are_proven(&rows) {
            within_joint_limits(&mut motion, obligations.limits, &rows);
            continue;
        }
        let gaps = obligations.surroundings.map_or(vec![], |s| prove_gaps(&motion, s));
        if !are_proven(&gaps) {
            shrink(&mut motion, SWING_KEPT_FOR_DISTANCE);
            continue;
        }
        let torque = obligations.torque;
        // What instants show already needs no proof.
        let sampled = torque.map_or(0.0, |t| sampled_excess(&motion, obligations.limits, t));
        if sampled > 1.0 {
            first_beyond.get_or_insert(sampled);
            shrink(&mut motion, sampled.sqrt().recip().clamp(0.5, MAX_SWING_KEPT_FOR_TORQUE));
            continue;
        }
        let torques = torque.map_or(vec![], |t| prove_torque(&motion, obligations.limits, obligations.names, t));
        if are_proven(&torques) {
            let certificate = [rows, gaps, torques].concat();
            return Fitted { motion, certificate, beyond: first_beyond.unwrap_or(1.0) };
        }
        // Torques of accelerations and squared velocities; those of gravity hardly change.
        let excess = torques.iter().map(|r| r.nowhere_beyond / r.bound).fold(1.0, f64::max);
        first_beyond.get_or_insert(excess);
        shrink(&mut motion, excess.sqrt().recip().clamp(0.5, MAX_SWING_KEPT_FOR_TORQUE));
    }
    let certificate = obligations.certificate(&motion);
    Fitted { motion, certificate, beyond: first_beyond.unwrap_or(1.0) }
}

fn shrink(motion: &mut Motion, factor: f64) {
    motion.joints.iter_mut().for_each(|joint| *joint = scaled(joint, factor, joint[0]));
}

/// Makes the swing of each joint smaller by what is missing in its rows.
fn within_joint_limits(motion: &mut Motion, limits: &[CoordinateLimits], rows: &[CertificateRow]) {
    let per_joint = LimitKind::KINEMATIC.len();
    for ((joint, limits), rows) in motion.joints.iter_mut().zip(limits).zip(rows.chunks_exact(per_joint)) {
        let (low, high) = limits.position;
        let middle = 0.5 * (low + high);
        for row in rows.iter().filter(|r| r.kept != Kept::Proven) {
            let shrink = |bound: f64, beyond: f64| (bound / beyond).clamp(0.5, 1.0) * (1.0 - 1e-6);
            *joint = match row.limit {
                // The centre moves towards the middle of the room too.
                LimitKind::Position => {
                    let factor = shrink(row.bound - middle, row.nowhere_beyond - middle);
                    scaled(joint, factor, middle + factor * (joint[0] - middle))
                }
                _ => scaled(joint, shrink(row.bound, row.nowhere_beyond), joint[0]),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::gap_proof::tests::Rod;
    use crate::excitation::motion::Shape;
    use crate::excitation::proof::DescribedFriction;
    use crate::excitation::proof::tests::Spring;
    use crate::excitation::search::tests::pendulum_limits;

    #[test]
    fn what_is_missing_is_scaled_away() {
        let (limits, names) = ([pendulum_limits()], ["q1".to_string()]);
        let shape = Shape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 3 });
        let joints = vec![vec![0.2, 1.0, 0.3, 0.8, -0.6, 0.4, 0.2]];
        let motion = Motion { rate: 100.0, repetitions: 1, shape, joints };
        let alone = Obligations { limits: &limits, names: &names, torque: None, surroundings: None };
        assert!(alone.certificate(&motion).iter().any(|r| r.kept == Kept::Violated));
        let Fitted { motion: free, certificate: rows, .. } = fitted(motion.clone(), &alone);
        assert!(rows.iter().all(|r| r.kept == Kept::Proven), "{rows:?}");
        assert!(rows.iter().any(|r| r.room() < 1e-4 * r.bound.abs()) && free.joints[0][1] > 0.5);

        // A wall a little before where that motion goes makes it smaller again.
        let height = |i: u32| free.at(free.duration() * f64::from(i) / 2000.0)[0][0].sin();
        let highest = (0..=2000).map(height).fold(f64::NEG_INFINITY, f64::max);
        let rod = Rod::new(highest - 0.01);
        let with_rod = Obligations { surroundings: Some(&rod), ..alone };
        let Fitted { motion: held, certificate: rows, .. } = fitted(motion, &with_rod);
        assert!(rows.iter().all(|r| r.kept == Kept::Proven) && rows.len() == 5, "{rows:?}");
        assert!(held.joints[0][1] < free.joints[0][1] && held.joints[0][1] > 0.3);

        // A wall that the centre is beyond leaves the motion unproven, and says so.
        let rod = Rod::new(0.1);
        let with_rod = Obligations { surroundings: Some(&rod), ..alone };
        let Fitted { motion: held, certificate: rows, .. } = fitted(held, &with_rod);
        assert_eq!(rows, with_rod.certificate(&held));
        assert!(rows.iter().any(|r| r.limit == LimitKind::Region && r.kept == Kept::Violated));
    }

    #[test]
    fn torques_far_beyond_their_limit_are_scaled_away() {
        let names = ["q1".to_string()];
        let shape = Shape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 3 });
        let motion =
            Motion { rate: 100.0, repetitions: 1, shape, joints: vec![vec![0.0, 0.3, 0.1, 0.3, -0.2, 0.2, 0.1]] };
        let friction = vec![DescribedFriction::default()];
        let described = DescribedTorque { torque: &Spring, friction, share: 1.0, loaded: None };
        let with = |effort: f64| [CoordinateLimits { effort: Some(effort), ..pendulum_limits() }];
        let reached = prove_torque(&motion, &with(1e3), &names, &described)[0].value.abs();
        let limits = with(reached / 1.5);
        let alone = Obligations { limits: &limits, names: &names, torque: Some(&described), surroundings: None };
        let Fitted { certificate: rows, beyond, .. } = fitted(motion, &alone);
        assert!((beyond - 1.5).abs() < 0.02, "{beyond}");
        assert!(rows.iter().all(|r| r.kept == Kept::Proven), "{rows:?}");
        let effort = rows.iter().find(|r| r.limit == LimitKind::Effort).unwrap();
        assert!(effort.value.abs() > 0.95 * effort.bound.abs(), "{effort}");
    }
}
