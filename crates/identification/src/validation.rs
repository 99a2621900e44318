//! How well an estimate predicts torques it was not made from.
//!
//! relative_j = |tau_j - W_j X| / |tau_j| on states that were not used, or on each part of the
//! record with X from all other parts (blocked cross-validation: neighbours in time are alike, so
//! parts are contiguous; the parts beside a hole may be left out too).

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use crate::Error;
use crate::estimate::{JointResidual, write_residuals};
use crate::identify::{Weights, fit, relative};
use crate::observation::{Model, Observation};
use crate::records::Records;
use crate::triangle::Triangle;

/// Prediction on motions not used.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Validation {
    pub joints: Vec<JointResidual>,
    /// |tau - W X| / |tau| over all joints.
    pub total: f64,
}

/// Predicts the torques of other records with parameters `x`.
///
/// Fails when a record cannot be read.
pub fn validate<R: Records + ?Sized>(model: &Model, x: &[f64], records: &R) -> Result<Validation, Error> {
    Ok(residuals(model, &Observation::of_records(model, records, None)?.joints(|_| true), x))
}

impl Validation {
    /// The text of validation.yaml: what was reached on each log, by its name.
    pub fn to_yaml(of_logs: &[(String, Validation)]) -> Result<String, Error> {
        let by_name: BTreeMap<&str, &Validation> = of_logs.iter().map(|(name, v)| (name.as_str(), v)).collect();
        serde_yaml::to_string(&by_name).map_err(|e| Error::new(format!("the validation cannot be written: {e}")))
    }
}

impl fmt::Display for Validation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_residuals(f, &self.joints, self.total, None)
    }
}

/// Leaves out each part of the record in turn and predicts it from the others.
pub fn cross_validate(model: &Model, observation: &Observation, weights: Weights) -> Validation {
    let mut squares = vec![(0.0, 0.0, 0); model.n()];
    for k in 0..observation.parts.len() {
        let (solution, _) = fit(&observation.joints(|part| part != k), weights);
        for (sum, triangle) in squares.iter_mut().zip(&observation.parts[k]) {
            let (total, residual) = triangle.squares(&solution.x);
            *sum = (sum.0 + total, sum.1 + residual, sum.2 + triangle.rows);
        }
    }
    of_squares(model, &squares)
}

/// The residual that `x` leaves in triangles by joint.
pub fn residuals(model: &Model, joints: &[Triangle], x: &[f64]) -> Validation {
    let squares = joints.iter().map(|t| {
        let (total, residual) = t.squares(x);
        (total, residual, t.rows)
    });
    of_squares(model, &squares.collect::<Vec<_>>())
}

fn of_squares(model: &Model, squares: &[(f64, f64, usize)]) -> Validation {
    let joint = |(coordinate, &(total, residual, rows)): (&String, &(f64, f64, usize))| JointResidual {
        coordinate: coordinate.clone(),
        rms: (residual / rows.max(1) as f64).sqrt(),
        relative: relative(total, residual),
        rows,
        held_out: None,
    };
    let sum = squares.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    Validation {
        joints: model.regressor.coordinates().iter().zip(squares).map(joint).collect(),
        total: relative(sum.0, sum.1),
    }
}
