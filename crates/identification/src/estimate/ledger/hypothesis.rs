//! A fault of a log, or a rotor that a model lacks, that a fit may tell as one unknown more.

use serde::{Deserialize, Serialize};

use crate::estimators::huber::Robust;

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

impl Hypothesis {
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

    /// Whether a claim may name it.
    pub(super) fn is_claimed(&self) -> bool {
        !matches!(self, Hypothesis::Late(_) | Hypothesis::LoadFriction(_) | Hypothesis::CrossTalk(..))
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
