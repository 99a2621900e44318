//! Plot data of an exciting motion: coordinates over time with their limits, torques, and the path of the tip.
//!
//! A certificate is the proof that the motion respects its limits. Torques are defined as in the certificate:
//! tau = Y X + FV dq + OFF (FV: viscous friction, OFF: offset). Coulomb friction FS is not included, because it is subtracted from the bounds of
//! the torque. The power of a drive includes Coulomb friction: tau dq + FS |dq|.

use claims::LeftOut;
use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::limits::{CoordinateLimits, LimitKind};
use experiments::excitation::margins::Margins;
use experiments::excitation::motion::Motion;
use experiments::excitation::motion_claims::{LowestPoint, MotionClaims};
use experiments::excitation::proof::{CertificateRow, NominalFriction};
use linear_model::regressor::Regressor;
use robot::{Pose, Robot};

use crate::plot_data::envelope::Envelope;

/// Number of samples per period of the motion: dozens per harmonic.
const SAMPLES_PER_PERIOD: usize = 240;
/// Least number of samples of a motion.
const MIN_SAMPLES_PER_MOTION: usize = 720;

/// Plot data of an exciting motion.
#[derive(Clone, Debug)]
pub struct MotionPlotData {
    /// Lines over time of each joint, one per coordinate.
    pub joints: Vec<JointCourse>,
    /// Times inside the motion at which periods start and end, s.
    pub borders: Vec<f64>,
    /// Path of the tip in the first period and in the blends (start and end of the motion); `None` if positions of links are
    /// unknown.
    pub tip: Option<EndEffectorPath>,
    /// The certificate: for each limit, the largest value of the motion and the proof.
    pub certificate: Vec<CertificateRow>,
    /// Further notes on the motion, in sentences.
    pub notes: Vec<String>,
    /// Properties of the motion that the certificate does not cover.
    pub left_out: Vec<LeftOut>,
    /// Height of the floor, m; `None` if unknown.
    pub floor: Option<f64>,
    /// The lowest point that moving links reach; `None` if unknown.
    pub lowest: Option<LowestPoint>,
    /// Margins of the certificate (limit minus largest value), and stopping distances; `None` if unknown.
    pub margins: Option<Margins>,
    /// Whether the certificate was computed from the motion and the model. If false, the certificate was read from a file.
    pub is_found_anew: bool,
}

/// One coordinate, its limits and its quantities over time.
#[derive(Clone, Debug)]
pub struct JointCourse {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Whether the joint is prismatic; `None` if unknown because there is no model.
    pub is_prismatic: Option<bool>,
    /// The limits that the motion respects.
    pub limits: CoordinateLimits,
    /// Lines over time with their kinds: position, velocity, acceleration, jerk; then torque and power if known.
    pub positions: Vec<(LimitKind, Envelope)>,
}

/// The path of the tip of the robot in the base frame, m.
#[derive(Clone, Debug)]
pub struct EndEffectorPath {
    /// Name of the link or frame.
    pub name: String,
    /// Points in the order of time, m.
    pub points: Vec<[f64; 3]>,
}

/// The model of the robot, for torques and the path of the tip.
#[derive(Clone, Copy)]
pub struct KnownRobot<'a> {
    /// The robot with its links.
    pub robot: &'a Robot,
    /// The base regressor.
    pub regressor: &'a dyn Regressor,
    /// Base parameters; `None` if torques are unknown.
    pub parameters: Option<&'a [f64]>,
    /// Nominal friction, one per coordinate.
    pub friction: &'a [NominalFriction],
}

impl MotionPlotData {
    /// Makes the plot data of an exciting motion that was read from a file, without a model. Certificate and notes are copied
    /// from the file.
    pub fn of_file(artefact: &ExcitingMotion, motion: &Motion) -> MotionPlotData {
        let limits = artefact.joints.iter().map(|j| j.limits.clone()).collect();
        MotionPlotData::new(artefact, motion, limits, None).with_certificate_of(artefact)
    }

    /// Takes over the certificate and notes of an exciting motion read from a file.
    pub fn with_certificate_of(self, artefact: &ExcitingMotion) -> MotionPlotData {
        let claims = artefact.claims();
        let said = artefact.checksum.said().map(str::to_string).into_iter();
        MotionPlotData {
            certificate: artefact.certificate.clone(),
            notes: said.chain(artefact.notes.iter().cloned()).collect(),
            left_out: claims.left_out.to_vec(),
            floor: claims.floor,
            lowest: claims.lowest.cloned(),
            margins: artefact.margins.clone(),
            ..self
        }
    }

    /// The claims of the certificate, with the properties that it does not cover.
    pub fn claims(&self) -> MotionClaims<'_> {
        let (rows, left_out) = (&self.certificate, &self.left_out);
        MotionClaims { rows, left_out, floor: self.floor, lowest: self.lowest.as_ref() }
    }

    /// Makes the plot data of a motion, without certificate and notes. `limits`: one per coordinate; `known`: the robot, or
    /// `None` without a model.
    pub fn new(
        artefact: &ExcitingMotion,
        motion: &Motion,
        limits: Vec<CoordinateLimits>,
        known: Option<KnownRobot>,
    ) -> MotionPlotData {
        let names = artefact.joints.iter().map(|j| j.coordinate.clone());
        let joint = |(k, (coordinate, limits)): (usize, (String, CoordinateLimits))| JointCourse {
            coordinate,
            is_prismatic: known.map(|known| known.regressor.is_prismatic(k)),
            positions: kinds(&limits, known).into_iter().map(|kind| (kind, Envelope::default())).collect(),
            limits,
        };
        let mut joints: Vec<JointCourse> = names.zip(limits).enumerate().map(joint).collect();
        let (blend, period, duration) = (motion.shape.blend(), motion.shape.period(), motion.duration());
        let tip = known.and_then(|known| EndEffector::of(known.robot));
        let mut points = Vec::new();
        let count = (SAMPLES_PER_PERIOD * motion.repetitions).max(MIN_SAMPLES_PER_MOTION);
        for i in 0..count {
            let t = duration * i as f64 / (count - 1) as f64;
            let state = motion.at(t);
            let torques = known.and_then(|known| torques(&known, &state));
            for (k, joint) in joints.iter_mut().enumerate() {
                for (kind, course) in &mut joint.positions {
                    let value = match (*kind, &torques) {
                        (LimitKind::Position, _) => state[k][0],
                        (LimitKind::Velocity, _) => state[k][1],
                        (LimitKind::Acceleration, _) => state[k][2],
                        (LimitKind::Jerk, _) => state[k][3],
                        (LimitKind::Effort, Some(torques)) => torques[k][0],
                        (_, Some(torques)) => torques[k][1],
                        (_, None) => continue,
                    };
                    course.push(t, value);
                }
            }
            // The path of the tip is computed for the blends (start and end) and the first period only, because all other periods
            // repeat it.
            if let Some(tip) = tip.as_ref().filter(|_| t <= blend + period || t >= duration - blend) {
                points.push(tip.place(&state.iter().map(|x| x[0]).collect::<Vec<_>>()));
            }
        }
        let ends = (0..=motion.repetitions).map(|r| blend + r as f64 * period);
        MotionPlotData {
            joints,
            borders: ends.filter(|t| *t > 0.0 && *t < duration).collect(),
            tip: tip.map(|tip| EndEffectorPath { name: tip.name.clone(), points }),
            certificate: vec![],
            notes: vec![],
            left_out: vec![],
            floor: None,
            lowest: None,
            margins: None,
            is_found_anew: known.is_some(),
        }
    }
}

/// The quantities of a coordinate that are drawn. The torque is drawn only if parameters are known. The power is drawn only if
/// it is also limited.
fn kinds(limits: &CoordinateLimits, known: Option<KnownRobot>) -> Vec<LimitKind> {
    let mut kinds = vec![LimitKind::Position, LimitKind::Velocity, LimitKind::Acceleration, LimitKind::Jerk];
    if known.is_some_and(|known| known.parameters.is_some()) {
        kinds.push(LimitKind::Effort);
        kinds.extend(limits.power.map(|_| LimitKind::Power));
    }
    kinds
}

/// For each coordinate, [torque without dry friction, N m (N); power with dry friction, W]. `None` without parameters.
fn torques(known: &KnownRobot, state: &[[f64; 4]]) -> Option<Vec<[f64; 2]>> {
    let parameters = known.parameters?;
    let of = |d: usize| -> Vec<f64> { state.iter().map(|x| x[d]).collect() };
    let mut y = vec![0.0; state.len() * parameters.len()];
    known.regressor.fill(&of(0), &of(1), &of(2), &mut y);
    let one = |(k, row): (usize, &[f64])| {
        let (dq, friction) = (state[k][1], known.friction[k]);
        let rigid: f64 = row.iter().zip(parameters).map(|(y, x)| y * x).sum();
        let torque = rigid + friction.viscous * dq + friction.offset;
        [torque, torque * dq + friction.coulomb.abs() * dq.abs()]
    };
    Some(y.chunks_exact(parameters.len().max(1)).enumerate().map(one).collect())
}

/// The tip of the robot: a frame at the end of the longest chain of joints.
struct EndEffector<'a> {
    robot: &'a Robot,
    link: usize,
    place: Pose,
    name: String,
}

impl<'a> EndEffector<'a> {
    /// Finds the tip: the last frame that is fixed to the link at the end of the longest chain, or the frame of that link. `None`
    /// if the robot has passive joints.
    fn of(robot: &'a Robot) -> Option<EndEffector<'a>> {
        if !robot.passive.is_empty() {
            return None;
        }
        let mut depth: Vec<usize> = Vec::with_capacity(robot.links.len());
        for link in &robot.links {
            depth.push(link.antecedent.map_or(1, |a| depth[a.0] + 1));
        }
        let link = (0..depth.len()).max_by_key(|&j| depth[j])?;
        let own = &robot.links[link];
        let (name, place) = own.frames.last().cloned().unwrap_or((own.name.clone(), Pose::IDENTITY));
        Some(EndEffector { robot, link, place, name })
    }

    /// The position of the tip in the base frame at joint positions q, m.
    fn place(&self, q: &[f64]) -> [f64; 3] {
        self.robot.link_poses(q)[self.link].compose(&self.place).position
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use experiments::excitation::fourier_series::FourierSeries;
    use experiments::excitation::motion::MotionShape;
    use experiments::excitation::quintic_spline::QuinticSpline;
    use random::Random;

    /// One motion of each shape, with one coordinate.
    fn motions() -> [Motion; 2] {
        let mut random = Random::new(3);
        let mut motion = |shape: MotionShape| {
            let joints = vec![(0..shape.size()).map(|_| random.normal()).collect()];
            Motion { rate: 100.0, repetitions: 2, shape, joints }
        };
        [
            motion(MotionShape::Fourier(FourierSeries { period: 4.0, blend: 1.0, harmonics: 3 })),
            motion(MotionShape::Spline(QuinticSpline { period: 4.0, spans: 9 })),
        ]
    }

    #[test]
    fn courses_are_those_of_the_motion() {
        let text = "convention: khalil-kleinfinger\nname: arm\nlinks:\n  - {link: 1, antecedent: base, theta: q1}\n  - {link: 2, \
                    antecedent: 1, d: 0.5, theta: q2}\n";
        let robot = robot::format::read_yaml(text, "arm.yaml").unwrap();
        let (pendulum, parameters) = (Pendulum::new(), [0.3, 0.8, -0.1]);
        let friction = [NominalFriction { viscous: 0.2, coulomb: 0.4, offset: 0.1 }];
        let known =
            KnownRobot { robot: &robot, regressor: &pendulum, parameters: Some(&parameters), friction: &friction };
        for motion in motions() {
            let state = |t: f64| [motion.at(t)[0]];
            let t = 0.37 * motion.duration();
            let ([q, dq, ddq, _], found) = (state(t)[0], torques(&known, &state(t)).unwrap());
            let mut row = [0.0; 3];
            pendulum.fill(&[q], &[dq], &[ddq], &mut row);
            let rigid: f64 = row.iter().zip(parameters).map(|(y, x)| y * x).sum();
            let torque = rigid + 0.2 * dq + 0.1;
            assert!((found[0][0] - torque).abs() < 1e-12, "{found:?}");
            assert!((found[0][1] - (torque * dq + 0.4 * dq.abs())).abs() < 1e-12, "{found:?}");

            let tip = EndEffector::of(&robot).unwrap();
            let q = 0.7_f64;
            let place = tip.place(&[q, 0.2]);
            assert!((place[0] - 0.5 * q.cos()).abs() < 1e-12 && (place[1] - 0.5 * q.sin()).abs() < 1e-12, "{place:?}");
        }
    }
}
