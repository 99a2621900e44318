//! One experiment of a plan, and what a plan says of a parameter, as plan.yaml has them.

use serde::{Deserialize, Serialize};

use crate::model::parameter::ParameterId;
use crate::model::unit::Unit;

/// One experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedExperiment {
    pub name: String,
    pub kind: String,
    /// Coordinates that move fast, and slowly.
    pub fast: String,
    pub slow: Vec<String>,
    /// rad, in the order of the coordinates.
    pub centre: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<PlannedSwing>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<PlannedSweep>,
    /// With this experiment and those before it.
    pub rank: usize,
    /// log det F that it adds, where F is of full rank without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adds_log_det: Option<f64>,
    /// Parameters that become identifiable with it.
    pub adds: Vec<ParameterId>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedSwing {
    /// `bang_bang` or `smooth`.
    pub profile: String,
    pub period_samples: usize,
    pub transient_periods: usize,
    pub periods: usize,
    /// rad, in the order of the coordinates.
    pub half_range: Vec<f64>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedSweep {
    pub range_rad: f64,
    pub velocity_rad_per_s: f64,
    pub acceleration_rad_per_s2: f64,
    pub settling_s: f64,
}

/// What the plan will say about a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictedParameter {
    #[serde(rename = "name")]
    pub id: ParameterId,
    pub unit: Unit,
    /// Standard deviation from the paper's rows, in the unit; none: the plan leaves it unidentifiable.
    pub sigma: Option<f64>,
}
