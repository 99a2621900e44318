//! One experiment of a plan, and the prediction for one parameter, in the form of plan.yaml.

use linear_model::parameter::ParameterId;
use linear_model::unit::Unit;
use serde::{Deserialize, Serialize};

/// One experiment of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedExperiment {
    /// Name of the experiment and of its log file: `e01`.
    pub name: String,
    /// Index of the candidate that the experiment runs. `None` if the proof of the plan does not list candidates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidate: Option<usize>,
    /// Name of the kind of motion, that is, of the torques that it excites.
    pub kind: String,
    /// Name of the fast coordinate, or of the coordinate that sweeps.
    pub fast: String,
    /// Names of the slow coordinates.
    pub slow: Vec<String>,
    /// Centre of the motion, rad (m), in the order of the coordinates.
    pub centre: Vec<f64>,
    /// The swing; `None` if the motion is a sweep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<PlannedSwing>,
    /// The sweep; `None` if the motion is a swing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<PlannedSweep>,
    /// Rank of the information matrix F, summed over this experiment and all before it.
    pub rank: usize,
    /// Increase of log det F by this experiment. `None` if F does not have full rank without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adds_log_det: Option<f64>,
    /// Parameters that this experiment makes identifiable.
    pub adds: Vec<ParameterId>,
}

/// A candidate motion of a plan. Its keys equal the keys of an experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CandidateMotion {
    /// Name of the kind of motion, that is, of the torques that it excites.
    pub kind: String,
    /// Name of the fast coordinate, or of the coordinate that sweeps.
    pub fast: String,
    /// Names of the slow coordinates.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub slow: Vec<String>,
    /// Centre of the motion, rad (m), in the order of the coordinates.
    pub centre: Vec<f64>,
    /// The swing; `None` if the motion is a sweep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<PlannedSwing>,
    /// The sweep; `None` if the motion is a swing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<PlannedSweep>,
}

/// A periodic swing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedSwing {
    /// Profile: `bang_bang` or `smooth`.
    pub profile: String,
    /// Number of samples of one period.
    pub period_samples: usize,
    /// Number of periods before the motion counts as periodic.
    pub transient_periods: usize,
    /// Number of periods that are used.
    pub periods: usize,
    /// (B - A)/2 of each coordinate, rad (m), in the order of the coordinates.
    pub half_range: Vec<f64>,
}

/// A slow sweep there and back.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedSweep {
    /// Distance between the ends, rad (m).
    pub range_rad: f64,
    /// Constant velocity between the ends, rad/s (m/s).
    pub velocity_rad_per_s: f64,
    /// Acceleration of the ramps at the ends, rad/s^2 (m/s^2).
    pub acceleration_rad_per_s2: f64,
    /// Time after each ramp whose samples are dropped while the controller settles, s.
    pub settling_s: f64,
}

/// The prediction of a plan for one parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictedParameter {
    /// The base parameter.
    #[serde(rename = "name")]
    pub id: ParameterId,
    /// SI unit of its standard deviation.
    pub unit: Unit,
    /// Predicted standard deviation in `unit`. `None`: the parameter is not identifiable with the plan.
    pub sigma: Option<f64>,
}

/// Fails if the names do not give each experiment its own file in the directory of the logs, because files are written there.
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
