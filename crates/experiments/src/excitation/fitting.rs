//! Scales a motion from a search down until all its limits are proved.
//!
//! A search checks limits only at its samples. If the motion exceeds a limit between them, its swing (deviation from the centre)
//! is divided by the excess, and the limits are proved again. Distances of bodies grow when the swing shrinks, if they are
//! sufficient at the centre.

use numerics::interruption::Interruption;

use crate::excitation::gap_proof::{Surroundings, prove_gaps};
use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::motion::{Motion, scaled};
use crate::excitation::proof::{CertificateRow, LimitProof, NominalTorque, prove_motion, prove_torque};
use crate::excitation::sampled_drives::sampled_excess;
use crate::excitation::trajectory::Trajectory;

/// Greatest number of rounds; each round proves the limits and scales the motion down if a proof fails.
const MAX_PROOF_ROUNDS: usize = 16;
/// Greatest factor by which a round scales the swing (deviation from the centre) if a torque or power limit is not proved.
const MAX_TORQUE_SCALE: f64 = 0.996;
/// Factor by which a round scales the swing (deviation from the centre) if a distance of bodies is not proved.
const DISTANCE_SCALE: f64 = 0.97;
/// Least factor by which one round scales the swing (deviation from the centre), so that the motion does not shrink too far.
const MIN_SCALE: f64 = 0.5;
/// Relative margin to a kinematic limit of a joint after scaling, so that the next proof succeeds.
const JOINT_LIMIT_MARGIN: f64 = 1e-6;

/// The limits that a motion must keep, and the data for their proof.
#[derive(Clone, Copy)]
pub struct Obligations<'a> {
    /// Kinematic and drive limits, one per coordinate.
    pub limits: &'a [CoordinateLimits],
    /// Names of the coordinates.
    pub names: &'a [String],
    /// The nominal torques. `None`: the description does not determine them, so torques are not checked.
    pub torque: Option<&'a NominalTorque<'a>>,
    /// The distances of bodies. `None`: the description has no bodies, so distances are not checked.
    pub surroundings: Option<&'a dyn Surroundings>,
}

impl Obligations<'_> {
    /// Proves every limit along a trajectory and gives the rows of its certificate.
    pub fn certificate(&self, course: &dyn Trajectory) -> Vec<CertificateRow> {
        let mut rows = prove_motion(course, self.limits, self.names);
        rows.extend(self.surroundings.into_iter().flat_map(|s| prove_gaps(course, s)));
        rows.extend(self.torque.into_iter().flat_map(|t| prove_torque(course, self.limits, self.names, t)));
        rows
    }
}

fn are_proven(rows: &[CertificateRow]) -> bool {
    rows.iter().all(|r| r.kept == LimitProof::Proven)
}

/// A motion that was scaled down until its limits were proved, or for the greatest number of rounds.
pub struct Fitted {
    /// The scaled motion.
    pub motion: Motion,
    /// Every limit of `motion` with its proof.
    pub certificate: Vec<CertificateRow>,
    /// The greatest ratio of a torque or power to its limit, before the first scaling because of torques. It is taken from
    /// sampled instants or from an unsuccessful proof. 1 if no such scaling was needed.
    pub beyond: f64,
}

/// Scales a motion down until its limits are proved, or for at most `MAX_PROOF_ROUNDS` rounds.
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
            shrink(&mut motion, DISTANCE_SCALE);
            continue;
        }
        let torque = obligations.torque;
        // An excess at sampled instants is found without an expensive proof.
        let sampled = torque.map_or(0.0, |t| sampled_excess(&motion, obligations.limits, t));
        if sampled > 1.0 {
            first_beyond.get_or_insert(sampled);
            shrink(&mut motion, sampled.sqrt().recip().clamp(MIN_SCALE, MAX_TORQUE_SCALE));
            continue;
        }
        let torques = torque.map_or(vec![], |t| prove_torque(&motion, obligations.limits, obligations.names, t));
        if are_proven(&torques) {
            let certificate = [rows, gaps, torques].concat();
            return Fitted { motion, certificate, beyond: first_beyond.unwrap_or(1.0) };
        }
        // Most of the excess is from accelerations and squared velocities, which grow with the square of the scale; gravity
        // torques hardly change. Hence the square root.
        let excess = torques.iter().map(|r| r.nowhere_beyond / r.bound).fold(1.0, f64::max);
        first_beyond.get_or_insert(excess);
        shrink(&mut motion, excess.sqrt().recip().clamp(MIN_SCALE, MAX_TORQUE_SCALE));
    }
    let certificate = obligations.certificate(&motion);
    Fitted { motion, certificate, beyond: first_beyond.unwrap_or(1.0) }
}

fn shrink(motion: &mut Motion, factor: f64) {
    motion.joints.iter_mut().for_each(|joint| *joint = scaled(joint, factor, joint[0]));
}

/// Scales the swing (deviation from the centre) of each joint down until the joint keeps the kinematic limits that are not proved
/// in the certificate `rows`.
fn within_joint_limits(motion: &mut Motion, limits: &[CoordinateLimits], rows: &[CertificateRow]) {
    let per_joint = LimitKind::KINEMATIC.len();
    for ((joint, limits), rows) in motion.joints.iter_mut().zip(limits).zip(rows.chunks_exact(per_joint)) {
        let (low, high) = limits.position;
        let middle = 0.5 * (low + high);
        for row in rows.iter().filter(|r| r.kept != LimitProof::Proven) {
            let shrink = |bound: f64, beyond: f64| (bound / beyond).clamp(MIN_SCALE, 1.0) * (1.0 - JOINT_LIMIT_MARGIN);
            *joint = match row.limit {
                // For a position limit, the centre also moves towards the middle of the limits.
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
    use crate::excitation::motion::MotionShape;
    use crate::excitation::proof::NominalFriction;
    use crate::excitation::proof::tests::Spring;
    use crate::excitation::search::tests::pendulum_limits;

    #[test]
    fn what_is_missing_is_scaled_away() {
        let (limits, names) = ([pendulum_limits()], ["q1".to_string()]);
        let shape = MotionShape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 3 });
        let joints = vec![vec![0.2, 1.0, 0.3, 0.8, -0.6, 0.4, 0.2]];
        let motion = Motion { rate: 100.0, repetitions: 1, shape, joints };
        let alone = Obligations { limits: &limits, names: &names, torque: None, surroundings: None };
        assert!(alone.certificate(&motion).iter().any(|r| r.kept == LimitProof::Violated));
        let Fitted { motion: free, certificate: rows, .. } = fitted(motion.clone(), &alone);
        assert!(rows.iter().all(|r| r.kept == LimitProof::Proven), "{rows:?}");
        assert!(rows.iter().any(|r| r.room() < 1e-4 * r.bound.abs()) && free.joints[0][1] > 0.5);

        // A wall just below the highest point of this motion makes another scaling necessary.
        let height = |i: u32| free.at(free.duration() * f64::from(i) / 2000.0)[0][0].sin();
        let highest = (0..=2000).map(height).fold(f64::NEG_INFINITY, f64::max);
        let rod = Rod::new(highest - 0.01);
        let with_rod = Obligations { surroundings: Some(&rod), ..alone };
        let Fitted { motion: held, certificate: rows, .. } = fitted(motion, &with_rod);
        assert!(rows.iter().all(|r| r.kept == LimitProof::Proven) && rows.len() == 5, "{rows:?}");
        assert!(held.joints[0][1] < free.joints[0][1] && held.joints[0][1] > 0.3);

        // If the motion violates a distance at its centre, scaling cannot help: the motion stays unproven, and its certificate
        // says so.
        let rod = Rod::new(0.1);
        let with_rod = Obligations { surroundings: Some(&rod), ..alone };
        let Fitted { motion: held, certificate: rows, .. } = fitted(held, &with_rod);
        assert_eq!(rows, with_rod.certificate(&held));
        assert!(rows.iter().any(|r| r.limit == LimitKind::Region && r.kept == LimitProof::Violated));
    }

    #[test]
    fn torques_far_beyond_their_limit_are_scaled_away() {
        let names = ["q1".to_string()];
        let shape = MotionShape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 3 });
        let motion =
            Motion { rate: 100.0, repetitions: 1, shape, joints: vec![vec![0.0, 0.3, 0.1, 0.3, -0.2, 0.2, 0.1]] };
        let friction = vec![NominalFriction::default()];
        let described = NominalTorque { torque: &Spring, friction, share: 1.0, loaded: None };
        let with = |effort: f64| [CoordinateLimits { effort: Some(effort), ..pendulum_limits() }];
        let reached = prove_torque(&motion, &with(1e3), &names, &described)[0].value.abs();
        let limits = with(reached / 1.5);
        let alone = Obligations { limits: &limits, names: &names, torque: Some(&described), surroundings: None };
        let Fitted { certificate: rows, beyond, .. } = fitted(motion, &alone);
        assert!((beyond - 1.5).abs() < 0.02, "{beyond}");
        assert!(rows.iter().all(|r| r.kept == LimitProof::Proven), "{rows:?}");
        let effort = rows.iter().find(|r| r.limit == LimitKind::Effort).unwrap();
        assert!(effort.value.abs() > 0.95 * effort.bound.abs(), "{effort}");
    }
}
