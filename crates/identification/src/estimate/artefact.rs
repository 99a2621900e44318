//! What was identified, how well, and what the data cannot tell.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::estimate::options::Options;
use logs::Error;

/// Identified parameters with their uncertainty and the residual they leave.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Estimate {
    /// Name of the robot.
    pub model: String,
    /// Of the base regressor it was made with; empty where it is not kept.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub fingerprint: String,
    /// How it was estimated, in words.
    pub method: String,
    pub logs: Vec<String>,
    pub parameters: Vec<Identified>,
    pub joints: Vec<JointResidual>,
    /// |tau - W X| / |tau| over all joints.
    pub total: f64,
    /// `total` on tenths of the record predicted from the others.
    pub cross_validation: Option<f64>,
    /// Of the columns scaled to unit norm.
    pub condition_number: f64,
    pub rank: usize,
    /// Rows of all joints.
    pub rows: usize,
    /// Hz.
    pub cutoff: f64,
    /// What the data cannot tell, in sentences.
    pub remarks: Vec<String>,
    /// What it was made with, so that other logs can be predicted alike; absent for estimates of experiments.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub options: Option<Options>,
    /// sigma_i sigma_j rho_ij, row by row, the parameters in their order; empty when not asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<Vec<f64>>,
}

/// One parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Identified {
    pub name: String,
    pub unit: String,
    /// None: not identifiable from these data.
    pub value: Option<f64>,
    /// Standard deviation for white noise, in the unit of the value.
    pub sigma: Option<f64>,
    /// Standard deviation that allows for residuals that stay the same for a while.
    #[serde(default)]
    pub robust_sigma: Option<f64>,
    /// 100 sigma / |value|, the larger sigma of the two, %.
    pub relative_sigma: Option<f64>,
    pub status: Status,
}

/// Whether a value can be used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    #[default]
    Identified,
    /// Zero is within two sigma.
    NotSignificant,
    /// Determined by so little motion that errors of the model, not noise, decide it.
    Weak,
    /// The data say nothing about it.
    NotIdentifiable,
}

/// What the model leaves unexplained of the torque of one joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointResidual {
    pub coordinate: String,
    /// Root mean square, N m (N).
    pub rms: f64,
    /// |tau_j - W_j X| / |tau_j|.
    pub relative: f64,
    pub rows: usize,
    /// `relative` on tenths of the record predicted from the others.
    #[serde(default)]
    pub held_out: Option<f64>,
    /// Hz: 95 % of the energy of the velocity lies below.
    #[serde(default)]
    pub f95: Option<f64>,
}

impl Estimate {
    /// The value of a parameter by its name; `None` where it is not identifiable or not there.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|p| p.name == name)?.value
    }

    /// How many correlated samples are worth one: the median of (robust sigma / white sigma)^2, at least 1.
    pub fn discount(&self) -> f64 {
        let ratio = |p: &Identified| Some((p.robust_sigma? / p.sigma?).powi(2)).filter(|r| r.is_finite());
        let mut ratios: Vec<f64> = self.parameters.iter().filter_map(ratio).collect();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied().unwrap_or(1.0).max(1.0)
    }

    /// The text of estimate.yaml.
    pub fn to_yaml(&self) -> Result<String, Error> {
        serde_yaml::to_string(self).map_err(|e| Error::new(format!("the estimate cannot be written: {e}")))
    }

    /// Reads estimate.yaml; fails with the line of what is no estimate.
    pub fn from_yaml(file: &str, text: &str) -> Result<Estimate, Error> {
        serde_yaml::from_str(text).map_err(|e| Error::at(file, 0, format!("this is no estimate: {e}")))
    }
}

/// What is left of the torque of each joint and of all, `held_out` of them all where it is known.
pub(crate) fn write_residuals(
    f: &mut fmt::Formatter<'_>,
    joints: &[JointResidual],
    total: f64,
    held_out: Option<f64>,
) -> fmt::Result {
    let width = joints.iter().map(|j| j.coordinate.chars().count()).max().unwrap_or(0).max(5);
    let column = |text: &str| if held_out.is_some() { format!("  {text:>8}") } else { String::new() };
    let shown = |x: Option<f64>| column(&x.map_or(String::new(), |x| format!("{x:.4}")));
    let frequencies = joints.iter().any(|j| j.f95.is_some());
    write!(f, "{:<width$}  {:>10}  {:>8}{}  {:>8}", "joint", "rms N m", "relative", column("held out"), "rows")?;
    writeln!(f, "{}", if frequencies { "  95 % below, Hz" } else { "" })?;
    for j in joints {
        let out = shown(j.held_out);
        write!(f, "{:<width$}  {:>10.4}  {:>8.4}{out}  {:>8}", j.coordinate, j.rms, j.relative, j.rows)?;
        writeln!(f, "{}", j.f95.map_or(String::new(), |hz| format!("  {hz:>14.3}")))?;
    }
    writeln!(f, "{:<width$}  {:>10}  {total:>8.4}{}", "total", "", shown(held_out))
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}, cut-off {:.2} Hz, {} rows", self.model, self.method, self.cutoff, self.rows)?;
        let width = self.parameters.iter().map(|p| p.name.chars().count()).max().unwrap_or(0).max(9);
        let robust = self.parameters.iter().any(|p| p.robust_sigma.is_some());
        write!(f, "{:<width$}  {:>12}  {:>10}", "parameter", "value", "sigma")?;
        writeln!(f, "{}  {:>9}  unit", if robust { "      robust" } else { "" }, "sigma %")?;
        for p in &self.parameters {
            write!(f, "{:<width$}  ", p.name)?;
            let Some(value) = p.value else {
                writeln!(f, "not identifiable")?;
                continue;
            };
            write!(f, "{value:>12.5}  {:>10.5}", p.sigma.unwrap_or(f64::NAN))?;
            if robust {
                write!(f, "  {:>10.5}", p.robust_sigma.unwrap_or(f64::NAN))?;
            }
            let status = match p.status {
                Status::NotSignificant => "  (zero within two sigma)",
                Status::Weak => "  (weak: little motion decides it)",
                Status::Identified | Status::NotIdentifiable => "",
            };
            writeln!(f, "  {:>9.2}  {}{status}", p.relative_sigma.unwrap_or(f64::NAN), p.unit)?;
        }
        writeln!(f)?;
        write_residuals(f, &self.joints, self.total, self.cross_validation)?;
        writeln!(
            f,
            "condition number {:.1} (columns scaled), rank {} of {}",
            self.condition_number,
            self.rank,
            self.parameters.len()
        )?;
        self.remarks.iter().try_for_each(|remark| writeln!(f, "{remark}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate() -> Estimate {
        Estimate {
            model: "arm".into(),
            parameters: vec![
                Identified {
                    name: "ZZR1".into(),
                    unit: "kg m^2".into(),
                    value: Some(1.25),
                    sigma: Some(0.0125),
                    relative_sigma: Some(1.0),
                    ..Identified::default()
                },
                Identified { name: "FV1".into(), status: Status::NotIdentifiable, ..Identified::default() },
            ],
            joints: vec![JointResidual {
                coordinate: "q1".into(),
                rms: 0.1,
                relative: 0.05,
                rows: 10,
                ..JointResidual::default()
            }],
            condition_number: f64::INFINITY,
            rank: 1,
            remarks: vec!["FV1 is not identifiable from this log: joint q1 moves 0.000 rad".into()],
            ..Estimate::default()
        }
    }

    #[test]
    fn yaml_round_trip() {
        let text = estimate().to_yaml().unwrap();
        assert_eq!(Estimate::from_yaml("estimate.yaml", &text).unwrap(), estimate(), "{text}");
        assert!(
            Estimate::from_yaml("estimate.yaml", "parameters: 3").unwrap_err().to_string().contains("estimate.yaml")
        );
    }

    #[test]
    fn the_table_hides_no_gap() {
        let text = estimate().to_string();
        assert!(text.contains("not identifiable") && text.contains("joint q1 moves 0.000 rad"), "{text}");
        assert_eq!(estimate().value("FV1"), None);
    }
}
