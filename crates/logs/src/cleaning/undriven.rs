//! Coordinates without a torque.

use serde::Serialize;

/// Why a log has no torque of a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Undriven {
    /// Something else moves it: its torque is not known, and gives no rows.
    Prescribed,
    /// Nothing drives it: its torque is zero, and that is measured.
    Free,
}
