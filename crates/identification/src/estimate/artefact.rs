//! Holds the artefact `Estimate` (estimate.yaml), the file in which rist stores the result of an identification: parameters
//! with standard deviations, residuals, and the combinations of parameters that are not identifiable.
//!
//! tau: measured torques; W: regressor (observation matrix), one column per parameter; X: parameters; sigma: standard deviation
//! of a parameter; a direction is a combination of parameters.

use std::collections::BTreeSet;
use std::fmt;

use linear_model::artefact::{self, ArtefactKind, Checksum};
use linear_model::description_options::DescriptionOptions;
use linear_model::parameter::ParameterId;
use linear_model::reference::ModelReference;
use logs::Error;
use serde::{Deserialize, Serialize};

use crate::estimate::directions::Direction;
use crate::estimate::identified::{Identified, Status};
use crate::estimate::options::Options;
use crate::estimate::residuals::{JointResidual, write_residuals};
use crate::estimate::torque_error::TorqueError;

/// Identified parameters with their standard deviations and residuals.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Estimate {
    /// Name of the robot.
    pub model: String,
    /// Fingerprint (hash) of the base regressor that the estimate was made with; `None` if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
    /// Options for reading the robot description (values of symbols, arguments of xacro); `None` if no options were used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<DescriptionOptions>,
    /// Name of the estimation method, for reports.
    pub method: String,
    /// Names of the fitted log files, as the user gave them.
    pub logs: Vec<String>,
    /// The estimated parameters in this order: base parameters, friction, couplings, drive gains.
    pub parameters: Vec<Identified>,
    /// Residual of the torque of each joint, one entry per coordinate.
    pub joints: Vec<JointResidual>,
    /// Relative error |tau - W X| / |tau| over all joints; `None` if no torques were fitted.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "not_zero")]
    pub total: Option<f64>,
    /// Relative error |tau - W X| / |tau| in cross-validation: each tenth of the record is predicted with parameters that are
    /// fitted to the other tenths. If experiments of a plan are fitted, each experiment is left out instead. `None` if not
    /// computed.
    pub cross_validation: Option<f64>,
    /// Relative error of each tenth of the record in cross-validation, in the order of time, log after log; empty if not
    /// computed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tenths: Vec<f64>,
    /// Condition number of the regressor W with columns scaled to unit norm; `None` if the method has no such matrix.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "not_zero")]
    pub condition_number: Option<f64>,
    /// Whether an iterative method converged; `None` for methods without iterations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settled: Option<bool>,
    /// Chi^2 per degree of freedom (rows - unknowns) of the method RIST-MH. The noise of a row is measured from the
    /// differences between periods of the motion. `None` for other methods, or without such a measurement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chi_square_per_freedom: Option<f64>,
    /// Errors of the predicted torques that follow from the covariance of the parameters, one entry per use (gravity
    /// compensation, feedforward). If experiments of a plan are fitted: errors of the rigid-body torques, without friction.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub torque_errors: Vec<TorqueError>,
    /// Rank: number of linear combinations of the parameters that the data determine.
    pub rank: usize,
    /// Linear combinations of parameters with the smallest singular values (least determined), the smallest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub directions: Vec<Direction>,
    /// Number of rows (equations) of all joints together.
    pub rows: usize,
    /// Cut-off of the low-pass filter, Hz; `None` if nothing was filtered.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "not_zero")]
    pub cutoff: Option<f64>,
    /// Sentences for the user on the data, and on parameters that are not identifiable.
    pub remarks: Vec<String>,
    /// Sentences that state evidence against the model; empty if there is no such evidence. With such evidence, the trust in
    /// the estimate is at most "with care".
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
    /// Reasons not to use the estimate, from the verdict of its identification; empty if the verdict was not "no".
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub refusal: Vec<String>,
    /// Options of the identification; other logs are prepared with the same options before they are predicted. `None` for an
    /// estimate from experiments of a plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub options: Option<Options>,
    /// Covariance matrix of the parameters, sigma_i sigma_j rho_ij, row by row, in the order of `parameters`; empty if not
    /// requested.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<Vec<f64>>,
    /// Result of comparing the checksum in the file with the text of the file. The result shows whether the file was changed
    /// after rist wrote it.
    #[serde(skip)]
    pub checksum: Checksum,
    /// Number of parameters. This entry is the last line of the file, so a file without this line was cut short. `None` in
    /// memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameter_count: Option<usize>,
}

impl Estimate {
    /// Name and fingerprint of the model that the estimate was made with; `None` without a fingerprint.
    pub fn made_with(&self) -> Option<ModelReference> {
        Some(ModelReference { name: self.model.clone(), fingerprint: self.fingerprint.clone()? })
    }

    /// Inflates the standard deviation of each parameter by a possible change of the parameter: sigma becomes sqrt(sigma^2 +
    /// shift(c)^2). c: index of the parameter; `shift(c)`: the change, in the unit of the parameter. Row and column c of the
    /// covariance are multiplied by (new sigma / old sigma), so correlations do not change.
    pub(crate) fn inflate_sigma(&mut self, shift: impl Fn(usize) -> f64) {
        let mut ratios = Vec::new();
        for (c, parameter) in self.parameters.iter_mut().enumerate() {
            let (sigma, shift) = (parameter.sigma.unwrap_or(0.0), shift(c));
            *parameter = parameter.clone().widened(sigma.hypot(shift));
            ratios.push(if sigma > 0.0 { sigma.hypot(shift) / sigma } else { 1.0 });
        }
        for (i, row) in self.covariance.iter_mut().enumerate() {
            row.iter_mut().zip(&ratios).for_each(|(entry, ratio)| *entry *= ratio * ratios[i]);
        }
    }

    /// The identified value of a parameter; `None` if the parameter is not identifiable or not part of the estimate.
    pub fn value(&self, id: &ParameterId) -> Option<f64> {
        self.parameters.iter().find(|p| p.id == *id)?.value
    }

    /// Factor by which correlated residuals make variances larger than the variances for white noise: the median over the
    /// parameters of (sigma / white sigma)^2, at least 1.
    pub fn discount(&self) -> f64 {
        let ratio = |p: &Identified| Some((p.sigma? / p.white_sigma?).powi(2)).filter(|r| r.is_finite());
        let mut ratios: Vec<f64> = self.parameters.iter().filter_map(ratio).collect();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied().unwrap_or(1.0).max(1.0)
    }

    /// The value of a parameter to use in torque predictions, also if the parameter is not identifiable; `None` if the
    /// parameter is not in the estimate.
    pub fn prediction(&self, id: &ParameterId) -> Option<f64> {
        self.parameters.iter().find(|p| p.id == *id).map(Identified::prediction)
    }

    /// Writes the estimate as the text of estimate.yaml.
    pub fn to_yaml(&self) -> Result<String, Error> {
        let whole = Estimate { parameter_count: Some(self.parameters.len()), ..self.clone() };
        artefact::write(ArtefactKind::Estimate, self.checksum, &whole).map_err(Error::new)
    }

    /// Reads an estimate from `text`, the content of estimate.yaml. `file`: name of the file, for error messages.
    ///
    /// Fails if a line does not belong to an estimate, if the file was cut short, if a parameter occurs twice, or if a number
    /// is not valid (NaN, infinite, negative sigma).
    pub fn from_yaml(file: &str, text: &str) -> Result<Estimate, Error> {
        let at = |message: String| Error::at(file, 0, message);
        let mut estimate: Estimate = artefact::read(ArtefactKind::Estimate, text).map_err(at)?;
        // `parameter_count` is on the last line, so a file that was cut short does not contain it.
        let found = estimate.parameters.len();
        match estimate.parameter_count.take() {
            Some(count) if count == found => {}
            Some(count) => return Err(at(format!("{found} parameters where there were {count}: make the file again"))),
            None => {
                let message = "the last line, parameter_count, is missing: the file is cut short; make it again";
                return Err(at(message.into()));
            }
        }
        estimate.checksum = Checksum::of(text);
        // Errors that the YAML parser does not find: repeated names, negative standard deviations, NaN and infinite numbers.
        let mut seen = BTreeSet::new();
        if let Some(twice) =
            estimate.parameters.iter().map(|p| p.id.to_string()).find(|name| !seen.insert(name.clone()))
        {
            return Err(at(format!("{twice} stands twice among the parameters: make the file again")));
        }
        let is_negative = |p: &&Identified| [p.sigma, p.white_sigma].into_iter().flatten().any(|sigma| sigma < 0.0);
        if let Some(p) = estimate.parameters.iter().find(is_negative) {
            return Err(at(format!("the sigma of {} is negative: make the file again", p.id)));
        }
        if let Some(cutoff) = estimate.cutoff.filter(|hz| !CUTOFFS_HZ.contains(hz)) {
            let (low, high) = (CUTOFFS_HZ.start(), CUTOFFS_HZ.end());
            return Err(at(format!(
                "cutoff is {cutoff:?}; a low-pass has {low:?} to {high:?} Hz: make the file again"
            )));
        }
        let numbers = |p: &Identified| [p.value, p.sigma, p.white_sigma, p.used_for_prediction];
        match estimate.parameters.iter().find(|p| numbers(p).into_iter().flatten().any(|x| !x.is_finite())) {
            Some(p) => Err(at(format!("{} holds what is no number: make the file again", p.id))),
            None => Ok(estimate),
        }
    }
}

/// Accepted range of the cut-off frequency of the low-pass filter, Hz.
const CUTOFFS_HZ: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Reads an optional number from an estimate file. Zero becomes `None`, because older files contain 0 for an absent number.
pub(crate) fn not_zero<'de, D: serde::Deserializer<'de>>(reader: D) -> Result<Option<f64>, D::Error> {
    Ok(Option::<f64>::deserialize(reader)?.filter(|x| *x != 0.0))
}

/// Number of decimals with which a value is printed: at least five. Small values need more decimals: as many as show two
/// significant digits of sigma or, without sigma, three significant digits of the value. A value with more than six significant
/// digits gets fewer decimals, unless sigma needs them.
fn decimals(sigma: f64, value: f64) -> usize {
    let places = |x: f64, digits: f64| (digits - 1.0 - x.abs().log10().floor()).clamp(0.0, MOST_DECIMALS) as usize;
    let shown = match (sigma > 0.0, value == 0.0) {
        (true, _) => places(sigma, SIGMA_DIGITS),
        (false, false) => places(value, DIGITS_WITHOUT_SIGMA),
        (false, true) => USUAL_DECIMALS,
    };
    let most = if value == 0.0 { USUAL_DECIMALS } else { places(value, MOST_VALUE_DIGITS).max(shown) };
    shown.max(USUAL_DECIMALS).min(most)
}

/// A value is printed with at least this number of decimals. A value with more than `MOST_VALUE_DIGITS` digits gets fewer
/// decimals.
const USUAL_DECIMALS: usize = 5;
/// Largest number of decimals of a printed value.
const MOST_DECIMALS: f64 = 9.0;
/// Significant digits of a printed sigma.
const SIGMA_DIGITS: f64 = 2.0;
/// Significant digits of a printed value without sigma.
const DIGITS_WITHOUT_SIGMA: f64 = 3.0;
/// Largest number of significant digits of a printed value, unless the sigma of the value needs more.
const MOST_VALUE_DIGITS: f64 = 6.0;

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cutoff = self.cutoff.map_or(String::new(), |hz| format!(", cut-off {hz:.2} Hz"));
        writeln!(f, "{}: {}{cutoff}, {} rows", self.model, self.method, self.rows)?;
        let names: Vec<String> = self.parameters.iter().map(|p| p.id.to_string()).collect();
        let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(9);
        writeln!(f, "{:<width$}  {:>12}  {:>10}  {:>9}  unit", "parameter", "value", "sigma", "sigma %")?;
        for (p, name) in self.parameters.iter().zip(&names) {
            write!(f, "{name:<width$}  ")?;
            let Some(value) = p.value else {
                writeln!(f, "not identifiable")?;
                continue;
            };
            let digits = decimals(p.sigma.unwrap_or(0.0), value);
            write!(f, "{value:>12.digits$}  {:>10.digits$}", p.sigma.unwrap_or(f64::NAN))?;
            let status = match p.status {
                Status::NotSignificant => "  (zero is within its 95 % interval)",
                Status::Weak => "  (weak: little motion decides it)",
                Status::Identified | Status::NotIdentifiable | Status::Given => "",
            };
            // A parameter with the value zero has no relative standard deviation.
            let share = p.relative_sigma.map_or("-".into(), |share| format!("{share:.2}"));
            writeln!(f, "  {share:>9}  {}{status}", p.unit)?;
        }
        writeln!(f)?;
        write_residuals(f, &self.joints, self.total, self.cross_validation)?;
        writeln!(
            f,
            "{}rank {} of {}",
            self.condition_number.map_or(String::new(), |x| format!("condition number {x:.1} (columns scaled), ")),
            self.rank,
            self.parameters.len()
        )?;
        if let Some(said) = self.checksum.said() {
            writeln!(f, "{said}")?;
        }
        self.remarks.iter().try_for_each(|remark| writeln!(f, "{remark}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::identified::Deviations;
    use crate::estimate::residuals::{Residuals, Squares};
    use crate::test_arm::Pendulum;
    use linear_model::unit::Unit;

    fn estimate() -> Estimate {
        Estimate {
            model: "arm".into(),
            parameters: vec![
                Identified::new("ZZR1".parse().unwrap(), Unit::INERTIA, 1.25, Deviations::white(0.0125)),
                Identified::unidentifiable("FV1".parse().unwrap(), Unit::VISCOUS, 0.5),
            ],
            joints: Residuals::new(&Pendulum::new(), vec![Squares { torque: 40.0, residual: 0.1, rows: 10 }]).joints,
            condition_number: Some(f64::INFINITY),
            rank: 1,
            remarks: vec!["FV1 is not identifiable from this log: joint q1 moves 0.000 rad".into()],
            ..Estimate::default()
        }
    }

    #[test]
    fn yaml_round_trip() {
        let text = estimate().to_yaml().unwrap();
        assert_eq!(Estimate::from_yaml("estimate.yaml", &text).unwrap(), estimate(), "{text}");
        let refused = Estimate::from_yaml("estimate.yaml", "parameters: 3").unwrap_err().to_string();
        assert!(refused.contains("estimate.yaml"), "{refused}");
    }

    #[test]
    fn what_is_cut_short_is_refused() {
        let text = estimate().to_yaml().unwrap();
        let lines: Vec<&str> = text.lines().collect();
        for end in 0..lines.len() {
            let cut = lines[..end].join("\n");
            assert!(Estimate::from_yaml("e.yaml", &cut).is_err(), "{cut}");
        }
        let other = text.replace("value: 1.25", "value: .nan");
        assert!(Estimate::from_yaml("e.yaml", &other).unwrap_err().to_string().contains("ZZR1 holds"), "{other}");
        let fewer = text.replace("parameter_count: 2", "parameter_count: 3");
        assert!(Estimate::from_yaml("e.yaml", &fewer).unwrap_err().to_string().contains("2 parameters where"));
    }

    #[test]
    fn small_robots_have_digits() {
        let numbers = [(0.00015, 0.9), (3.2e-7, 1.5e-6), (0.0, 2.5e-6), (0.0, 0.0), (1e-30, 1.0)];
        assert_eq!(numbers.map(|(sigma, value)| decimals(sigma, value)), [5, 8, 8, 5, 9]);
    }

    #[test]
    fn the_table_hides_no_gap() {
        let text = estimate().to_string();
        assert!(text.contains("not identifiable") && text.contains("joint q1 moves 0.000 rad"), "{text}");
        assert_eq!(estimate().value(&"FV1".parse().unwrap()), None);
    }
}
