//! What the efforts of a log are: torques, or what a gain of each drive makes torques of.

use serde::Serialize;

use crate::cleaning::account::ReadColumns;
use crate::columns::names::{ColumnNames, Names};
use crate::columns::words::Quantity;

/// What the effort columns of a log hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// N m (N for a prismatic joint).
    Torque,
    /// A; drive gains make torques of it.
    Current,
    /// rad (m), the goal of a position servo minus its position; the gain of the servo makes a torque of it.
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

    /// The options that choose the columns which were read. Coordinates without a torque have none there.
    pub(crate) fn names(self, read: ReadColumns) -> ColumnNames {
        let effort = |of: Effort| Some(Names::Each(read.effort.clone())).filter(|_| of == self);
        ColumnNames {
            torque: effort(Effort::Torque),
            current: effort(Effort::Current),
            goal: effort(Effort::PositionError),
            position: Some(Names::Each(read.position)),
            velocity: read.velocity.map(Names::Each),
            acceleration: read.acceleration.map(Names::Each),
            ..ColumnNames::default()
        }
    }

    /// Whether a gain of each drive makes torques of them.
    pub fn needs_gains(self) -> bool {
        self != Effort::Torque
    }

    /// What they are called: several of them.
    pub fn words(self) -> &'static str {
        match self {
            Effort::Torque => "torques",
            Effort::Current => "motor currents",
            Effort::PositionError => "position errors of servos",
        }
    }

    /// The unit of the gain that makes torques of them, of joints that turn.
    pub fn gain_unit(self) -> &'static str {
        match self {
            Effort::Torque => "1",
            Effort::Current => "N m/A",
            Effort::PositionError => "N m/rad",
        }
    }
}
