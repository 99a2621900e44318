//! The hypotheses that are tested on a log and its model (faults of the log, rotors that the model lacks), with the
//! properties of each kind.
//!
//! Each kind is tested by one of two methods, or by both:
//!
//! | fault | method | module |
//! |---|---|---|
//! | small | the fault is an additional unknown of the fit, with a column h | `claims::hypotheses` |
//! | gross | the fault is undone in the log, and the robot description is compared with the corrected log | `log_check::search` |
//!
//! Wrong masses of the description may look like a fault. So both methods also fit the bodies (inertial parameters of the
//! links), and accept such a fault only if it reduces the error of cross-validation. A new kind needs a variant of `Hypothesis`
//! and its match arms in this file.

use claims::{Figure, Topic};
use linear_model::linear_model::Model;
use linear_model::states::States;
use linear_model::unit::Unit;
use serde::{Deserialize, Serialize};

use crate::estimate::digits::significant;
use crate::estimate::play::{Backlash, Sides, signs_of_torque};
use crate::estimate::residuals::JointResidual;
use crate::estimate::topics::{
    DEAD_CURRENT, DELAY, DRIFT, FRICTION, LOG, MOUNT, PLAY, RESIDUAL, ROTOR, SCALE, SIGN, SPRING, ZERO,
};
use crate::estimators::huber::Robust;

use Hypothesis::*;

/// Text before an entry of the options file that a remedy recommends.
pub(in crate::estimate) const OF_OPTIONS: &str = "in the file of [options]:";

/// Step of a joint angle for a central difference, rad.
const POSITION_STEP_RAD: f64 = 1e-4;
/// A fault is reported only if it explains at least this share of the torque. A smaller fault is harmless for every use of the
/// estimate.
const SMALLEST_TORQUE_SHARE: f64 = 0.002;
/// A spring is reported only if it explains at least this share of the torque. This share alone decides: there is no least
/// stiffness of a reported spring.
const SMALLEST_SPRING_SHARE: f64 = 1.25 * SMALLEST_TORQUE_SHARE;
const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;
/// Zero offsets and tilts of the base below this value are calibration errors and are not reported, rad.
const LEAST_ANGLE_RAD: f64 = DEGREE_RAD;
/// Play below this value is harmless and is not reported, rad.
const LEAST_PLAY_RAD: f64 = 0.1 * DEGREE_RAD;
/// Play counts as not detectable if its detection limit is at least this value, rad (10 degrees).
const USELESS_PLAY_RAD: f64 = 10.0 * DEGREE_RAD;
/// Scale errors of a torque below this value are calibration errors and are not reported (0.03: 3 %).
const LEAST_SCALE: f64 = 0.03;
/// A zero offset or a tilt counts as not detectable if its detection limit is at least this value, rad (45 degrees).
const USELESS_ANGLE_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// A scale error counts as not detectable if its detection limit is at least this value (0.5: 50 %).
const USELESS_SCALE: f64 = 0.5;

/// A hypothesis on a log or its model. The numbers in a variant are indices of coordinates, from 0. The comment of each variant
/// states the unit of the size of the fault.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hypothesis {
    /// The zero of the position of a coordinate has an offset, rad.
    Zero(usize),
    /// The logged torque of a coordinate is the true torque times (1 + size).
    Scale(usize),
    /// A spring acts on a coordinate, N m/rad (N/m).
    Spring(usize),
    /// Gravity is tilted by an angle, rad, about a horizontal axis. The number is not a coordinate but the nearest axis of the
    /// base frame (0: x, 1: y, 2: z).
    Mount(usize),
    /// The rotor of a coordinate has an inertia that the model lacks, kg m^2 (kg).
    Rotor(usize),
    /// The torque of a coordinate drifts between the first and the last sample. The size is the relative growth of the torque
    /// over the record.
    Drift(usize),
    /// The torque of a coordinate (`None`: of all coordinates) is logged too late, s.
    Late(Option<usize>),
    /// Currents of a coordinate below i_0 give no torque. The torque is K (i - i_0 sign i), or 0 if |i| < i_0; i: current, K:
    /// drive gain. The size is i_0, A.
    DeadCurrent(usize),
    /// Play of a coordinate: a gap between its encoder and its link. The size is the width of the gap, rad. The link is behind
    /// the encoder by half of the width, on the side of the gap that carries the torque.
    Play(usize),
    /// Coulomb friction of a coordinate grows with its load (coefficient, N m per N m).
    LoadFriction(usize),
    /// The torque of the first coordinate contains a share of the torque of the second.
    CrossTalk(usize, usize),
    /// Position, velocity and acceleration of a coordinate have the wrong sign.
    MotionSign(usize),
    /// The torque of a coordinate has the wrong sign.
    TorqueSign(usize),
    /// Motion and torque of a coordinate have the wrong sign.
    Reversed(usize),
    /// Motions and torques of two coordinates are exchanged.
    SwappedJoints(usize, usize),
    /// Positions, velocities and accelerations of two coordinates are exchanged.
    SwappedMotions(usize, usize),
    /// Only the positions of two coordinates are exchanged.
    SwappedPositions(usize, usize),
    /// Only the velocities and accelerations of two coordinates are exchanged.
    SwappedVelocities(usize, usize),
    /// Only the torques of two coordinates are exchanged.
    SwappedTorques(usize, usize),
    /// The angles are in degrees, but were read as radians.
    Degrees,
    /// Gravity was subtracted from the torques before the torques were logged.
    GravityCompensated,
}

/// The kinds of columns of a log that may be exchanged between joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Positions, velocities and torques.
    All,
    /// Positions and velocities.
    Motions,
    /// Torques.
    Torques,
}

/// The consequence of a confirmed hypothesis for the claims.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Counts {
    /// Positions are wrong. Such a fault is a contradiction even if the torque error in this log is small.
    AsPosition,
    /// Torques are wrong. Such a fault is a contradiction unless every use tolerates the torque error.
    AsTorque,
    /// The log is not wrong: the hypothesis explains a part of the residual of the fit.
    AsResidual,
    /// The fault only inflates standard deviations, and no claim names this fault.
    InDeviations,
    /// The log has a fault that makes the log unusable. Only the log check tests this fault; a fit has no column for it.
    AsLog,
}

/// Thresholds and consequence of one kind of hypothesis.
pub(super) struct HypothesisKind {
    /// Topic of a claim on this kind of hypothesis.
    pub topic: Topic,
    pub counts: Counts,
    /// Smallest size that is reported, in the unit of the hypothesis; 0 for no limit.
    pub least: f64,
    /// Smallest share of the torque that the hypothesis must explain to be reported.
    pub least_share: f64,
    /// Smallest useless detection limit, in the unit of the hypothesis. With a limit of at least this value, the hypothesis
    /// counts as not detectable.
    pub useless: f64,
    /// Whether the hypothesis inflates the standard deviations of the parameters if the data do not exclude it.
    pub may_be_there: bool,
    /// Whether the size cannot be negative, so that a negative size is another fault.
    pub is_positive: bool,
}

/// Topics of the kinds of faults that a claim may name, in the order in which the claims are made.
pub(super) const CLAIMED: [Topic; 6] = [MOUNT, ZERO, SCALE, SPRING, ROTOR, DRIFT];

impl Hypothesis {
    pub(super) fn kind(&self) -> HypothesisKind {
        let of = |topic: Topic, counts: Counts| HypothesisKind {
            topic,
            counts,
            least: 0.0,
            least_share: SMALLEST_TORQUE_SHARE,
            useless: f64::INFINITY,
            may_be_there: false,
            is_positive: false,
        };
        // Angles and scales below the calibration error are not reported. For other kinds, only the explained share of the torque
        // decides.
        let angle = |topic: Topic, may_be_there: bool| HypothesisKind {
            least: LEAST_ANGLE_RAD,
            useless: USELESS_ANGLE_RAD,
            may_be_there,
            ..of(topic, Counts::AsPosition)
        };
        let scale = HypothesisKind { least: LEAST_SCALE, useless: USELESS_SCALE, ..of(SCALE, Counts::AsTorque) };
        // Wrong bodies may hide a zero offset, a drift or a spring. So these faults inflate standard deviations unless the data
        // exclude them.
        match self {
            Zero(_) => angle(ZERO, true),
            Mount(_) => angle(MOUNT, false),
            Scale(_) => scale,
            Drift(_) => HypothesisKind { topic: DRIFT, counts: Counts::AsResidual, may_be_there: true, ..scale },
            Spring(_) => HypothesisKind {
                least_share: SMALLEST_SPRING_SHARE,
                may_be_there: true,
                ..of(SPRING, Counts::AsTorque)
            },
            Rotor(_) => of(ROTOR, Counts::AsTorque),
            DeadCurrent(_) => HypothesisKind { is_positive: true, ..of(DEAD_CURRENT, Counts::AsTorque) },
            // Play is in the machine and not in the log.
            Play(_) => HypothesisKind {
                least: LEAST_PLAY_RAD,
                useless: USELESS_PLAY_RAD,
                is_positive: true,
                ..of(PLAY, Counts::AsResidual)
            },
            Late(_) => of(DELAY, Counts::InDeviations),
            LoadFriction(_) => of(FRICTION, Counts::InDeviations),
            CrossTalk(..) => of(RESIDUAL, Counts::InDeviations),
            MotionSign(_) | TorqueSign(_) | Reversed(_) => of(SIGN, Counts::AsLog),
            GravityCompensated => of(MOUNT, Counts::AsLog),
            Degrees | SwappedJoints(..) | SwappedMotions(..) | SwappedPositions(..) => of(LOG, Counts::AsLog),
            SwappedVelocities(..) | SwappedTorques(..) => of(LOG, Counts::AsLog),
        }
    }

    /// Numbers of the coordinates that the hypothesis concerns; empty for the mount, and for faults of all coordinates.
    pub fn joints(&self) -> Vec<usize> {
        match *self {
            Mount(_) | Degrees | GravityCompensated | Late(None) => Vec::new(),
            Zero(k) | Scale(k) | Spring(k) | Rotor(k) | Drift(k) | Late(Some(k)) | LoadFriction(k) => vec![k],
            DeadCurrent(k) | Play(k) => vec![k],
            MotionSign(k) | TorqueSign(k) | Reversed(k) => vec![k],
            CrossTalk(k, l) | SwappedJoints(k, l) | SwappedMotions(k, l) => vec![k, l],
            SwappedPositions(k, l) | SwappedVelocities(k, l) | SwappedTorques(k, l) => vec![k, l],
        }
    }

    /// Number of the first coordinate that the hypothesis concerns; `None` if it concerns no single coordinate.
    pub fn joint(&self) -> Option<usize> {
        self.joints().first().copied()
    }

    /// Whether a fit to a robot of n coordinates can test this hypothesis by an additional column.
    pub fn is_of(&self, n: usize) -> bool {
        let is_there = if let Mount(axis) = *self { axis < 3 } else { self.joints().iter().all(|k| *k < n) };
        is_there && self.kind().counts != Counts::AsLog
    }

    /// Kind of columns that the fault exchanges. `None` for other faults, and for a fault that exchanges only positions or only
    /// velocities.
    pub(super) fn exchanges(self) -> Option<ColumnKind> {
        match self {
            SwappedJoints(..) => Some(ColumnKind::All),
            SwappedMotions(..) => Some(ColumnKind::Motions),
            SwappedTorques(..) => Some(ColumnKind::Torques),
            _ => None,
        }
    }

    /// Whether bodies with other, physically consistent masses and inertias may explain the log as well as this fault does.
    /// `brakes(k)`: whether friction of coordinate k dissipates in the log as recorded. `is_sure`: whether the nominal parameters
    /// of the description predict the torques nearly exactly after the fault is undone in the log.
    pub(super) fn may_be_bodies(self, brakes: impl Fn(usize) -> bool, is_sure: bool) -> bool {
        match self {
            Zero(_) | Scale(_) | Reversed(_) => true,
            TorqueSign(k) | MotionSign(k) => !is_sure && brakes(k),
            _ => !is_sure && self.exchanges().is_some(),
        }
    }

    /// Converts the size x of the fault from its SI unit to the unit of reports (deg, ms, %, ..).
    pub(super) fn figure(&self, x: f64, joints: &[JointResidual]) -> Figure {
        match *self {
            Zero(_) | Mount(_) | Play(_) => Figure::new(x.to_degrees(), "deg"),
            DeadCurrent(_) => Figure::new(x, "A"),
            Late(_) => Figure::new(1e3 * x, "ms"),
            Rotor(k) => Figure::new(x, if joints[k].unit == Unit::TORQUE { "kg m^2" } else { "kg" }),
            Spring(k) => Figure::new(x, if joints[k].unit == Unit::TORQUE { "N m/rad" } else { "N/m" }),
            _ => Figure::new(100.0 * x, "%"),
        }
    }

    /// A sentence on the fault and its size. `off`: the size in words; `names`: names of the coordinates that the fault
    /// concerns.
    pub fn statement(&self, off: &str, names: &[&str]) -> String {
        let (of, pair) = (names.first().copied().unwrap_or_default(), names.join(" and "));
        // One sentence for each kind of fault. First the faults with a size, then the faults without one (wrong signs,
        // exchanged columns, degrees, gravity).
        match *self {
            Zero(_) => format!("the zero of {of} is off by {off}"),
            Scale(_) => format!("the torque of {of} is off by {off} compared with the other joints"),
            Spring(_) => format!("a spring of {off} acts on {of}"),
            Mount(axis) => format!("gravity is tilted by {off} about {} of the base", ["x", "y", "z"][axis]),
            Rotor(_) => format!("a rotor of {off} that the model lacks stands behind {of}"),
            Drift(_) => format!("the torque of {of} grows by {off} from the first sample to the last"),
            // The sign of a delay becomes a word, because a negative delay is hard to read.
            Late(joint) => match (joint, off.strip_prefix('-')) {
                (Some(_), None) => format!("the torque of {of} is late by {off}"),
                (Some(_), Some(early)) => format!("the torque of {of} is early by {early}"),
                (None, None) => format!("the torques come {off} later than the positions"),
                (None, Some(early)) => format!("the torques come {early} before the positions"),
            },
            DeadCurrent(_) => format!("dead current: the first {off} of {of} give no torque"),
            Play(_) => format!("{of} has play of {off} between its encoder and its link"),
            CrossTalk(..) => format!("the torque of {of} holds {off} of that of {}", names[1..].concat()),
            LoadFriction(_) => format!("friction of {of} grows by {off} of its load"),
            MotionSign(_) => format!("the position of {of} has the wrong sign"),
            TorqueSign(_) => format!("the torque of {of} has the wrong sign"),
            Reversed(_) => format!("{of} runs the other way round: position and torque have the wrong sign"),
            SwappedJoints(..) => format!("the columns of {pair} are swapped (position, velocity and torque)"),
            SwappedMotions(..) => format!("the columns of {pair} are swapped (position and velocity)"),
            SwappedPositions(..) => format!("the position columns of {pair} are swapped"),
            SwappedVelocities(..) => format!("the velocity columns of {pair} are swapped"),
            SwappedTorques(..) => format!("the torque columns of {pair} are swapped"),
            Degrees => format!("{} in degrees, taken for radians", names.join(", ")),
            GravityCompensated => "gravity is not in the torques: it was taken out before they were logged".into(),
        }
    }

    /// The remedy for the fault, in words. `value`: the fitted size of the fault. `None` for kinds of faults that no claim
    /// names.
    pub(super) fn remedy(&self, value: f64, joints: &[JointResidual]) -> Option<String> {
        let at = |k: usize| &joints[k].coordinate;
        let listed = |list: &str, k: usize| {
            format!("{OF_OPTIONS} transmission: {{{list}: [..]}}, {} for {}", significant(value), at(k))
        };
        match *self {
            Zero(k) => Some(listed("offsets", k)),
            Scale(k) => Some(format!("look at the gain, the gear ratio or the unit of {}", at(k))),
            Spring(k) => Some(listed("springs", k)),
            DeadCurrent(k) => Some(listed("dead_currents", k)),
            Play(_) => Some("measure it: hold the motor, and turn the link by hand to both ends of the gap; no option takes play out of a log".into()),
            Rotor(_) => Some("take rotor inertias among the parameters: [rotor_inertia=actuated]".into()),
            Drift(k) => Some(format!("log {} again when its drive is warm and its gain is known", at(k))),
            Mount(_) => Some("[unknowns=mount] finds how the base is mounted, and prints the line that says it".into()),
            _ => None,
        }
    }

    /// Undoes the fault in the position, velocity and acceleration of one sample. `size`: for a zero, true minus logged
    /// position, rad; `is_angle`: for each coordinate, whether it is an angle.
    pub(super) fn undo_motion(self, size: f64, is_angle: &[bool], q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]) {
        match self {
            Zero(k) => q[k] += size,
            MotionSign(k) | Reversed(k) => [q, dq, ddq].into_iter().for_each(|x| x[k] = -x[k]),
            SwappedMotions(k, l) | SwappedJoints(k, l) => [q, dq, ddq].into_iter().for_each(|x| x.swap(k, l)),
            SwappedPositions(k, l) => q.swap(k, l),
            SwappedVelocities(k, l) => [dq, ddq].into_iter().for_each(|x| x.swap(k, l)),
            Degrees => {
                for x in [q, dq, ddq] {
                    x.iter_mut().zip(is_angle).filter(|(_, angle)| **angle).for_each(|(x, _)| *x *= DEGREE_RAD);
                }
            }
            _ => {}
        }
    }

    /// Number of the coordinate whose columns in the log contain the velocity of joint j. Wrong signs are ignored: a column and
    /// its negative span the same space.
    pub(super) fn motion_of(self, j: usize) -> usize {
        match self {
            SwappedMotions(k, l) | SwappedJoints(k, l) | SwappedVelocities(k, l) if k == j => l,
            SwappedMotions(k, l) | SwappedJoints(k, l) | SwappedVelocities(k, l) if l == j => k,
            _ => j,
        }
    }

    /// Number of the coordinate whose column in the log contains the position of joint j.
    pub(super) fn position_of(self, j: usize) -> usize {
        match self {
            SwappedMotions(k, l) | SwappedJoints(k, l) | SwappedPositions(k, l) if k == j => l,
            SwappedMotions(k, l) | SwappedJoints(k, l) | SwappedPositions(k, l) if l == j => k,
            _ => j,
        }
    }

    /// Number of the coordinate whose column in the log contains the torque of joint j, and the factor on that column that
    /// undoes the fault. `size`: the size of the fault.
    pub(super) fn torque_of(self, size: f64, j: usize) -> (usize, f64) {
        match self {
            Scale(k) if k == j => (j, 1.0 / (1.0 + size)),
            TorqueSign(k) | Reversed(k) if k == j => (j, -1.0),
            SwappedTorques(k, l) | SwappedJoints(k, l) if k == j => (l, 1.0),
            SwappedTorques(k, l) | SwappedJoints(k, l) if l == j => (k, 1.0),
            _ => (j, 1.0),
        }
    }
}

/// The solution of a fit and the weights of its rows, from which further sums over the rows are computed.
#[derive(Clone, Copy)]
pub struct FitPoint<'a> {
    /// The fitted parameters.
    pub x: &'a [f64],
    /// Weights of the rows by joint, one per coordinate.
    pub weights: &'a [f64],
    /// Robust weights: the weight of a row depends on its residual. `None` if all rows have equal weight.
    pub robust: Option<&'a Robust>,
}

/// Unknowns of the robot that are not parameters of the model: mount and rotors.
#[derive(Clone, Copy, Default)]
pub struct UndeterminedMechanics<'a> {
    /// For each horizontal axis about which gravity may be tilted: the number of the nearest axis of the base frame (0: x, 1:
    /// y, 2: z), and the torques per radian of tilt.
    pub tilts: &'a [(usize, Tilt<'a>)],
    /// Numbers of the coordinates for which the options do not say whether they have a rotor.
    pub rotors: &'a [usize],
    /// If the logs hold currents: the torque per current of each coordinate, N m/A (N/A). Otherwise empty.
    pub drives: &'a [f64],
    /// The play of each coordinate, as far as it is known. Empty if no play is known.
    pub play: &'a [Backlash],
}

/// Function from the positions q to the torques per radian of tilt about one axis, N m/rad (N/rad), one per coordinate.
pub type Tilt<'a> = &'a dyn Fn(&[f64]) -> Vec<f64>;

/// Lists all hypotheses on a model that a fit can test by an additional column.
pub(super) fn all(model: &Model, open: UndeterminedMechanics) -> Vec<Hypothesis> {
    let n = model.n();
    let turning = (0..n).filter(|&k| !model.regressor.is_prismatic(k)).map(Zero);
    let scales = (0..n).filter(|_| n > 1).map(Scale);
    let springs = (0..n).map(Spring);
    let mounts = open.tilts.iter().map(|(axis, _)| Mount(*axis));
    let rotors = open.rotors.iter().copied().map(Rotor);
    let late = (0..n).map(Some).chain([None]).map(Late);
    let faults = turning.chain(scales).chain(springs).chain(mounts).chain(rotors).chain((0..n).map(Drift));
    let talk = (0..n).flat_map(|k| (0..n).filter(move |&i| i != k).map(move |i| CrossTalk(k, i)));
    let drives = open.drives.iter().enumerate().filter(|(_, gain)| **gain != 0.0).map(|(k, _)| DeadCurrent(k));
    let play = (0..n).filter(|&k| !model.regressor.is_prismatic(k)).map(Play);
    faults.chain(drives).chain(play).chain(late).chain((0..n).map(LoadFriction)).chain(talk).collect()
}

/// The column h of each hypothesis: change of the torques per unit of the size of the fault, sample by sample, n numbers per
/// sample. `x`: the fitted parameters.
pub(super) fn columns(
    model: &Model,
    states: &States,
    x: &[f64],
    all: &[Hypothesis],
    open: UndeterminedMechanics,
) -> Vec<Vec<f64>> {
    let (n, base) = (model.n(), model.regressor.parameters().len());
    // Torques Y(q, dq, ddq) x of the bodies in a motion that may differ from the logged one.
    let moving = |[q, dq, ddq]: [&[f64]; 3], y: &mut [f64]| -> Vec<f64> {
        model.regressor.fill(q, dq, ddq, y);
        y.chunks_exact(base).map(|row| row.iter().zip(x).map(|(y, x)| y * x).sum()).collect()
    };
    let torques = |q: &[f64], r: usize, y: &mut [f64]| {
        let at = r * n..(r + 1) * n;
        moving([q, &states.dq[at.clone()], &states.ddq[at]], y)
    };
    let has_play = all.iter().any(|hypothesis| matches!(hypothesis, Play(_)));
    let sides = if has_play { Sides::of(model, states, x, open.play) } else { Sides::default() };
    let is_driven = |k: usize| all.contains(&DeadCurrent(k));
    let signs: Vec<Vec<f64>> =
        (0..n).map(|k| if is_driven(k) { signs_of_torque(states, k) } else { Vec::new() }).collect();
    let mut columns = vec![Vec::with_capacity(states.len() * n); all.len()];
    let mut y = vec![0.0; n * base];
    let first = states.t.first().copied().unwrap_or(0.0);
    let seconds = states.t.last().map_or(0.0, |last| last - first).max(f64::MIN_POSITIVE);
    for r in 0..states.len() {
        let along = (states.t[r] - first) / seconds - 0.5;
        let mut q = states.q[r * n..(r + 1) * n].to_vec();
        let here = torques(&q, r, &mut y);
        for (column, hypothesis) in columns.iter_mut().zip(all) {
            let only = |k: usize, x: f64| (0..n).map(move |j| if j == k { x } else { 0.0 });
            match *hypothesis {
                Zero(k) => {
                    // h_j = d(Y_j x)/dq_k, by a central difference.
                    let position = q[k];
                    let mut moved = |by: f64| {
                        q[k] = position + by;
                        torques(&q, r, &mut y)
                    };
                    let (behind, before) = (moved(POSITION_STEP_RAD), moved(-POSITION_STEP_RAD));
                    q[k] = position;
                    column.extend(behind.iter().zip(before).map(|(a, b)| (a - b) / (2.0 * POSITION_STEP_RAD)));
                }
                Scale(k) => column.extend(only(k, here[k])),
                Spring(k) => column.extend(only(k, q[k])),
                Mount(of) => {
                    let tilts = open.tilts.iter().filter(|(axis, _)| *axis == of);
                    tilts.for_each(|(_, torques)| column.extend(torques(&q)));
                }
                Rotor(k) => column.extend(only(k, states.ddq[r * n + k])),
                Drift(k) => column.extend(only(k, along * states.tau[r * n + k])),
                Late(late) => column
                    .extend((0..n).map(|j| if late.is_none_or(|k| k == j) { -torque_rate(states, r, j) } else { 0.0 })),
                DeadCurrent(k) => column.extend(only(k, open.drives[k] * signs[k][r])),
                Play(k) => column.extend(sides.column(states, r, k, |motion| moving(motion, &mut y))),
                LoadFriction(k) => column.extend(only(k, states.direction[r * n + k] * here[k].abs())),
                CrossTalk(k, i) => column.extend(only(k, states.tau[r * n + i])),
                // `all` lists no hypothesis of this kind.
                _ => column.extend(only(0, 0.0)),
            }
        }
    }
    columns
}

/// Torque rate d tau_j/dt at sample r, from the samples before and after, N m/s (N/s). If a long log was thinned, the rate is
/// inaccurate and a delay is not identifiable.
fn torque_rate(states: &States, r: usize, j: usize) -> f64 {
    let (before, behind) = (r.saturating_sub(1), (r + 1).min(states.len() - 1));
    let seconds = states.t[behind] - states.t[before];
    let change = states.tau[behind * states.n + j] - states.tau[before * states.n + j];
    if seconds > 0.0 { change / seconds } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_negative_delay_is_early() {
        let of_joint = |off| Late(Some(0)).statement(off, &["j1"]);
        assert_eq!(of_joint("3 ms"), "the torque of j1 is late by 3 ms");
        assert_eq!(of_joint("-3 ms +- 1 ms"), "the torque of j1 is early by 3 ms +- 1 ms");
        assert_eq!(Late(None).statement("-3 ms", &[]), "the torques come 3 ms before the positions");
    }
}
