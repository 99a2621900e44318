//! The artefact of validation: how well an estimate predicts motions it was not made from.

use std::fmt;

use linear_model::artefact::{self, Kind, Seal};
use linear_model::reference::ModelReference;
use linear_model::regressor::Regressor;
use linear_model::unit::Unit;
use logs::Error;
use serde::{Deserialize, Serialize};

use crate::estimate::artefact::not_zero;
use crate::estimate::residuals::{JointResidual, Residuals, Squares, write_residuals};

/// Prediction on motions that were not used.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Validation {
    /// The robot it is about.
    pub model: ModelReference,
    /// How the predicting estimate was made.
    pub method: String,
    /// Cut-off of the low-pass, Hz; `None` where there was none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_zero")]
    pub cutoff_hz: Option<f64>,
    /// One per coordinate, over all motions.
    pub joints: Vec<JointValidation>,
    /// Relative error over all joints and motions.
    pub total: f64,
    /// One per log, over all joints.
    pub motions: Vec<MotionValidation>,
    /// Torques over time of the first motion, one picture per joint.
    #[serde(default)]
    pub pictures: Vec<TorquePicture>,
    /// Whether the file that it was read from is as rist wrote it.
    #[serde(skip)]
    pub seal: Seal,
}

/// One joint over all motions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointValidation {
    /// Name of the coordinate.
    pub coordinate: String,
    /// |tau - tau_predicted| / |tau|.
    pub relative: f64,
    /// The same without friction, where friction was fitted to these motions.
    pub relative_rigid: Option<f64>,
    /// Root mean square of the residual, in `unit`.
    pub rms: f64,
    /// N m, or N for a joint that slides.
    pub unit: Unit,
    /// Share of autocorrelations outside the 95 % band of white noise, where it was looked at.
    pub not_white: Option<f64>,
    /// FVP FSP FVN FSN, where friction was fitted to these motions; N m s/rad and N m.
    #[serde(default)]
    pub friction: Vec<f64>,
}

/// One motion over all joints.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionValidation {
    /// The log, as the user named it.
    pub name: String,
    /// |tau - tau_predicted| / |tau| over all joints.
    pub relative: f64,
    /// One per joint, where the motion was predicted with everything that the estimate has.
    #[serde(default)]
    pub joints: Vec<JointResidual>,
}

/// The torques of one joint over time, as figure 2 of the paper shows them: s and N m.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TorquePicture {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Instants, s.
    pub t: Vec<f64>,
    /// N m (N), filtered.
    pub measured: Vec<f64>,
    /// N m (N).
    pub predicted: Vec<f64>,
}

impl Validation {
    /// The validation of logs, by name, that an estimate from samples predicts with its own friction.
    pub fn of_logs(
        model: ModelReference,
        method: &str,
        cutoff: Option<f64>,
        regressor: &dyn Regressor,
        logs: &[(String, Residuals)],
    ) -> Validation {
        // The errors of a joint over all logs: the sums of squares add, the errors do not.
        let mut squares = vec![Squares::default(); regressor.coordinates().len()];
        for (_, one) in logs {
            for (sum, s) in squares.iter_mut().zip(&one.squares) {
                *sum = sum.with(s);
            }
        }
        let whole = Residuals::new(regressor, squares);
        let joint = |j: &JointResidual| JointValidation {
            coordinate: j.coordinate.clone(),
            relative: j.relative,
            relative_rigid: None,
            rms: j.rms,
            unit: j.unit,
            not_white: None,
            friction: Vec::new(),
        };
        let motion = |(name, one): &(String, Residuals)| MotionValidation {
            name: name.clone(),
            relative: one.total,
            joints: one.joints.clone(),
        };
        Validation {
            model,
            method: method.into(),
            cutoff_hz: cutoff,
            joints: whole.joints.iter().map(joint).collect(),
            total: whole.total,
            motions: logs.iter().map(motion).collect(),
            pictures: Vec::new(),
            seal: Seal::Whole,
        }
    }

    /// The text of validation.yaml.
    pub fn to_yaml(&self) -> Result<String, Error> {
        artefact::write(Kind::Validation, self.seal, self).map_err(Error::new)
    }

    /// Reads validation.yaml; fails with the line that is not that of a validation.
    pub fn from_yaml(file: &str, text: &str) -> Result<Validation, Error> {
        let validation: Validation = artefact::read(Kind::Validation, text).map_err(|e| Error::at(file, 0, e))?;
        Ok(Validation { seal: Seal::of(text), ..validation })
    }
}

impl fmt::Display for Validation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(said) = self.seal.said() {
            writeln!(f, "{said}")?;
        }
        if self.motions.iter().any(|m| !m.joints.is_empty()) {
            for motion in &self.motions {
                writeln!(f, "{}, predicted by {}:", motion.name, self.method)?;
                write_residuals(f, &motion.joints, Some(motion.relative), None)?;
                writeln!(f)?;
            }
            return Ok(());
        }
        writeln!(
            f,
            "{}: {}, {} motions, {}",
            self.model.name,
            self.method,
            self.motions.len(),
            self.cutoff_hz.map_or_else(|| "no low-pass".into(), |hz| format!("low-pass {hz} Hz"))
        )?;
        writeln!(f, "{:<12} {:>9} {:>12} {:>10} {:>10}", "joint", "error", "no friction", "rms N m", "not white")?;
        let percent = |x: Option<f64>, digits: usize| x.map_or("-".into(), |x| format!("{:.digits$}%", 100.0 * x));
        for j in &self.joints {
            writeln!(
                f,
                "{:<12} {:>9} {:>12} {:>10.4} {:>10}{}",
                j.coordinate,
                percent(Some(j.relative), 2),
                percent(j.relative_rigid, 2),
                j.rms,
                percent(j.not_white, 0),
                if j.unit == Unit::TORQUE { String::new() } else { format!("  (rms in {})", j.unit) }
            )?;
        }
        writeln!(f, "{:<12} {:>8.2}%", "all", 100.0 * self.total)
    }
}
