//! [`Model`]: a robot whose dynamics are derived once, with its base regressor. All functions of this library use it.
//!
//! The number of base parameters is the rank of the regressor, found numerically at random states. The rank is clear-cut if
//! there is a large gap between the columns that are independent and the columns that are not. Loops are closed numerically if
//! the positions of their passive joints are no affine functions of the coordinates. A tape is a list of arithmetic operations
//! that evaluates a function. The fingerprint of a model is a checksum of its base regressor.

use std::path::{Path, PathBuf};

use expr::Function;
use linear_model::compiled::compiled;
use linear_model::description_options::DescriptionOptions;
use linear_model::known_load::KnownLoad;
use linear_model::label::Label;
use linear_model::parameter::{BaseName, BaseParameter, ParameterId};
use linear_model::reference::ModelReference;
use linear_model::regressor::{Coordinate, Regressor};
use linear_model::standard_map::StandardMap;
use logs::{ColumnNames, Columns, LogSource, Table};
use modeling::{BaseParameters, Closure, Derivation, UnclearRank};
use robot::value::CoordinateId;
use robot::{Inertial, JointKind, LinkId, Robot};

use crate::describe::description::{ModelOptions, check_size, check_values, parse_robot};
use crate::error::Error;
use crate::tape::tape_regressor::TapeRegressor;
use identification::estimate::artefact::Estimate;

/// A robot with its base parameters and functions.
pub struct Model {
    /// The file from which the robot was read, as the user named it.
    pub path: PathBuf,
    /// The description with its options applied.
    pub robot: Robot,
    /// The base parameters with the rules of their regrouping.
    pub parameters: BaseParameters,
    /// Regressor Y(q, dq, ddq) of the p_s standard parameters: n x p_s, row by row.
    pub standard_regressor: Function,
    /// Regressor Y(q, dq, ddq) of the p base parameters: n x p, row by row.
    pub base_regressor: Function,
    /// Torques tau(q, dq, ddq, X), X being the standard parameters.
    pub torque: Function,
    /// Name and fingerprint of the model. Result files store both to identify the model.
    pub reference: ModelReference,
    /// The options with which the description was read. Result files store these options.
    pub description: Option<DescriptionOptions>,
    /// A configuration in which the numerically solved loops are closed: name and value (rad or m) of each coordinate, then of
    /// each passive joint. The solver reaches all other configurations from this configuration. Empty without such loops.
    pub assembly: Vec<(String, f64)>,
    closure: Option<Closure>,
    regressor: Box<dyn Regressor + Send>,
}

impl Model {
    /// Reads a description (.yaml, .urdf, .xacro, .xml of MuJoCo, .par) and derives its dynamics.
    ///
    /// Fails with the line of an entry that cannot be read, if a symbol has no value, or if the rank of the base parameters is
    /// not clear-cut.
    pub fn read(path: impl AsRef<Path>) -> Result<Model, Error> {
        Model::read_with(path, &ModelOptions::default())
    }

    /// Reads a description with the options `options` and derives its dynamics; fails like [`Model::read`].
    pub fn read_with(path: impl AsRef<Path>, options: &ModelOptions) -> Result<Model, Error> {
        let path = path.as_ref();
        Model::parse(&robot::format::text_of(path)?, path, options)
    }

    /// Derives the dynamics of a description in memory; the extension of `path` gives its format. `path` is only named in
    /// messages, and no file is opened at `path`.
    pub fn parse(text: &str, path: impl AsRef<Path>, options: &ModelOptions) -> Result<Model, Error> {
        let path = path.as_ref();
        let robot = parse_robot(text, path, options)?;
        check_values(&robot, path)?;
        Ok(Model { description: options.description(), ..Model::of(robot, path, options.any_size)? })
    }

    /// Derives the dynamics of a robot; `path` is only named in messages.
    ///
    /// Fails if the rank of the base parameters is not clear-cut. Fails with the estimated time and memory if the derivation
    /// would need much of either, unless `any_size` is set.
    pub fn of(robot: Robot, path: &Path, any_size: bool) -> Result<Model, Error> {
        let model = Model::at_any_rank(robot, path, any_size)?;
        match &model.parameters.refused {
            Some(unclear) => Err(Error::new(format_args!("{}: {unclear}", path.display()))),
            None => Ok(model),
        }
    }

    /// Derives the dynamics like [`Model::of`], but does not fail at an unclear rank: [`Model::parameters`] are then the
    /// standard parameters, ungrouped. Such a model is enough for torques, poses and other functions without base parameters.
    pub fn at_any_rank(robot: Robot, path: &Path, any_size: bool) -> Result<Model, Error> {
        check_size(&robot, any_size).map_err(|e| Error::new(format_args!("{}: {e}", path.display())))?;
        let refused = |unclear: UnclearRank| Error::new(format_args!("{}: {unclear}", path.display()));
        let mut derivation = Derivation::new(&robot).map_err(|e| refused(e.into()))?;
        let standard = derivation.regressor();
        let parameters = derivation.parameters_at_any_rank(&standard).map_err(refused)?;
        let base_regressor = parameters.regressor(&standard).bound();
        let (torque, closure) = (derivation.torque().bound(), derivation.closure());
        let (for_regressor, assembly) = (derivation.closure(), assembly(&robot, derivation.closure()));
        let (coordinates, columns) = (coordinates(&robot), base_columns(&robot, &parameters));
        let fingerprint = base_regressor.fingerprint();
        let regressor: Box<dyn Regressor + Send> = match compiled(fingerprint, coordinates.clone(), columns.clone()) {
            Some(compiled) => Box::new(compiled),
            None => Box::new(TapeRegressor::new(&base_regressor, for_regressor, coordinates, columns)),
        };
        Ok(Model {
            path: path.to_path_buf(),
            description: None,
            reference: ModelReference { name: robot.name.clone(), fingerprint: format!("{fingerprint:016x}") },
            standard_regressor: standard.bound(),
            base_regressor,
            torque,
            parameters,
            assembly,
            closure,
            regressor,
            robot,
        })
    }

    /// Makes a copy of the robot, applies the change `robot` to the copy, and derives the model of the changed copy. `options`
    /// records the change in the reading options.
    ///
    /// Fails if the rank of the base parameters is not clear-cut.
    pub(crate) fn changed(
        &self,
        robot: impl FnOnce(&mut Robot),
        options: impl FnOnce(&mut DescriptionOptions),
    ) -> Result<Model, Error> {
        let (mut changed, mut description) = (self.robot.clone(), self.description.clone().unwrap_or_default());
        robot(&mut changed);
        options(&mut description);
        Ok(Model { description: Some(description), ..Model::of(changed, &self.path, true)? })
    }

    /// The base regressor: compiled code if this robot is built in, otherwise a tape.
    pub fn regressor(&self) -> &dyn Regressor {
        self.regressor.as_ref()
    }

    /// Opens a log of the robot; also returns which column was taken for which signal.
    ///
    /// Fails if the log cannot be read, if a column is missing, or if a column of a sliding joint is in a unit of angles.
    pub fn open_log(&self, path: &Path, names: &ColumnNames) -> Result<(LogSource, Columns), Error> {
        let (log, columns) = LogSource::open(path, self.regressor().coordinates(), names)?;
        Ok((log, self.with_sliding(columns, &path.display().to_string())?))
    }

    /// Uses a table in memory as a log of the robot; fails like [`Model::open_log`].
    pub fn log_of_table(&self, table: Table, names: &ColumnNames) -> Result<(LogSource, Columns), Error> {
        let file = table.file.clone();
        let (log, columns) = LogSource::from_table(table, self.regressor().coordinates(), names)?;
        Ok((log, self.with_sliding(columns, &file)?))
    }

    fn with_sliding(&self, columns: Columns, file: &str) -> Result<Columns, Error> {
        let slides: Vec<bool> = (0..columns.coordinates.len()).map(|k| self.regressor().is_prismatic(k)).collect();
        columns.with_sliding(&slides).map_err(|e| Error::new(format_args!("{file}: {e}")))
    }

    /// Takes the solver of the passive joints out of the model; `None` if no joint is solved numerically.
    pub fn take_closure(&mut self) -> Option<Closure> {
        self.closure.take()
    }

    /// Whether the base regressor is compiled into this program.
    pub fn is_compiled(&self) -> bool {
        linear_model::compiled::is_compiled(self.base_regressor.fingerprint())
    }

    /// The matrix K of X_base = K X_standard, as numbers.
    pub fn standard_map(&self) -> StandardMap {
        let (base, standard) = (&self.parameters.base, &self.parameters.standard);
        let terms: Vec<(usize, usize, f64)> = base
            .iter()
            .enumerate()
            .flat_map(|(k, b)| b.terms.iter().map(move |t| (k, t.parameter, t.coefficient)))
            .collect();
        let first = |c: &usize| standard[*c].inertial == Inertial::Xx;
        let bodies = (0..standard.len()).filter(first).map(|c| (self.robot.link(standard[c].link).name.clone(), c));
        StandardMap::new(
            standard.iter().map(|s| s.display(&self.robot).to_string()).collect(),
            base.len(),
            &terms,
            bodies.collect(),
            (0..standard.len()).filter(|&c| standard[c].inertial == Inertial::Ia).collect(),
        )
    }

    /// Inertial parameters of each body in the description, in the order of [`Model::standard_map`]; `None` for a body without
    /// inertial parameters.
    pub fn reference_bodies(&self) -> Vec<Option<[f64; 10]>> {
        self.body_links().into_iter().map(|link| self.robot.link(link).inertial).collect()
    }

    /// The links of the bodies, in the order of [`Model::standard_map`].
    pub fn body_links(&self) -> Vec<LinkId> {
        self.parameters.standard.iter().filter(|s| s.inertial == Inertial::Xx).map(|s| s.link).collect()
    }

    /// Base parameters from the inertial parameters of the description; a link without inertial parameters counts as massless.
    /// `None` if no link has inertial parameters.
    pub fn nominal_parameters(&self) -> Option<Vec<f64>> {
        Some(self.parameters.values(&self.nominal_standard_parameters()?))
    }

    /// Standard parameters from the inertial parameters of the description; a link without inertial parameters counts as
    /// massless. `None` if no link has inertial parameters.
    pub fn nominal_standard_parameters(&self) -> Option<Vec<f64>> {
        if self.robot.links.iter().all(|link| link.inertial.is_none()) {
            return None;
        }
        let value = |p: &robot::StandardParameter| p.value(&self.robot).unwrap_or(0.0);
        Some(self.parameters.standard.iter().map(value).collect())
    }

    /// Drive gains in the description, one per coordinate, N m/A; `None` for a drive without a gain.
    pub fn drive_gains(&self) -> Vec<Option<f64>> {
        let gain = |k| self.robot.joint_of(CoordinateId(k)).and_then(|j| self.robot.link(j).joint.drive_gain);
        (0..self.robot.n_coordinates()).map(gain).collect()
    }

    /// The index of a coordinate by its name.
    ///
    /// Fails with the list of names if the name is unknown.
    pub fn coordinate(&self, name: &str) -> Result<usize, Error> {
        let names = self.regressor.coordinates();
        names
            .iter()
            .position(|c| c == name)
            .ok_or_else(|| Error::new(format_args!("there is no coordinate `{name}`; there are {}", names.join(", "))))
    }

    /// Overwrites gains in `all`, the gains of all drives. `given`: each new gain with the name of its coordinate.
    ///
    /// Fails with the list of names if a coordinate is unknown.
    pub fn give_gains<T: From<f64>>(&self, all: &mut [T], given: &[(String, f64)]) -> Result<(), Error> {
        given.iter().try_for_each(|(name, gain)| {
            let of = self.coordinate(name).map_err(|e| Error::new(format_args!("[gain={name}={gain}]: {e}")))?;
            all[of] = T::from(*gain);
            Ok(())
        })
    }

    /// The parameter values of an estimate with which torques are predicted: one per base parameter, in the order of the
    /// regressor.
    ///
    /// Fails if the estimate lacks a base parameter.
    pub fn values(&self, estimate: &Estimate) -> Result<Vec<f64>, Error> {
        let value = |base: &BaseParameter| predicts(estimate, &ParameterId::Base(base.name.clone()));
        self.regressor.parameters().iter().map(value).collect()
    }

    /// Drive gains of an estimate, one per coordinate, N m/A; `None` for a drive whose gain was not estimated.
    pub fn estimated_gains(&self, estimate: &Estimate) -> Vec<Option<f64>> {
        let gain = |c: &String| estimate.value(&ParameterId::drive_gain(c));
        self.regressor.coordinates().iter().map(gain).collect()
    }

    /// The changes of the base parameters by a known load, in the order of the regressor.
    ///
    /// Fails if the robot has no link with the name in `load`.
    pub fn added_by(&self, load: &KnownLoad) -> Result<Vec<f64>, Error> {
        load.base_parameters(&self.robot, &self.standard_map()).map_err(Error::new)
    }

    /// Fails if `estimate` was made with another robot or geometry, or does not name its model. `file` is named in messages.
    pub fn check_estimate(&self, file: &Path, estimate: &Estimate) -> Result<(), Error> {
        let Some(made_with) = estimate.made_with() else {
            return Err(Error::new(format_args!("{}: it does not say with which model it was made", file.display())));
        };
        let differences = ModelOptions::differences(self.description.as_ref(), estimate.description.as_ref());
        self.check_read(file, &made_with, &differences)
    }

    /// Fails if a result file (estimate, motion, plan) was made with another robot or geometry. `file` is named in messages.
    pub fn check(&self, file: &Path, made_with: &ModelReference) -> Result<(), Error> {
        self.check_read(file, made_with, &[])
    }

    /// Fails if a result file (estimate, motion, plan) was made with another robot or geometry. `differences`: sentences on
    /// reading options with which the file was made and which differ from the options of this model.
    pub fn check_read(&self, file: &Path, made_with: &ModelReference, differences: &[String]) -> Result<(), Error> {
        let ours = &self.reference;
        if made_with.fingerprint == ours.fingerprint {
            return Ok(());
        }
        let why = match differences {
            [] => "its geometry or joints have changed, or it was read with other options ([rotor_inertia], [value], [arg], \
                   [package], [mimic], [lock], [base], [floating_base]), or by another version of rist"
                .into(),
            differences => differences.join(", "),
        };
        Err(Error::new(format_args!(
            "{}: made with `{}` ({}), but this model is `{}` ({}): {why}",
            file.display(),
            made_with.name,
            made_with.fingerprint,
            ours.name,
            ours.fingerprint
        )))
    }
}

/// The value of the parameter `id` of an estimate, as used to predict torques.
///
/// Fails if the estimate lacks this parameter.
pub(crate) fn predicts(estimate: &Estimate, id: &ParameterId) -> Result<f64, Error> {
    let missing = || Error::new(format_args!("the estimate has no parameter {id}, which this model has"));
    estimate.prediction(id).ok_or_else(missing)
}

/// The coordinates of a robot: the name of each coordinate in the robot's file, and whether the joint of the coordinate slides.
pub(crate) fn coordinates(robot: &Robot) -> Vec<Coordinate> {
    let is_prismatic = |k: usize| {
        let joint = robot.joint_of(CoordinateId(k));
        joint.is_some_and(|j| robot.link(j).joint.kind == JointKind::Prismatic)
    };
    let coordinate =
        |(k, c): (usize, &robot::Coordinate)| Coordinate { name: c.name.clone(), is_prismatic: is_prismatic(k) };
    robot.coordinates.iter().enumerate().map(coordinate).collect()
}

/// The configuration from which the solver of the loops starts: names and values (rad or m). Empty if the loops close nowhere.
fn assembly(robot: &Robot, closure: Option<Closure>) -> Vec<(String, f64)> {
    let found = closure.and_then(|mut closure| closure.find_origin(robot.n_coordinates()));
    let Some((q, passive)) = found else { return Vec::new() };
    let name = |k: usize| robot.coordinate_name(CoordinateId(k)).to_string();
    q.into_iter().chain(passive).enumerate().map(|(k, x)| (name(k), x)).collect()
}

/// The columns of the base regressor: the name of each, and the coordinates that move the joint of its link.
pub fn base_columns(robot: &Robot, parameters: &BaseParameters) -> Vec<BaseParameter> {
    let column = |base: &modeling::BaseParameter| {
        let standard = parameters.standard[base.column];
        let link = robot.link(standard.link);
        let plain = BaseName {
            lever: String::new(),
            inertial: standard.inertial,
            absorbs: base.terms.len() > 1,
            label: Label::of_link(&link.label),
        };
        let lever = base.name.strip_suffix(&plain.to_string()).unwrap_or_default().to_string();
        BaseParameter {
            name: BaseName { lever, ..plain },
            coordinates: moves_with(robot, standard.link),
            is_prismatic: link.joint.kind == JointKind::Prismatic,
        }
    };
    parameters.base.iter().map(column).collect()
}

/// Indices of the coordinates that move the joint of a link; empty if this joint is solved numerically.
fn moves_with(robot: &Robot, link: LinkId) -> Vec<usize> {
    let terms = robot.link(link).joint.variable.terms.iter().map(|(k, _)| k.0);
    terms.filter(|&k| k < robot.n_coordinates()).collect()
}
