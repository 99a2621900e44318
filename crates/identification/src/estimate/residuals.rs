//! Residuals of a model, for each joint and in total.
//!
//! For joint j: relative_j = |tau_j - W_j X| / |tau_j| over the rows of the joint. tau_j is the torque as measured, including
//! springs and scales that the transmission removes before the fit. The total is the same ratio over the rows of all joints.
//!
//! N m and N are not added. If a robot has revolute and prismatic joints, the total is the root of the mean of the squared
//! ratios of both kinds, weighted by their numbers of rows.

use std::fmt;

use linear_model::linear_model::Model;
use linear_model::regressor::Regressor;
use linear_model::unit::Unit;
use serde::{Deserialize, Serialize};

use crate::estimators::weighted::relative;

/// The residual of one joint: the torque that the model does not explain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointResidual {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Root mean square of the residual, in `unit`.
    pub rms: f64,
    /// Unit of the torque: N m, or N for a prismatic joint.
    #[serde(default = "torque")]
    pub unit: Unit,
    /// Relative residual |tau_j - W_j X| / |tau_j|.
    pub relative: f64,
    /// Number of rows of the joint.
    pub rows: usize,
    /// Relative error of cross-validation: each tenth of the record is predicted by a fit to the other tenths. `None` if not
    /// computed.
    #[serde(default)]
    pub held_out: Option<f64>,
    /// Bandwidth, Hz: 95 % of the energy of the velocity is below this frequency. `None` if unknown.
    #[serde(default)]
    pub f95: Option<f64>,
    /// Autocorrelation time of the residual, s (`estimate::autocorrelation`); `None` if unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory: Option<f64>,
}

fn torque() -> Unit {
    Unit::TORQUE
}

/// Sums of squares of the measured torque and of the residual of one joint, and the number of rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Squares {
    /// Squared torque |tau_j|^2, (N m)^2 or N^2.
    pub torque: f64,
    /// Squared residual |tau_j - W_j X|^2, (N m)^2 or N^2.
    pub residual: f64,
    /// Number of rows of the joint.
    pub rows: usize,
}

impl Squares {
    /// Adds one row with the torque `torque` and the residual `left`, N m (N).
    pub(crate) fn add(&mut self, torque: f64, left: f64) {
        self.torque += torque * torque;
        self.residual += left * left;
        self.rows += 1;
    }

    /// The sums over the rows of both `self` and `other`.
    pub(crate) fn with(self, other: &Squares) -> Squares {
        let Squares { torque, residual: left, rows } = *other;
        Squares { torque: self.torque + torque, residual: self.residual + left, rows: self.rows + rows }
    }

    /// Makes the sums of squares of joint j in the unit of its measured torque. `torque`, `left`: sums of squared torques and
    /// residuals after the division of the torques by the scale of the joint.
    pub(crate) fn of(model: &Model, j: usize, rows: usize, torque: f64, left: f64) -> Squares {
        let square = model.scale(j).powi(2);
        Squares { torque: square * torque, residual: square * left, rows }
    }
}

/// Residuals of all joints, and in total.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Residuals {
    /// Residual of each joint, one per coordinate.
    pub joints: Vec<JointResidual>,
    /// Relative residual |tau - W X| / |tau| over all joints, without a unit.
    pub total: f64,
    /// Sums of squares from which `joints` and `total` were computed, one per joint.
    pub squares: Vec<Squares>,
}

impl Residuals {
    /// Computes the residuals from the sums of squares, one per coordinate of the regressor.
    pub fn new(regressor: &dyn Regressor, squares: Vec<Squares>) -> Residuals {
        let joint = |(j, s): (usize, &Squares)| JointResidual {
            coordinate: regressor.coordinates()[j].clone(),
            rms: (s.residual / s.rows.max(1) as f64).sqrt(),
            unit: Unit::TORQUE.along(regressor.is_prismatic(j)),
            relative: relative(s.torque, s.residual),
            rows: s.rows,
            held_out: None,
            f95: None,
            memory: None,
        };
        let joints: Vec<JointResidual> = squares.iter().enumerate().map(joint).collect();
        Residuals { total: total(&joints, &squares), joints, squares }
    }
}

/// Relative residual |tau - W X| / |tau| over all joints. For revolute and prismatic joints together: root of the mean of the
/// two squared relative residuals, weighted by rows.
fn total(joints: &[JointResidual], squares: &[Squares]) -> f64 {
    let of = |unit: Unit| {
        let own = joints.iter().zip(squares).filter(|(joint, _)| joint.unit == unit).map(|(_, squares)| squares);
        own.fold(Squares::default(), |a, s| a.with(s))
    };
    let kinds = [false, true].map(|slides| of(Unit::TORQUE.along(slides))).into_iter().filter(|kind| kind.rows > 0);
    let kinds: Vec<Squares> = kinds.collect();
    let error = |kind: &Squares| relative(kind.torque, kind.residual);
    match kinds.as_slice() {
        [one] => error(one),
        _ => {
            let rows: usize = kinds.iter().map(|kind| kind.rows).sum();
            let weighted = |kind: &Squares| kind.rows as f64 / rows.max(1) as f64 * error(kind).powi(2);
            kinds.iter().map(weighted).sum::<f64>().sqrt()
        }
    }
}

impl fmt::Display for Residuals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_residuals(f, &self.joints, Some(self.total), None)
    }
}

/// Writes a table of the residuals with one line per joint. `held_out`: relative error of cross-validation over all joints,
/// if known.
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
    // If all joints have the same unit, the unit is written in the head of the column. Otherwise the unit follows each number.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;

    /// The total does not depend on the unit of force: it is equal if the force of a prismatic joint is in mN.
    #[test]
    fn the_total_has_no_unit() {
        let turns = Residuals::new(&Pendulum::new(), vec![Squares::default()]).joints.swap_remove(0);
        let slides = JointResidual { unit: Unit::TORQUE.along(true), ..turns.clone() };
        let squares = |scale: f64| {
            [
                Squares { torque: 100.0, residual: 4.0, rows: 30 },
                Squares { torque: scale, residual: 0.25 * scale, rows: 10 },
            ]
        };
        let mixed = [1.0, 1e6].map(|scale| total(&[turns.clone(), slides.clone()], &squares(scale)));
        let expected = (0.75_f64 * 0.04 + 0.25 * 0.25).sqrt();
        assert!(mixed.iter().all(|total| (total - expected).abs() < 1e-15), "{mixed:?} {expected}");
        // Two joints with the same unit are summed before the ratio is computed.
        assert_eq!(total(&[turns.clone(), turns], &squares(100.0)), (29.0_f64 / 200.0).sqrt());
        assert_eq!(total(&[], &[]), 0.0);
    }
}
