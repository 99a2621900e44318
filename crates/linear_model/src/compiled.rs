//! Base regressors whose code is compiled into the program, from the package `generated`. Such a regressor is found by its
//! fingerprint, a hash of the base regressor of a robot.

use generated::Eight;

use crate::parameter::BaseParameter;
use crate::regressor::{Coordinate, Regressor};

/// The base regressor of a robot as a compiled function of `generated`.
pub struct Compiled {
    function: &'static generated::Compiled,
    coordinates: Vec<String>,
    prismatic: Vec<bool>,
    parameters: Vec<BaseParameter>,
}

/// Whether the regressor with this fingerprint was compiled into the program.
pub fn is_compiled(fingerprint: u64) -> bool {
    generated::find(fingerprint).is_some()
}

/// The compiled regressor with this fingerprint. `None` if there is none, or if it has another number of coordinates or
/// parameters.
///
/// `fingerprint`: fingerprint of the base regressor of the robot with its constants. A robot of the same name with another
/// geometry has another fingerprint. The compiled function depends only on the geometry, so the names of coordinates and
/// parameters come from the caller.
pub fn compiled(fingerprint: u64, coordinates: Vec<Coordinate>, parameters: Vec<BaseParameter>) -> Option<Compiled> {
    let function = generated::find(fingerprint)?;
    let fits = function.coordinates.len() == coordinates.len() && function.parameters.len() == parameters.len();
    let (names, prismatic) = coordinates.into_iter().map(|c| (c.name, c.is_prismatic)).unzip();
    fits.then_some(Compiled { function, coordinates: names, prismatic, parameters })
}

impl Regressor for Compiled {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.parameters
    }

    fn is_prismatic(&self, k: usize) -> bool {
        self.prismatic[k]
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        let filled = self.function.fill(q, dq, ddq, y);
        debug_assert!(filled, "the lengths are those of the coordinates and parameters");
    }

    fn fill_many(&self, states: &[f64], y: &mut [f64]) {
        let filled = self.function.fill_many(states, y);
        debug_assert!(filled, "the lengths are those of the coordinates and parameters");
    }

    fn non_zeros(&self) -> Vec<(usize, usize)> {
        self.function.non_zeros.to_vec()
    }

    fn fill_blocks(&self, states: &[f64], stride: usize, blocks: &mut [Eight]) {
        let (n, entries) = (self.coordinates.len(), self.function.non_zeros.len());
        for (states, group) in states.chunks_exact(8 * 3 * n.max(1)).zip(blocks.chunks_mut(stride)) {
            let filled = self.function.fill_eight(states, &mut group[..entries]);
            debug_assert!(filled, "the lengths are those of the coordinates and entries");
        }
    }
}
