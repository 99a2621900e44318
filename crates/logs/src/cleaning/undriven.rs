//! The reasons why a coordinate has no torque in a log.

use serde::Serialize;

/// The reason why a log has no torque of a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NoTorqueReason {
    /// The coordinate is moved from outside: its torque is unknown, so it gives no regression rows.
    Prescribed,
    /// The coordinate has no drive: its torque is known to be zero.
    Free,
}
