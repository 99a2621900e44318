//! One experiment of a plan, and what a plan says of a parameter, as plan.yaml has them.

use linear_model::parameter::ParameterId;
use linear_model::unit::Unit;
use serde::{Deserialize, Serialize};

/// One experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedExperiment {
    /// Name by which its log is found: `e01`.
    pub name: String,
    /// Index of the candidate that it runs, where the proof of the plan writes them out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidate: Option<usize>,
    /// Which torques it shows: the word of its kind.
    pub kind: String,
    /// Coordinate that moves fast, or the one that sweeps.
    pub fast: String,
    /// Coordinates that move slowly with it.
    pub slow: Vec<String>,
    /// rad, in the order of the coordinates.
    pub centre: Vec<f64>,
    /// The periodic swing, where it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<PlannedSwing>,
    /// The slow sweep, where it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<PlannedSweep>,
    /// Rank of F with this experiment and those before it.
    pub rank: usize,
    /// log det F that it adds, where F is of full rank without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adds_log_det: Option<f64>,
    /// Parameters that become identifiable with it.
    pub adds: Vec<ParameterId>,
}

/// A motion that a plan was chosen from; its keys are those of an experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CandidateMotion {
    /// Which torques it shows: the word of its kind.
    pub kind: String,
    /// Coordinate that moves fast, or the one that sweeps.
    pub fast: String,
    /// Coordinates that move slowly with it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub slow: Vec<String>,
    /// rad, in the order of the coordinates.
    pub centre: Vec<f64>,
    /// The periodic swing, where it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<PlannedSwing>,
    /// The slow sweep, where it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<PlannedSweep>,
}

/// A periodic swing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedSwing {
    /// `bang_bang` or `smooth`.
    pub profile: String,
    /// Samples of one period.
    pub period_samples: usize,
    /// Periods before the motion is periodic.
    pub transient_periods: usize,
    /// Periods that are used.
    pub periods: usize,
    /// rad, in the order of the coordinates.
    pub half_range: Vec<f64>,
}

/// A slow sweep there and back.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedSweep {
    /// rad between the ends.
    pub range_rad: f64,
    /// rad/s between the ends.
    pub velocity_rad_per_s: f64,
    /// rad/s^2 at the ends.
    pub acceleration_rad_per_s2: f64,
    /// s after each ramp that are dropped while the controller settles.
    pub settling_s: f64,
}

/// The prediction of a plan for one parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictedParameter {
    /// The base parameter.
    #[serde(rename = "name")]
    pub id: ParameterId,
    /// SI unit of its deviation.
    pub unit: Unit,
    /// Standard deviation from the paper's rows, in the unit; none: the plan leaves it unidentifiable.
    pub sigma: Option<f64>,
}

/// Refuses names that do not lead to one file each in the directory of the logs, since these files are written.
pub fn check_names(experiments: &[PlannedExperiment]) -> Result<(), String> {
    let files = |e: &PlannedExperiment| [e.name.to_lowercase(), format!("{}_loaded", e.name.to_lowercase())];
    for (i, e) in experiments.iter().enumerate() {
        let is_letter = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
        if e.name.is_empty() || e.name.starts_with('.') || !e.name.chars().all(is_letter) {
            return Err(format!(
                "experiment {}: `{}` is no name of a file in the directory of the logs: letters, digits, `-`, `_` and \
                 `.` are",
                i + 1,
                e.name.escape_debug()
            ));
        }
        let number = e.name.to_lowercase();
        if number.strip_prefix('v').is_some_and(|n| !n.is_empty() && n.chars().all(|c| c.is_ascii_digit())) {
            return Err(format!("experiment {}: {} is the name of a motion for validation", i + 1, e.name));
        }
        let taken = |other: &&PlannedExperiment| files(other).iter().any(|name| files(e).contains(name));
        if experiments[..i].iter().find(taken).is_some() {
            return Err(format!("experiment {}: the name {} is taken by one before it", i + 1, e.name));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_one_file() {
        let of = |names: &[&str]| {
            let named = |name: &&str| PlannedExperiment { name: name.to_string(), ..PlannedExperiment::default() };
            check_names(&names.iter().map(named).collect::<Vec<_>>())
        };
        of(&["e01", "e02", "shoulder 2.b"]).unwrap();
        for bad in ["../../escaped", "/abs", "", ".", "..", "a\\b", "a\nb", "a:b", "a\0"] {
            assert!(of(&["e01", bad]).unwrap_err().contains("experiment 2"), "{bad}");
        }
        assert!(of(&["v01"]).unwrap_err().contains("validation"));
        for pair in [["e01", "e01"], ["e01", "E01"], ["e01", "e01_loaded"]] {
            assert!(of(&pair).unwrap_err().contains("taken"), "{pair:?}");
        }
    }
}
