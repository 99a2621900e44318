//! The residuals of a model by joint: the torque that it leaves unexplained.
//!
//! relative_j = |tau_j - W_j X| / |tau_j| over the rows of joint j; the total over the rows of all joints.

use std::fmt;

use linear_model::regressor::Regressor;
use linear_model::unit::Unit;
use serde::{Deserialize, Serialize};

use crate::estimators::weighted::relative;

/// The residual of one joint: the torque that the model leaves unexplained.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointResidual {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Root mean square, in `unit`.
    pub rms: f64,
    /// N m, or N for a joint that slides.
    #[serde(default = "torque")]
    pub unit: Unit,
    /// |tau_j - W_j X| / |tau_j|.
    pub relative: f64,
    /// Rows of the joint.
    pub rows: usize,
    /// `relative` on tenths of the record predicted from the others.
    #[serde(default)]
    pub held_out: Option<f64>,
    /// Frequency below which 95 % of the energy of the velocity lies, Hz.
    #[serde(default)]
    pub f95: Option<f64>,
    /// Time after which the residual no longer resembles itself, s (`estimate::autocorrelation`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory: Option<f64>,
}

fn torque() -> Unit {
    Unit::TORQUE
}

/// Squares of the torque and of its residual, and the number of rows behind them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Squares {
    /// |tau_j|^2.
    pub torque: f64,
    /// Square of what is left of it.
    pub left: f64,
    /// Rows of the joint.
    pub rows: usize,
}

/// Residuals of all joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Residuals {
    /// One per coordinate.
    pub joints: Vec<JointResidual>,
    /// |tau - W X| / |tau| over all joints.
    pub total: f64,
    /// The squares behind both, one per joint.
    pub squares: Vec<Squares>,
}

impl Residuals {
    /// From the squares of each coordinate of the regressor.
    pub fn new(regressor: &dyn Regressor, squares: Vec<Squares>) -> Residuals {
        let joint = |(j, s): (usize, &Squares)| JointResidual {
            coordinate: regressor.coordinates()[j].clone(),
            rms: (s.left / s.rows.max(1) as f64).sqrt(),
            unit: Unit::TORQUE.along(regressor.is_prismatic(j)),
            relative: relative(s.torque, s.left),
            rows: s.rows,
            held_out: None,
            f95: None,
            memory: None,
        };
        let (torque, left) = squares.iter().fold((0.0, 0.0), |a, s| (a.0 + s.torque, a.1 + s.left));
        Residuals { joints: squares.iter().enumerate().map(joint).collect(), total: relative(torque, left), squares }
    }
}

impl fmt::Display for Residuals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_residuals(f, &self.joints, Some(self.total), None)
    }
}

/// Writes the table of joints; `held_out` is the error of all joints on the parts left out, where it is known.
pub(crate) fn write_residuals(
    f: &mut fmt::Formatter<'_>,
    joints: &[JointResidual],
    total: Option<f64>,
    held_out: Option<f64>,
) -> fmt::Result {
    let width = joints.iter().map(|j| j.coordinate.chars().count()).max().unwrap_or(0).max(5);
    let column = |text: &str| if held_out.is_some() { format!("  {text:>8}") } else { String::new() };
    let shown = |x: Option<f64>| column(&x.map_or(String::new(), |x| format!("{x:.4}")));
    let frequencies = joints.iter().any(|j| j.f95.is_some());
    // One unit stands in the head of the column, two stand behind the numbers.
    let head = joints.first().map_or(Unit::TORQUE, |j| j.unit);
    let mixed = joints.iter().any(|j| j.unit != head);
    let unit = |unit: Unit| if mixed { format!(" {unit:<3}") } else { String::new() };
    let rms = if mixed { "rms    ".to_string() } else { format!("rms {head}") };
    write!(f, "{:<width$}  {rms:>10}  {:>8}{}  {:>8}", "joint", "relative", column("held out"), "rows")?;
    writeln!(f, "{}", if frequencies { "  95 % below, Hz" } else { "" })?;
    for j in joints {
        let out = shown(j.held_out);
        let unit = unit(j.unit);
        write!(f, "{:<width$}  {:>10.4}{unit}  {:>8.4}{out}  {:>8}", j.coordinate, j.rms, j.relative, j.rows)?;
        writeln!(f, "{}", j.f95.map_or(String::new(), |hz| format!("  {hz:>14.3}")))?;
    }
    let none = if mixed { " ".repeat(14) } else { " ".repeat(10) };
    match total {
        Some(total) => writeln!(f, "{:<width$}  {none}  {total:>8.4}{}", "total", shown(held_out)),
        None => Ok(()),
    }
}
