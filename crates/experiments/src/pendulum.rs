//! A pendulum on a fixed pivot, the test robot of the unit tests here and in `identification`: the smallest robot with inertia
//! and gravity. Whole arms are tested in the package `tests`.

use linear_model::parameter::BaseParameter;
use linear_model::regressor::Regressor;

/// A pendulum with the torque tau = ZZ ddq + MX g cos q + MY g (-sin q).
pub(crate) struct Pendulum {
    coordinates: Vec<String>,
    parameters: Vec<BaseParameter>,
    pub truth: [f64; 3],
}

impl Pendulum {
    pub(crate) fn new() -> Pendulum {
        Pendulum {
            coordinates: vec!["q1".into()],
            parameters: ["ZZ1", "MX1", "MY1"].map(|name| BaseParameter::turning(name, 0).unwrap()).to_vec(),
            truth: [0.3, 0.8, -0.1],
        }
    }
}

impl Regressor for Pendulum {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.parameters
    }

    fn fill(&self, q: &[f64], _: &[f64], ddq: &[f64], y: &mut [f64]) {
        let (s, c) = q[0].sin_cos();
        y.copy_from_slice(&[ddq[0], 9.81 * c, -9.81 * s]);
    }
}
