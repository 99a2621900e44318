//! Coordinates without a torque.

use serde::Serialize;

/// The reason why a log has no torque of a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NoTorqueReason {
    /// Moved from outside: its torque is unknown, and gives no rows.
    Prescribed,
    /// Nothing drives it: its torque is zero, and that is measured.
    Free,
}
