//! The options of an identification: columns of the log, transmission, filters, friction terms, weights of the rows. The
//! options are read from the YAML file that is given by `--options`.

use linear_model::friction::terms::FrictionTerm;
use linear_model::linear_model::Model;
use linear_model::regressor::Regressor;
use linear_model::yaml;
use logs::{ColumnNames, Error, UnitNames};
use serde::{Deserialize, Serialize};

use crate::estimators::weighted::Weights;
use crate::signals::preparation::Preparation;
use crate::signals::signal_options::{Signal, possible_delay};
use crate::signals::transmission::Transmission;

/// The options of an identification; every field has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Name of the robot, for the report.
    pub model: String,
    /// Names of the columns of a log for each signal.
    pub columns: ColumnNames,
    /// Units of a log without units in its column headers. When options are read, these units are moved to `columns`.
    #[serde(skip_serializing_if = "UnitNames::is_empty")]
    pub units: UnitNames,
    /// Transmission from the logged signals to the joints: ratios, offsets, scales, springs, couplings.
    pub transmission: Transmission,
    /// How signals are filtered and differentiated to states (q, dq, ddq, tau).
    pub signal: Signal,
    /// Friction terms (columns of the regressor) that every joint has.
    pub friction: Vec<FrictionTerm>,
    /// Base parameters of an earlier fit, which predict the load (torque of the bodies) for friction that grows with the load;
    /// empty if no friction term depends on the load.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub friction_load: Vec<f64>,
    /// How rows are weighted: equally, by joint, or robustly.
    pub weights: Weights,
    /// Whether the covariance of the parameters is stored in the estimate.
    pub covariance: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            model: String::new(),
            columns: ColumnNames::default(),
            units: UnitNames::default(),
            transmission: Transmission::default(),
            signal: Signal::default(),
            friction: FrictionTerm::STANDARD.to_vec(),
            friction_load: Vec::new(),
            weights: Weights::Joint,
            covariance: false,
        }
    }
}

impl Options {
    /// Reads options from a YAML file; absent keys keep their defaults. Fails for unknown keys and impossible values.
    pub fn read(path: &std::path::Path) -> Result<Options, Error> {
        let file = path.display().to_string();
        let text = robot::format::read_text(path).map_err(|e| Error::at(&file, e.place.line, e.message))?;
        Options::parse(&file, &text)
    }

    /// Reads options from the YAML text `text`. `file`: name of the file for error messages.
    pub fn parse(file: &str, text: &str) -> Result<Options, Error> {
        let mut options: Options = yaml::read(text).map_err(|e| Error::at(file, 0, e))?;
        if !options.units.is_empty() {
            if !options.columns.units.is_empty() {
                return Err(Error::at(file, 0, "`units` stands next to `columns` and within it: keep one of them"));
            }
            options.columns.units = std::mem::take(&mut options.units);
        }
        possible_delay(options.signal.delay).map_err(|message| Error::at(file, 0, message))?;
        Ok(options)
    }

    /// The linear model of the torques: the regressor with friction and couplings of these options.
    pub fn linear_model<'a>(&'a self, regressor: &'a dyn Regressor) -> Model<'a> {
        self.linear_model_with(regressor, &self.friction)
    }

    /// The linear model of the torques, with `friction` instead of the friction of these options.
    pub fn linear_model_with<'a>(&self, regressor: &'a dyn Regressor, friction: &'a [FrictionTerm]) -> Model<'a> {
        let Transmission { scales, springs, .. } = self.transmission.clone();
        let (scales, springs) = (scales.unwrap_or_default(), springs.unwrap_or_default());
        Model { scales, springs, ..Model::new(regressor, friction, &self.transmission.coupled()) }
    }

    /// How logs are prepared with these options. Rows of a joint at standstill are used only if the model has no dry friction.
    pub fn preparation(&self) -> Preparation {
        let mut signal = self.signal.clone();
        if !self.friction.iter().any(|term| term.is_dry()) {
            signal.standstill.get_or_insert(0.0);
        }
        let friction = self.friction.iter().copied().filter(|term| term.is_bent()).collect();
        Preparation {
            transmission: self.transmission.clone(),
            signal,
            friction,
            load: self.friction_load.clone(),
            content: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_that_cannot_be_is_refused_with_its_file() {
        let parse = |delay: &str| Options::parse("options.yaml", &format!("signal: {{delay: {delay}}}\n"));
        assert_eq!(parse("-0.0205").unwrap().signal.delay, -0.0205);
        for delay in [".nan", "1.0", "-30", ".inf"] {
            let said = parse(delay).unwrap_err().to_string();
            assert!(said.starts_with("options.yaml: a delay of "), "{said}");
            assert!(said.ends_with("seconds between -1 and 1 are expected"), "{said}");
        }
    }
}
