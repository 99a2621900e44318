//! The settings that two sums must have in common before they can be added: robot, columns, filter, friction, transmission.
//!
//! The triangles of sums (R of QR decompositions) contain only numbers; the settings define their meaning. They contain names and
//! units of the columns, the fingerprint of the model (which covers geometry and gravity), and every option that affects a row.
//! Only the column names in the log files may differ, because two recorders may use different names for the same signal.
//!
//! A coupling is a term by which the torque of a joint depends on another joint.

use linear_model::description_options::DescriptionOptions;
use linear_model::friction::terms::columns_before;
use linear_model::linear_model::Model;
use linear_model::parameter::{BaseParameter, Parameter, ParameterId};
use linear_model::reference::ModelReference;
use linear_model::regressor::Regressor;
use linear_model::unit::Unit;
use logs::Error;
use serde::{Deserialize, Serialize};

use identification::estimate::claims::hypotheses::{Hypothesis, UndeterminedMechanics, hypotheses_of};
use identification::estimate::options::Options;
use identification::estimators::weighted::Weights;

/// The settings that all logs of a sum have in common.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Name and fingerprint of the robot model.
    pub model: ModelReference,
    /// Options for reading the description; `None`: the defaults.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<DescriptionOptions>,
    /// The coordinates of the robot. There is one triangle (the R of a QR decomposition of the torque equations) per coordinate,
    /// and the triangles are stored in this order.
    pub coordinates: Vec<Axis>,
    /// Columns of the triangles (R of QR decompositions), in this order: base parameters, friction, couplings.
    pub columns: Vec<TriangleColumn>,
    /// The options of the identification.
    pub options: Options,
    /// The tested hypotheses on faults. The triangles for these tests have first the columns of the parameters, then the columns
    /// of the hypotheses.
    pub hypotheses: Vec<Hypothesis>,
}

/// A coordinate of the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Name of the coordinate in the description.
    pub name: String,
    /// Whether the coordinate is a length (prismatic joint).
    pub slides: bool,
}

/// A column of the triangles: one parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TriangleColumn {
    /// The parameter.
    pub name: ParameterId,
    /// SI unit of the parameter's value.
    pub unit: Unit,
    /// Indices of the coordinates whose torque depends on the parameter, from 0.
    pub moves_with: Vec<usize>,
    /// Whether the joint of the parameter is prismatic.
    pub slides: bool,
}

impl From<&Parameter> for TriangleColumn {
    fn from(parameter: &Parameter) -> TriangleColumn {
        TriangleColumn {
            name: parameter.id.clone(),
            unit: parameter.unit(),
            moves_with: parameter.coordinates.clone(),
            slides: parameter.is_prismatic,
        }
    }
}

impl Settings {
    /// Makes the settings of a robot and of the options of an identification.
    ///
    /// Fails if an option needs the rows twice.
    pub fn new(
        regressor: &dyn Regressor,
        model: ModelReference,
        description: Option<DescriptionOptions>,
        options: &Options,
        open: UndeterminedMechanics,
    ) -> Result<Settings, Error> {
        if !options.weights.losses().is_empty() {
            return Err(Error::new(format!(
                "weights {}: they follow from the residual of each row, and a sum has no rows; take joint or none, or \
                 identify these logs in one go",
                options.weights.word()
            )));
        }
        let mut options = options.clone();
        options.model = model.name.clone();
        let couplings = options.transmission.coupled();
        let linear = Model::new(regressor, &options.friction, &couplings);
        let columns = linear.parameters.iter().map(TriangleColumn::from).collect();
        let hypotheses = hypotheses_of(&linear, open);
        let axis = |(k, name): (usize, &String)| Axis { name: name.clone(), slides: regressor.is_prismatic(k) };
        let coordinates = regressor.coordinates().iter().enumerate().map(axis).collect();
        Ok(Settings { model, description, coordinates, columns, options, hypotheses })
    }

    /// Phrases that describe how `self` differs from other settings. Empty if sums with these two settings can be added.
    pub fn differences(&self, other: &Settings) -> Vec<String> {
        let mut found = Vec::new();
        let mut compare = |what: &str, ours: String, theirs: String| {
            if ours != theirs {
                found.push(format!("{what}: {ours} and {theirs}"));
            }
        };
        // Compares the robot, and the options with which its description was read.
        let model = |s: &Settings| format!("{} ({})", s.model.name, s.model.fingerprint);
        compare("model", model(self), model(other));
        compare("its description was read with", shown(&self.description), shown(&other.description));
        // Compares every option that affects a row.
        let (ours, theirs) = (&self.options, &other.options);
        let hz = |x: Option<f64>| x.map_or("as the logs ask for".to_string(), |hz| format!("{hz} Hz"));
        compare("cut-off", hz(ours.signal.cutoff), hz(theirs.signal.cutoff));
        let every = |x: Option<usize>| x.map_or("ten a period of the cut-off".to_string(), |n| format!("every {n}th"));
        compare("samples kept", every(ours.signal.decimate), every(theirs.signal.decimate));
        let words = |w: Weights| w.word().to_string();
        compare("weights", words(ours.weights), words(theirs.weights));
        compare("friction", shown(&ours.friction), shown(&theirs.friction));
        compare("base parameters of the load", shown(&ours.friction_load), shown(&theirs.friction_load));
        compare("transmission", shown(&ours.transmission), shown(&theirs.transmission));
        // The cut-off frequency and the decimation were compared above.
        let rest = |options: &Options| {
            let mut signal = options.signal.clone();
            (signal.cutoff, signal.decimate) = (None, None);
            shown(&signal)
        };
        compare("signal", rest(ours), rest(theirs));
        compare("covariance", ours.covariance.to_string(), theirs.covariance.to_string());
        if found.is_empty() && self.hypotheses != other.hypotheses {
            found.push("the faults that were looked for differ".into());
        }
        // Equal settings give equal columns. If the columns differ, the files were written by different versions of the program.
        if found.is_empty() && (self.columns != other.columns || self.coordinates != other.coordinates) {
            let odd = self.columns.iter().zip(&other.columns).find(|(a, b)| a != b);
            found.push(match odd {
                Some((a, b)) => format!("columns: {} and {}", a.name, b.name),
                None => format!("columns: {} and {}", self.columns.len(), other.columns.len()),
            });
        }
        found
    }

    /// A regressor that has the columns of these settings but cannot compute values.
    ///
    /// Fails if the columns do not agree with the friction and the couplings in the options.
    pub(crate) fn columns_alone(&self) -> Result<ColumnsOnly, Error> {
        let options = &self.options;
        // The base parameters come first, then friction and couplings. The numbers of friction and coupling columns follow from
        // the options.
        let couplings = options.transmission.coupled();
        let friction = columns_before(&options.friction, self.coordinates.len());
        let others = friction + couplings.iter().map(|c| c.parameters().len()).sum::<usize>();
        let unlike = || Error::new("its columns are not those of its friction and transmission: make the file again");
        let base = self.columns.len().checked_sub(others).ok_or_else(unlike)?;
        let parameter = |column: &TriangleColumn| match &column.name {
            ParameterId::Base(name) => Ok(BaseParameter {
                name: name.clone(),
                coordinates: column.moves_with.clone(),
                is_prismatic: column.slides,
            }),
            _ => Err(unlike()),
        };
        let n = self.coordinates.len();
        let alone = ColumnsOnly {
            coordinates: self.coordinates.iter().map(|axis| axis.name.clone()).collect(),
            slides: self.coordinates.iter().map(|axis| axis.slides).collect(),
            parameters: self.columns[..base].iter().map(parameter).collect::<Result<_, _>>()?,
        };
        // A damaged file may contain indices of coordinates that do not exist.
        let is_inside = |c: &TriangleColumn| c.moves_with.iter().all(|&k| k < n);
        let is_motor = couplings.iter().all(|c| c.rows().all(|k| k < n));
        let is_tested = self.hypotheses.iter().all(|hypothesis| hypothesis.is_of(n));
        if !is_motor || !is_tested || !self.columns.iter().all(is_inside) {
            return Err(unlike());
        }
        // The columns that the options give must equal the columns in the file.
        let model = Model::new(&alone, &options.friction, &couplings);
        match model.parameters.iter().map(TriangleColumn::from).eq(self.columns.iter().cloned()) {
            true => Ok(alone),
            false => Err(unlike()),
        }
    }
}

/// Formats a value as one line of text, for a message.
fn shown<T: std::fmt::Debug>(value: &T) -> String {
    format!("{value:?}")
}

/// A regressor for sums, whose triangles (R of QR decompositions) exist already: it has columns but cannot compute values.
pub struct ColumnsOnly {
    coordinates: Vec<String>,
    slides: Vec<bool>,
    parameters: Vec<BaseParameter>,
}

impl Regressor for ColumnsOnly {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.parameters
    }

    fn is_prismatic(&self, k: usize) -> bool {
        self.slides[k]
    }

    /// The values of Y are unknown, so they are NaN. Every result that needs them is then NaN too.
    fn fill(&self, _: &[f64], _: &[f64], _: &[f64], y: &mut [f64]) {
        y.fill(f64::NAN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use linear_model::friction::terms::FrictionTerm;

    fn settings(options: &Options) -> Result<Settings, Error> {
        Settings::new(
            &Pendulum::new(),
            ModelReference { name: "arm".into(), fingerprint: "1".into() },
            None,
            options,
            UndeterminedMechanics::default(),
        )
    }

    #[test]
    fn what_differs_is_named() {
        let one = settings(&Options::default()).unwrap();
        assert!(one.differences(&one.clone()).is_empty());
        let mut options = Options { friction: vec![FrictionTerm::Viscous], ..Options::default() };
        options.signal.cutoff = Some(8.0);
        let other = settings(&options).unwrap();
        let found = one.differences(&other);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("cut-off: as the logs ask for and 8 Hz"), "{found:?}");
        assert!(found[1].starts_with("friction: "), "{found:?}");
        let mut named = one.clone();
        named.options.columns.time = Some("clock".into());
        assert!(one.differences(&named).is_empty(), "names of columns in a log change no row");
    }

    #[test]
    fn what_needs_rows_twice_is_refused() {
        let refused = settings(&Options { weights: Weights::Huber, ..Options::default() }).unwrap_err().to_string();
        assert!(refused.contains("weights huber") && refused.contains("take joint or none"), "{refused}");
    }

    #[test]
    fn columns_that_do_not_follow_are_refused() {
        let mut one = settings(&Options::default()).unwrap();
        assert_eq!(one.columns_alone().unwrap().parameters(), Pendulum::new().parameters());
        one.options.friction.pop();
        assert!(one.columns_alone().is_err());
    }
}
