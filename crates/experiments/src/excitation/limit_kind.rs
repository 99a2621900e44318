//! The kinds of limits of a motion.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A kind of limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitKind {
    /// rad (m).
    Position,
    /// rad/s (m/s).
    Velocity,
    /// rad/s^2 (m/s^2).
    Acceleration,
    /// rad/s^3 (m/s^3).
    Jerk,
    /// N m (N).
    Effort,
    /// Of a drive: torque times velocity, W.
    Power,
    /// Between two links, m.
    Distance,
    /// From a floor, a wall or the side of a box, m.
    Region,
}

impl LimitKind {
    /// Those of the motion alone, in the order of its derivatives.
    pub const KINEMATIC: [LimitKind; 4] =
        [LimitKind::Position, LimitKind::Velocity, LimitKind::Acceleration, LimitKind::Jerk];

    /// All, in the order of a certificate.
    pub const ALL: [LimitKind; 8] = [
        LimitKind::Position,
        LimitKind::Velocity,
        LimitKind::Acceleration,
        LimitKind::Jerk,
        LimitKind::Distance,
        LimitKind::Region,
        LimitKind::Effort,
        LimitKind::Power,
    ];

    /// The unit; both where nobody says whether the joint slides: `rad (m)`.
    pub fn unit_of(self, is_prismatic: Option<bool>) -> String {
        let (turns, slides) = (self.unit(false), self.unit(true));
        match is_prismatic {
            Some(is_prismatic) => self.unit(is_prismatic).into(),
            None if turns == slides => turns.into(),
            None => format!("{turns} ({slides})"),
        }
    }

    /// The unit at a joint that turns, or slides.
    pub fn unit(self, is_prismatic: bool) -> &'static str {
        match (self, is_prismatic) {
            (LimitKind::Position, false) => "rad",
            (LimitKind::Velocity, false) => "rad/s",
            (LimitKind::Acceleration, false) => "rad/s^2",
            (LimitKind::Jerk, false) => "rad/s^3",
            (LimitKind::Effort, false) => "N m",
            (LimitKind::Position, true) => "m",
            (LimitKind::Velocity, true) => "m/s",
            (LimitKind::Acceleration, true) => "m/s^2",
            (LimitKind::Jerk, true) => "m/s^3",
            (LimitKind::Effort, true) => "N",
            (LimitKind::Power, _) => "W",
            (LimitKind::Distance | LimitKind::Region, _) => "m",
        }
    }
}

impl fmt::Display for LimitKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            LimitKind::Position => "position",
            LimitKind::Velocity => "velocity",
            LimitKind::Acceleration => "acceleration",
            LimitKind::Jerk => "jerk",
            LimitKind::Effort => "effort",
            LimitKind::Power => "power",
            LimitKind::Distance => "distance",
            LimitKind::Region => "region",
        })
    }
}
