//! One experiment of a plan, and the prediction for one parameter, as plan.yaml contains them.
//!
//! A swing is a periodic motion of a fast joint between two positions, possibly together with slow joints. A sweep is a slow
//! motion of one joint there and back. F: information matrix of the experiments up to and including this one.

use linear_model::parameter::ParameterId;
use linear_model::unit::Unit;
use serde::{Deserialize, Serialize};

/// One experiment of a plan, as plan.yaml contains it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedExperiment {
    /// Name of the experiment and of its log file: `e01`.
    pub name: String,
    /// Index of the candidate that the experiment runs. `None`: the plan has no proof, so the file lists no candidates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidate: Option<usize>,
    /// Name of the kind of motion, after the torques that it excites, such as `inertial`.
    pub kind: String,
    /// Name of the fast coordinate; in a slow sweep, name of the coordinate that moves.
    pub fast: String,
    /// Names of the slow coordinates.
    pub slow: Vec<String>,
    /// Position of each coordinate, rad (m): middle of the motion if it moves, constant position if it is locked.
    pub centre: Vec<f64>,
    /// The swing (periodic motion); `None` if the motion is a sweep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<PlannedSwing>,
    /// The sweep (slow motion there and back); `None` if the motion is a swing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<PlannedSweep>,
    /// Rank of the information matrix F of this experiment and all before it together.
    pub rank: usize,
    /// Increase of log det F by this experiment; F: information matrix of all experiments up to this one. `None`: F does not have
    /// full rank without this experiment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adds_log_det: Option<f64>,
    /// Parameters that become identifiable by this experiment, given the experiments before it.
    pub adds: Vec<ParameterId>,
}

/// A candidate motion of a plan, as plan.yaml contains it. Its keys equal the keys of an experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CandidateMotion {
    /// Name of the kind of motion, after the torques that it excites, such as `inertial`.
    pub kind: String,
    /// Name of the fast coordinate; in a slow sweep, name of the coordinate that moves.
    pub fast: String,
    /// Names of the slow coordinates.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub slow: Vec<String>,
    /// Position of each coordinate, rad (m): middle of the motion if it moves, constant position if it is locked.
    pub centre: Vec<f64>,
    /// The swing (periodic motion); `None` if the motion is a sweep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<PlannedSwing>,
    /// The sweep (slow motion there and back); `None` if the motion is a swing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<PlannedSweep>,
}

/// A periodic swing between two positions, as plan.yaml contains it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedSwing {
    /// Profile: `bang_bang` or `smooth`.
    pub profile: String,
    /// Number of samples of one period.
    pub period_samples: usize,
    /// Number of periods that run before the record starts, so that transients decay.
    pub transient_periods: usize,
    /// Number of recorded periods, which an identification uses.
    pub periods: usize,
    /// Half of the distance between the two ends of the swing (rad or m) in the order of the coordinates; 0: locked.
    pub half_range: Vec<f64>,
}

/// A slow sweep of one joint there and back, as plan.yaml contains it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlannedSweep {
    /// Distance between the ends, rad (m).
    pub range_rad: f64,
    /// Constant velocity between the ends, rad/s (m/s).
    pub velocity_rad_per_s: f64,
    /// Acceleration of the ramps at the ends, rad/s^2 (m/s^2).
    pub acceleration_rad_per_s2: f64,
    /// Time after each ramp whose samples are not used, because the controller settles, s.
    pub settling_s: f64,
}

/// The prediction of a plan for one base parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictedParameter {
    /// Name of the base parameter.
    #[serde(rename = "name")]
    pub id: ParameterId,
    /// SI unit of the parameter and of its standard deviation.
    pub unit: Unit,
    /// Predicted standard deviation in `unit`. `None`: the parameter is not identifiable with the plan.
    pub sigma: Option<f64>,
}

/// Fails if the name of an experiment cannot be the name of its own log file in the directory of the logs. A name may not lead
/// out of that directory or collide with other files there.
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
