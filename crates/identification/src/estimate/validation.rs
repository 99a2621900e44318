//! Holds the artefact `Validation` (validation.yaml), the file in which rist stores the errors of an estimate on motions that
//! were not used for it. tau: measured torque; tau_predicted: torque that the estimate predicts for the same motion.

use std::fmt;

use linear_model::artefact::{self, ArtefactKind, Checksum};
use linear_model::reference::ModelReference;
use linear_model::regressor::Regressor;
use linear_model::unit::Unit;
use logs::Error;
use serde::{Deserialize, Serialize};

use crate::estimate::artefact::not_zero;
use crate::estimate::residuals::{JointResidual, Residuals, Squares, write_residuals};

/// Errors of predicted torques on motions that were not used for the estimate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Validation {
    /// Name and fingerprint of the model of the robot.
    pub model: ModelReference,
    /// Name of the estimation method.
    pub method: String,
    /// Cut-off of the low-pass filter, Hz; `None` if nothing was filtered.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_zero")]
    pub cutoff_hz: Option<f64>,
    /// Errors of each joint over all motions, one per coordinate.
    pub joints: Vec<JointValidation>,
    /// Relative error over all joints and motions.
    pub total: f64,
    /// Errors of each motion over all joints, one per log.
    pub motions: Vec<MotionValidation>,
    /// Measured and predicted torques over time of the first motion, one plot per joint.
    #[serde(default)]
    pub pictures: Vec<TorquePicture>,
    /// Result of comparing the checksum in the file with the text of the file.
    #[serde(skip)]
    pub checksum: Checksum,
}

/// Errors of one joint over all motions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointValidation {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Relative error |tau - tau_predicted| / |tau|.
    pub relative: f64,
    /// Relative error of the rigid-body torques without friction, if friction was fitted to these motions; otherwise `None`.
    pub relative_rigid: Option<f64>,
    /// Root mean square of the residual, in `unit`.
    pub rms: f64,
    /// Unit of the torque: N m, or N for a prismatic joint.
    pub unit: Unit,
    /// Share of the autocorrelations of the residual that lie outside the 95 % band of white noise; `None` if not computed.
    pub not_white: Option<f64>,
    /// Friction parameters FVP FSP FVN FSN (viscous and Coulomb friction, forward and backward), N m s/rad and N m, if
    /// friction was fitted to these motions; otherwise empty.
    #[serde(default)]
    pub friction: Vec<f64>,
}

/// Errors of one motion over all joints.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionValidation {
    /// Name of the log, as the user gave it.
    pub name: String,
    /// Relative error |tau - tau_predicted| / |tau| over all joints.
    pub relative: f64,
    /// Residual of each joint, if the motion was predicted with all parameters of the estimate including friction; otherwise
    /// empty.
    #[serde(default)]
    pub joints: Vec<JointResidual>,
}

/// Measured and predicted torques of one joint over time, for a plot (figure 2 of the paper of `spectrum::paper`).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TorquePicture {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Times of the samples, s.
    pub t: Vec<f64>,
    /// Measured torque after the low-pass filter, N m (N), one per time.
    pub measured: Vec<f64>,
    /// Predicted torque, N m (N), one per time.
    pub predicted: Vec<f64>,
}

impl Validation {
    /// Makes the validation of an estimate that predicts logs with its own friction parameters. `cutoff`: cut-off of the
    /// low-pass, Hz; `logs`: name and residuals of each log.
    pub fn of_logs(
        model: ModelReference,
        method: &str,
        cutoff: Option<f64>,
        regressor: &dyn Regressor,
        logs: &[(String, Residuals)],
    ) -> Validation {
        // Relative errors of several logs cannot be added. So the sums of squares of each joint are added over all logs.
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
            checksum: Checksum::Whole,
        }
    }

    /// Writes the validation as the text of validation.yaml.
    pub fn to_yaml(&self) -> Result<String, Error> {
        artefact::write(ArtefactKind::Validation, self.checksum, self).map_err(Error::new)
    }

    /// Reads a validation from `text`, the content of validation.yaml. `file`: name of the file, for error messages. Fails if
    /// a line does not belong to a validation.
    pub fn from_yaml(file: &str, text: &str) -> Result<Validation, Error> {
        let validation: Validation =
            artefact::read(ArtefactKind::Validation, text).map_err(|e| Error::at(file, 0, e))?;
        Ok(Validation { checksum: Checksum::of(text), ..validation })
    }
}

impl fmt::Display for Validation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(said) = self.checksum.said() {
            writeln!(f, "{said}")?;
        }
        // For estimates from samples of logs, a table of joints is written for each log.
        if self.motions.iter().any(|m| !m.joints.is_empty()) {
            for motion in &self.motions {
                writeln!(f, "{}, predicted by {}:", motion.name, self.method)?;
                write_residuals(f, &motion.joints, Some(motion.relative), None)?;
                writeln!(f)?;
            }
            return Ok(());
        }
        // For estimates from experiments of a plan, one table of joints over all motions is written.
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
