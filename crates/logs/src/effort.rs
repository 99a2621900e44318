//! The quantity of the efforts in a log: torques, or signals that a gain of each drive converts to torques.
//!
//! Effort is the common name for the signal that determines the torque of a joint: the torque itself, a motor current, or the
//! position error of a servo (goal minus position).

use serde::Serialize;

use crate::cleaning::account::ReadColumns;
use crate::columns::names::{ColumnNames, NamePattern};
use crate::columns::words::Quantity;

/// The quantity in the effort columns of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// Torque, N m (N for a prismatic joint).
    Torque,
    /// Current, A; drive gains convert it to torques.
    Current,
    /// The goal of a position servo minus its position, rad (m); the gain of the servo converts it to a torque.
    #[serde(rename = "position error")]
    PositionError,
}

impl Effort {
    pub(crate) fn of(quantity: Quantity) -> Effort {
        match quantity {
            Quantity::Current => Effort::Current,
            Quantity::Goal => Effort::PositionError,
            _ => Effort::Torque,
        }
    }

    /// The column names that select the effort columns of `read`. Coordinates without a torque have no name.
    pub(crate) fn names(self, read: ReadColumns) -> ColumnNames {
        let effort = |of: Effort| Some(NamePattern::Each(read.effort.clone())).filter(|_| of == self);
        ColumnNames {
            torque: effort(Effort::Torque),
            current: effort(Effort::Current),
            goal: effort(Effort::PositionError),
            position: Some(NamePattern::Each(read.position)),
            velocity: read.velocity.map(NamePattern::Each),
            acceleration: read.acceleration.map(NamePattern::Each),
            ..ColumnNames::default()
        }
    }

    /// Whether a gain of each drive converts the efforts to torques.
    pub fn needs_gains(self) -> bool {
        self != Effort::Torque
    }

    /// The name of the efforts, in the plural.
    pub fn words(self) -> &'static str {
        match self {
            Effort::Torque => "torques",
            Effort::Current => "motor currents",
            Effort::PositionError => "position errors of servos",
        }
    }

    /// The unit of the gain that converts the efforts to torques, for revolute joints.
    pub fn gain_unit(self) -> &'static str {
        match self {
            Effort::Torque => "1",
            Effort::Current => "N m/A",
            Effort::PositionError => "N m/rad",
        }
    }
}
