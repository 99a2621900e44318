//! Regressors compiled in from the package `generated`.

use crate::model::regressor::Regressor;

/// A robot's compiled base regressor.
pub struct Compiled {
    function: &'static generated::Compiled,
    coordinates: Vec<String>,
    parameters: Vec<String>,
}

/// The compiled regressor that is this very function, when there is one.
///
/// `fingerprint` is that of the robot's base regressor with its constants in place, so that a robot
/// of the same name and another geometry is not taken for it.
pub fn compiled(fingerprint: u64) -> Option<Compiled> {
    let function = generated::find(fingerprint)?;
    let owned = |names: &[&str]| names.iter().map(|name| name.to_string()).collect();
    Some(Compiled { function, coordinates: owned(function.coordinates), parameters: owned(function.parameters) })
}

impl Regressor for Compiled {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[String] {
        &self.parameters
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        let filled = self.function.fill(q, dq, ddq, y);
        debug_assert!(filled, "the lengths are those of the coordinates and parameters");
    }

    fn fill_many(&self, states: &[f64], y: &mut [f64]) {
        let filled = self.function.fill_many(states, y);
        debug_assert!(filled, "the lengths are those of the coordinates and parameters");
    }
}
