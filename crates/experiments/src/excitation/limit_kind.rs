//! The kinds of limits of a motion, with their names and units.

use std::fmt;

use LimitKind::*;
use serde::{Deserialize, Serialize};

/// A quantity that a motion limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitKind {
    /// Position, rad (m).
    Position,
    /// Velocity, rad/s (m/s).
    Velocity,
    /// Acceleration, rad/s^2 (m/s^2).
    Acceleration,
    /// Jerk, rad/s^3 (m/s^3).
    Jerk,
    /// Torque of a drive (N m) or force (N).
    Effort,
    /// Power of a drive: torque times velocity, W.
    Power,
    /// Distance of two links, m.
    Distance,
    /// Distance of a link from a floor, a wall or the side of a box, m.
    Region,
}

impl LimitKind {
    /// The kinematic limits, in the order of the derivatives.
    pub const KINEMATIC: [LimitKind; 4] = [Position, Velocity, Acceleration, Jerk];

    /// The limits that belong to a single coordinate (not to links).
    pub const OF_A_COORDINATE: [LimitKind; 6] = [Position, Velocity, Acceleration, Jerk, Effort, Power];

    /// All kinds of limits, in the order of the rows of a certificate.
    pub const ALL: [LimitKind; 8] = [Position, Velocity, Acceleration, Jerk, Distance, Region, Effort, Power];

    /// The name of the kind, in messages.
    pub fn word(self) -> &'static str {
        match self {
            Position => "position",
            Velocity => "velocity",
            Acceleration => "acceleration",
            Jerk => "jerk",
            Effort => "effort",
            Power => "power",
            Distance => "distance",
            Region => "region",
        }
    }

    /// The unit of the limited quantity. `is_prismatic`: whether the joint slides; `None`: unknown, so both units are given: `rad
    /// (m)`.
    pub fn unit_of(self, is_prismatic: Option<bool>) -> String {
        let (turns, slides) = (self.unit(false), self.unit(true));
        match is_prismatic {
            Some(is_prismatic) => self.unit(is_prismatic).into(),
            None if turns == slides => turns.into(),
            None => format!("{turns} ({slides})"),
        }
    }

    /// The unit of the limited quantity for a revolute or a prismatic joint.
    pub fn unit(self, is_prismatic: bool) -> &'static str {
        match (self, is_prismatic) {
            (Position, false) => "rad",
            (Velocity, false) => "rad/s",
            (Acceleration, false) => "rad/s^2",
            (Jerk, false) => "rad/s^3",
            (Effort, false) => "N m",
            (Position, true) => "m",
            (Velocity, true) => "m/s",
            (Acceleration, true) => "m/s^2",
            (Jerk, true) => "m/s^3",
            (Effort, true) => "N",
            (Power, _) => "W",
            (Distance | Region, _) => "m",
        }
    }
}

impl fmt::Display for LimitKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}
