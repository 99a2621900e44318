//! The command of the wing (optional package) `calibration`.

pub(crate) mod calibrate;
