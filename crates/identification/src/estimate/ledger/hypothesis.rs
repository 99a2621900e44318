//! A fault of a log, or a rotor that a model lacks, that a fit may tell as one unknown more: all that is known of each kind.
//!
//! Another kind is a variant, and what this file says of it: who may have it, its column h, how it counts, its words.

use claims::{Figure, Topic};
use linear_model::linear_model::Model;
use linear_model::states::States;
use linear_model::unit::Unit;
use serde::{Deserialize, Serialize};

use crate::estimate::digits::significant;
use crate::estimate::ledger::topics::{DELAY, DRIFT, FRICTION, MOUNT, RESIDUAL, ROTOR, SCALE, SPRING, ZERO};
use crate::estimate::residuals::JointResidual;
use crate::estimators::huber::Robust;

/// Step of the derivative by a position, rad (m).
const POSITION_STEP: f64 = 1e-4;
/// A fault that explains a smaller share of the torque harms no use; nor does a spring of a quarter more, which has no least
/// size of its own.
const SMALLEST_SHARE: f64 = 0.002;
const SMALLEST_SPRING_SHARE: f64 = 1.25 * SMALLEST_SHARE;
/// Smaller angles and scales than these are errors of calibration, rad and 1.
const LEAST_ANGLE_RAD: f64 = std::f64::consts::PI / 180.0;
const LEAST_SCALE: f64 = 0.03;
/// Powers beyond these tell nobody anything: 45 degrees, and half of a torque.
const USELESS_ANGLE_RAD: f64 = std::f64::consts::FRAC_PI_4;
const USELESS_SCALE: f64 = 0.5;

/// One fault of a log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hypothesis {
    /// The zero of a coordinate is off, rad.
    Zero(usize),
    /// The torque of a coordinate is so many times too large, less one.
    Scale(usize),
    /// A spring acts on a coordinate, N m/rad (N/m).
    Spring(usize),
    /// Gravity is tilted about an axis across it, by the number of the axis of the base that is nearest, rad.
    Mount(usize),
    /// The rotor of a coordinate has an inertia that the model lacks, kg m^2 (kg).
    Rotor(usize),
    /// The torque of a coordinate grows by this share of itself between the first and the last sample.
    Drift(usize),
    /// The torque of a coordinate, or of all, is logged late, s.
    Late(Option<usize>),
    /// Coulomb friction of a coordinate grows with its load, N m per N m.
    LoadFriction(usize),
    /// The torque of the first coordinate holds a share of that of the second.
    CrossTalk(usize, usize),
}

/// How a hypothesis that a fit tells counts.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Counts {
    /// Positions are wrong: a contradiction, whatever torque that costs in this log.
    AsPosition,
    /// Torques are wrong: a contradiction, unless they are as they should be but for less than a use asks for.
    AsTorque,
    /// It is part of what the fit leaves.
    AsResidual,
    /// It is part of the deviations and never named.
    InDeviations,
}

/// What is known of a kind of hypothesis.
pub(super) struct Kind {
    /// What a claim on it is about.
    pub topic: Topic,
    pub counts: Counts,
    /// The least size that matters.
    pub least: f64,
    /// The share of the torque that it explains at least.
    pub least_share: f64,
    /// Powers from it on tell nobody anything.
    pub useless: f64,
    /// Whether it widens deviations where the data do not exclude it.
    pub may_be_there: bool,
}

/// The kinds that a claim may name, in the order of the claims.
pub(super) const CLAIMED: [Topic; 6] = [MOUNT, ZERO, SCALE, SPRING, ROTOR, DRIFT];

impl Hypothesis {
    pub(super) fn kind(&self) -> Kind {
        let of = |topic: Topic, counts: Counts| Kind {
            topic,
            counts,
            least: 0.0,
            least_share: SMALLEST_SHARE,
            useless: f64::INFINITY,
            may_be_there: false,
        };
        let angle = |topic: Topic, may_be_there: bool| Kind {
            least: LEAST_ANGLE_RAD,
            useless: USELESS_ANGLE_RAD,
            may_be_there,
            ..of(topic, Counts::AsPosition)
        };
        let scale = Kind { least: LEAST_SCALE, useless: USELESS_SCALE, ..of(SCALE, Counts::AsTorque) };
        match self {
            Hypothesis::Zero(_) => angle(ZERO, true),
            Hypothesis::Mount(_) => angle(MOUNT, false),
            Hypothesis::Scale(_) => scale,
            Hypothesis::Drift(_) => Kind { topic: DRIFT, counts: Counts::AsResidual, may_be_there: true, ..scale },
            Hypothesis::Spring(_) => {
                Kind { least_share: SMALLEST_SPRING_SHARE, may_be_there: true, ..of(SPRING, Counts::AsTorque) }
            }
            Hypothesis::Rotor(_) => of(ROTOR, Counts::AsTorque),
            Hypothesis::Late(_) => of(DELAY, Counts::InDeviations),
            Hypothesis::LoadFriction(_) => of(FRICTION, Counts::InDeviations),
            Hypothesis::CrossTalk(..) => of(RESIDUAL, Counts::InDeviations),
        }
    }

    /// The coordinate; `None` for the mount and for torques that are all late.
    pub fn joint(&self) -> Option<usize> {
        match *self {
            Hypothesis::Mount(_) => None,
            Hypothesis::Late(k) => k,
            Hypothesis::Zero(k)
            | Hypothesis::Scale(k)
            | Hypothesis::Spring(k)
            | Hypothesis::Rotor(k)
            | Hypothesis::Drift(k)
            | Hypothesis::LoadFriction(k)
            | Hypothesis::CrossTalk(k, _) => Some(k),
        }
    }

    /// Whether a robot of n coordinates may have it.
    pub(crate) fn is_of(&self, n: usize) -> bool {
        match *self {
            Hypothesis::Mount(axis) => axis < 3,
            Hypothesis::CrossTalk(k, i) => k < n && i < n,
            _ => self.joint().is_none_or(|k| k < n),
        }
    }

    /// A size of it, as it is shown.
    pub(super) fn figure(&self, x: f64, joints: &[JointResidual]) -> Figure {
        match *self {
            Hypothesis::Zero(_) | Hypothesis::Mount(_) => Figure::new(x.to_degrees(), "deg"),
            Hypothesis::Scale(_) | Hypothesis::Drift(_) | Hypothesis::LoadFriction(_) | Hypothesis::CrossTalk(..) => {
                Figure::new(100.0 * x, "%")
            }
            Hypothesis::Late(_) => Figure::new(1e3 * x, "ms"),
            Hypothesis::Rotor(k) => Figure::new(x, if joints[k].unit == Unit::TORQUE { "kg m^2" } else { "kg" }),
            Hypothesis::Spring(k) => Figure::new(x, if joints[k].unit == Unit::TORQUE { "N m/rad" } else { "N/m" }),
        }
    }

    /// What it is and how large; `off`: its size, with its deviation.
    pub(super) fn statement(&self, off: &str, joints: &[JointResidual]) -> String {
        let at = |k: usize| &joints[k].coordinate;
        match *self {
            Hypothesis::Zero(k) => format!("the zero of {} is off by {off}", at(k)),
            Hypothesis::Scale(k) => format!("the torque of {} is off by {off} beside those of the other joints", at(k)),
            Hypothesis::Spring(k) => format!("a spring of {off} acts on {}", at(k)),
            Hypothesis::Mount(axis) => {
                format!("gravity is tilted by {off} about {} of the base", ["x", "y", "z"][axis])
            }
            Hypothesis::Rotor(k) => format!("a rotor of {off} that the model lacks stands behind {}", at(k)),
            Hypothesis::Drift(k) => format!("the torque of {} grows by {off} from the first sample to the last", at(k)),
            Hypothesis::Late(Some(k)) => format!("the torque of {} is late by {off}", at(k)),
            Hypothesis::Late(None) => format!("the torques are late by {off}"),
            Hypothesis::CrossTalk(k, i) => format!("the torque of {} holds {off} of that of {}", at(k), at(i)),
            Hypothesis::LoadFriction(k) => format!("friction of {} grows by {off} of its load", at(k)),
        }
    }

    /// What mends a size of it; `None` of those that no claim names.
    pub(super) fn remedy(&self, value: f64, joints: &[JointResidual]) -> Option<String> {
        let at = |k: usize| &joints[k].coordinate;
        Some(match *self {
            Hypothesis::Zero(k) => {
                format!(
                    "in the file of [options]: transmission: {{offsets: [..]}}, {} for {}",
                    significant(value),
                    at(k)
                )
            }
            Hypothesis::Scale(k) => format!("look at the gain, the gear ratio or the unit of {}", at(k)),
            Hypothesis::Spring(k) => {
                format!(
                    "in the file of [options]: transmission: {{springs: [..]}}, {} for {}",
                    significant(value),
                    at(k)
                )
            }
            Hypothesis::Rotor(_) => "take rotor inertias among the parameters: [rotor_inertia=actuated]".into(),
            Hypothesis::Late(_) | Hypothesis::LoadFriction(_) | Hypothesis::CrossTalk(..) => return None,
            Hypothesis::Drift(k) => format!("log {} again when its drive is warm and its gain is known", at(k)),
            Hypothesis::Mount(_) => {
                "[unknowns=mount] finds how the base is mounted, and prints the line that says it".into()
            }
        })
    }
}

/// A fit, beside which more is asked of its rows.
#[derive(Clone, Copy)]
pub struct Point<'a> {
    /// The parameters.
    pub x: &'a [f64],
    /// The weights of the joints.
    pub weights: &'a [f64],
    /// What rows count by their residual, where not all alike.
    pub robust: Option<&'a Robust>,
}

/// What the mechanics of a robot leave open beside the parameters.
#[derive(Clone, Copy, Default)]
pub struct Open<'a> {
    /// The torques per radian of tilt about axes across gravity, with the number of the axis of the base that is nearest.
    pub tilts: &'a [(usize, Tilt<'a>)],
    /// The coordinates of which nobody said whether a rotor stands behind them.
    pub rotors: &'a [usize],
}

/// Torques at a position q per radian of tilt about one axis, n numbers.
pub type Tilt<'a> = &'a dyn Fn(&[f64]) -> Vec<f64>;

/// The hypotheses of a model.
pub(super) fn all(model: &Model, open: Open) -> Vec<Hypothesis> {
    let n = model.n();
    let turning = (0..n).filter(|&k| !model.regressor.is_prismatic(k)).map(Hypothesis::Zero);
    let scales = (0..n).filter(|_| n > 1).map(Hypothesis::Scale);
    let springs = (0..n).map(Hypothesis::Spring);
    let mounts = open.tilts.iter().map(|(axis, _)| Hypothesis::Mount(*axis));
    let rotors = open.rotors.iter().copied().map(Hypothesis::Rotor);
    let late = (0..n).map(Some).chain([None]).map(Hypothesis::Late);
    let faults = turning.chain(scales).chain(springs).chain(mounts).chain(rotors).chain((0..n).map(Hypothesis::Drift));
    let talk = (0..n).flat_map(|k| (0..n).filter(move |&i| i != k).map(move |i| Hypothesis::CrossTalk(k, i)));
    faults.chain(late).chain((0..n).map(Hypothesis::LoadFriction)).chain(talk).collect()
}

/// The columns of the hypotheses, sample by sample, n each.
pub(super) fn columns(model: &Model, states: &States, x: &[f64], all: &[Hypothesis], open: Open) -> Vec<Vec<f64>> {
    let (n, base) = (model.n(), model.regressor.parameters().len());
    // Y(q) x at sample r, with another q than the sample's where a zero is moved.
    let torques = |q: &[f64], r: usize, y: &mut [f64]| -> Vec<f64> {
        let at = r * n..(r + 1) * n;
        model.regressor.fill(q, &states.dq[at.clone()], &states.ddq[at], y);
        y.chunks_exact(base).map(|row| row.iter().zip(x).map(|(y, x)| y * x).sum()).collect()
    };
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
                Hypothesis::Zero(k) => {
                    // h_j = d(Y_j x)/dq_k, by a central difference.
                    let position = q[k];
                    let mut moved = |by: f64| {
                        q[k] = position + by;
                        torques(&q, r, &mut y)
                    };
                    let (behind, before) = (moved(POSITION_STEP), moved(-POSITION_STEP));
                    q[k] = position;
                    column.extend(behind.iter().zip(before).map(|(a, b)| (a - b) / (2.0 * POSITION_STEP)));
                }
                Hypothesis::Scale(k) => column.extend(only(k, here[k])),
                Hypothesis::Spring(k) => column.extend(only(k, q[k])),
                Hypothesis::Mount(of) => {
                    let tilts = open.tilts.iter().filter(|(axis, _)| *axis == of);
                    tilts.for_each(|(_, torques)| column.extend(torques(&q)));
                }
                Hypothesis::Rotor(k) => column.extend(only(k, states.ddq[r * n + k])),
                Hypothesis::Drift(k) => column.extend(only(k, along * states.tau[r * n + k])),
                Hypothesis::Late(late) => column
                    .extend((0..n).map(|j| if late.is_none_or(|k| k == j) { -torque_rate(states, r, j) } else { 0.0 })),
                Hypothesis::LoadFriction(k) => column.extend(only(k, states.direction[r * n + k] * here[k].abs())),
                Hypothesis::CrossTalk(k, i) => column.extend(only(k, states.tau[r * n + i])),
            }
        }
    }
    columns
}

/// d tau_j/dt at sample r, by the samples before and behind, N m/s (N/s). Of a log so long that few of its samples are taken
/// it says little, and tells no delay.
fn torque_rate(states: &States, r: usize, j: usize) -> f64 {
    let (before, behind) = (r.saturating_sub(1), (r + 1).min(states.len() - 1));
    let seconds = states.t[behind] - states.t[before];
    let change = states.tau[behind * states.n + j] - states.tau[before * states.n + j];
    if seconds > 0.0 { change / seconds } else { 0.0 }
}
