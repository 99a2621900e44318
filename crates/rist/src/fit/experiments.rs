//! Identifies parameters from the logs of an experiment plan: by RIST-MH (all harmonics), or by the rows of Sp of [Vandanjon,
//! Gautier, Desbats 1995] (one projection of the spectrum per experiment).
//!
//! Each experiment is a periodic motion with one log; some experiments may be repeated with a known load. Sp(m, v) = Re(m conj
//! v) / |v|^2 projects the spectrum m of a signal on the spectrum v of a motion. Further methods, which simulate the
//! experiments in closed loop, are registered by another package. The record of an experiment is its sampled motion and torque.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use experiments::motion::record::Record;
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::experiment_plan::ExperimentPlan;
use identification::estimate::torque_error::{ErrorContributions, TorqueError, torque_errors};
use identification::estimators::drive_gains::likelihood::Gain;
use identification::spectrum::identify::{SpectralFit, identify_spectrum};
use linear_model::linear_model::Model as LinearModel;
use logs::{ColumnNames, Effort, Log};

pub use identification::spectrum::experiment::SpectralExperiment;
pub use identification::spectrum::identify::SpectralMethod;
pub use identification::spectrum::rist_mh::data::HarmonicOptions;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::motion_range::{allowed, seen_in_plan};
use crate::request::{ClosedLoopRequest, HarmonicRequest, Method, PaperRequest, Request, WordChoice};
use identification::estimate::artefact::Estimate;

/// The logs of a plan whose experiments were run.
#[derive(Clone, Copy)]
pub struct ExperimentLogs<'a> {
    /// The folder with `e01.csv`, .. named after the experiments, and `e01_loaded.csv`, .. of experiments repeated with a load.
    pub directory: &'a Path,
    /// The plan that was run.
    pub plan: &'a ExperimentPlan,
}

impl ExperimentLogs<'_> {
    /// The paths of all logs that may be read, whether they exist or not.
    pub fn files(&self) -> Vec<PathBuf> {
        let names = self.plan.experiments.iter().flat_map(|e| [plain(&e.name), loaded(&e.name)]);
        names.map(|name| self.directory.join(name)).collect()
    }
}

/// The file name of the log of the experiment `experiment`.
fn plain(experiment: &str) -> String {
    format!("{experiment}.csv")
}

/// The file name of the log of the experiment `experiment`, if the experiment was repeated with a load.
fn loaded(experiment: &str) -> String {
    format!("{experiment}_loaded.csv")
}

/// Identifies base parameters, friction and unknown drive gains from the experiments of a plan, by RIST-MH, which uses all
/// harmonics.
///
/// Fails if a log is missing or does not belong to its experiment, or if the scale of currents is not identifiable.
pub fn identify_experiments(model: &Model, logs: ExperimentLogs, request: &HarmonicRequest) -> Result<Estimate, Error> {
    let options = request.options(model)?;
    identify_by(model, logs, &request.paper, SpectralMethod::Harmonic, &options)
}

/// Identifies the parameters from the experiments of a plan by the rows of Sp [Vandanjon, Gautier, Desbats 1995]. These rows
/// contain no friction.
///
/// Fails like [`identify_experiments`].
pub fn identify_paper_rows(model: &Model, logs: ExperimentLogs, request: &PaperRequest) -> Result<Estimate, Error> {
    request.check()?;
    identify_by(model, logs, request, SpectralMethod::Paper, &HarmonicOptions::default())
}

/// Identifies the parameters by the rows of Sp, and the drive gains by total least squares [Vandanjon, Gautier, Desbats 1995].
///
/// Fails like [`identify_experiments`], and if all gains are known.
pub fn identify_gains_of_rows(model: &Model, logs: ExperimentLogs, request: &PaperRequest) -> Result<Estimate, Error> {
    request.check()?;
    identify_by(model, logs, request, SpectralMethod::TotalLeastSquares, &HarmonicOptions::default())
}

/// A function that identifies parameters from the logs of a plan by simulating the experiments in closed loop.
pub type IdentifyInLoop = fn(&Model, ExperimentLogs, &ClosedLoopRequest, Method) -> Result<Estimate, Error>;

static IN_LOOP: OnceLock<Result<IdentifyInLoop, &'static str>> = OnceLock::new();

/// Registers the function `identify`, or the error text if this build does not contain the function. Only the first call has an
/// effect.
pub(crate) fn register(identify: Result<IdentifyInLoop, &'static str>) {
    IN_LOOP.get_or_init(|| identify);
}

/// Identifies the parameters by IDIM-IV or DIDIM, which simulate the experiments in closed loop. Another package registers
/// these methods.
///
/// Fails like [`identify_experiments`]; fails if a gain of currents is not known, if a simulation breaks down, if a parameter
/// is not identifiable, or if no package has registered the method.
pub fn identify_experiments_in_loop(
    model: &Model,
    logs: ExperimentLogs,
    request: &ClosedLoopRequest,
    method: Method,
) -> Result<Estimate, Error> {
    let identify = IN_LOOP.get().copied().unwrap_or(Err("it is not registered"));
    identify.map_err(|why| Error::new(format_args!("[method={}]: {why}", method.word())))?(model, logs, request, method)
}

fn identify_by(
    model: &Model,
    logs: ExperimentLogs,
    request: &PaperRequest,
    method: SpectralMethod,
    options: &HarmonicOptions,
) -> Result<Estimate, Error> {
    let columns = request.columns()?;
    let trajectories = logs.plan.trajectories(&logs.directory.display().to_string())?;
    // The logs of the plan's experiments, in the order of the plan.
    let mut read = ExperimentReader { model, columns: &columns, currents: false, files: Vec::new() };
    let mut experiments = Vec::new();
    for (e, trajectory) in logs.plan.experiments.iter().zip(&trajectories) {
        experiments.push(read.experiment(&logs.directory.join(plain(&e.name)), trajectory)?);
    }
    let mut remark = None;
    // Experiments that were repeated with a known load, if their logs exist.
    if let Some((file, load)) = &request.load {
        let added = model.added_by(load).map_err(|e| Error::new(format_args!("{}: {e}", file.display())))?;
        remark = Some(format!("the load of {}: {} kg on {}", file.display(), load.mass, load.link));
        let unloaded = experiments.len();
        for (e, trajectory) in logs.plan.experiments.iter().zip(&trajectories) {
            let path = logs.directory.join(loaded(&e.name));
            if path.exists() {
                experiments.push(read.experiment(&path, trajectory)?.loaded(&added));
            }
        }
        if experiments.len() == unloaded {
            return Err(Error::new(format_args!(
                "{}: no log of an experiment with the load (e01_loaded.csv, ..) in it",
                logs.directory.display()
            )));
        }
    }
    let gains = gains(model, read.currents, request)?;
    let mut estimate = identify_records(model, &experiments, method, &gains, options)?;
    estimate.remarks.extend(read.files.iter().zip(&experiments).filter_map(|(file, e)| unlike(model, file, e)));
    estimate.logs = read.files;
    estimate.description = model.description.clone();
    estimate.remarks.extend(remark);
    Ok(estimate)
}

/// Identifies the parameters from experiments that are already in memory. `gains`: one drive gain per coordinate.
///
/// Fails like [`identify_spectrum`].
pub fn identify_records(
    model: &Model,
    experiments: &[SpectralExperiment],
    method: SpectralMethod,
    gains: &[Gain],
    options: &HarmonicOptions,
) -> Result<Estimate, Error> {
    let SpectralFit { mut estimate, covariance } =
        identify_spectrum(&model.reference, model.regressor(), experiments, method, gains, options)?;
    estimate.torque_errors = errors_of_bodies(model, &estimate, &covariance, experiments);
    if !estimate.torque_errors.is_empty() {
        estimate.remarks.push("the torque uncertainty is of the bodies alone, without friction".into());
    }
    Ok(estimate)
}

/// Uncertainty of the torques of bodies and rotors, one entry per use of the estimate (such as gravity compensation). Friction
/// is not included, because friction is only a disturbance in these experiments. Empty if a parameter is not identifiable.
fn errors_of_bodies(
    model: &Model,
    estimate: &Estimate,
    covariance: &[Vec<f64>],
    experiments: &[SpectralExperiment],
) -> Vec<TorqueError> {
    let linear = LinearModel::new(model.regressor(), &[], &[]);
    let base = estimate.parameters.iter().take(linear.p());
    let Some(x) = base.map(|p| p.value).collect::<Option<Vec<f64>>>() else { return Vec::new() };
    let seen = seen_in_plan(experiments.iter().map(|e| &e.trajectory));
    let unsure = ErrorContributions { covariance, open: &[], changes: &[], logs: &[] };
    torque_errors(&linear, &x, unsure, &seen, &allowed(model, &seen))
}

/// If a position scatters between periods by more than this share of its range, the motion counts as not periodic. Noise in
/// periodic logs gives less than 0.01, a saturated drive gives 1.
const UNLIKE_PERIODS_SCATTER: f64 = 0.05;

/// A sentence on an experiment whose motion does not repeat; `None` if the motion repeats.
fn unlike(model: &Model, file: &str, experiment: &SpectralExperiment) -> Option<String> {
    let (joint, scatter) = experiment.scatter()?;
    (scatter > UNLIKE_PERIODS_SCATTER).then(|| {
        format!(
            "{file}: the motion of {} does not repeat, its periods scatter by {:.0} % of the swing: a drive saturates, \
             or the controller does not hold it; the mean of unlike periods is no motion, and no interval shows that",
            model.regressor().coordinates()[joint],
            100.0 * scatter
        )
    })
}

/// Reads the logs of experiments, and records their names and whether they hold currents.
pub struct ExperimentReader<'a> {
    /// The robot.
    pub model: &'a Model,
    /// The names of the columns in the logs.
    pub columns: &'a ColumnNames,
    /// Whether one of the logs read so far held currents.
    pub currents: bool,
    /// The names of the logs read so far.
    pub files: Vec<String>,
}

impl ExperimentReader<'_> {
    /// Reads the log at `path` of an experiment with the motion `trajectory`. Fails if the log is too short.
    fn experiment(&mut self, path: &Path, trajectory: &ExcitingTrajectory) -> Result<SpectralExperiment, Error> {
        let record = self.record(path, trajectory)?;
        let found = record.q.first().map_or(0, Vec::len);
        let needed = trajectory.windows().last().map_or(0, |w| w.end);
        SpectralExperiment::new(trajectory.clone(), &record).ok_or_else(|| {
            let path = path.display();
            Error::new(format_args!("{path}: {found} samples; its experiment takes {needed} from its start"))
        })
    }

    /// Reads the record of an experiment. Fails if the sample time of the record differs from the sample time of the plan.
    pub fn record(&mut self, path: &Path, trajectory: &ExcitingTrajectory) -> Result<Record, Error> {
        let (log, _) = Log::read(path, self.model.regressor().coordinates(), self.columns)?;
        if log.effort_is == Effort::PositionError {
            return Err(Error::new(format_args!(
                "{}: the experiments of a plan need torques or currents, not [options.columns.goal]; identify logs of position \
                 errors without the plan",
                path.display()
            )));
        }
        self.currents |= log.effort_is == Effort::Current;
        self.files.push(path.display().to_string());
        let record = Record::from_log(&log)?;
        if (record.sample_time / trajectory.sample_time - 1.0).abs() > SAMPLE_TIME_TOLERANCE {
            return Err(Error::new(format_args!(
                "{}: sampled every {:.6} s, but the plan counts its periods in samples of {:.6} s",
                path.display(),
                record.sample_time,
                trajectory.sample_time
            )));
        }
        Ok(record)
    }
}

/// Sample times that differ relatively by up to this value count as equal. With this tolerance, four periods of a thousand
/// samples end within four samples of the expected end.
const SAMPLE_TIME_TOLERANCE: f64 = 1e-3;

/// The drive gains, one per coordinate; 1 if the logs hold torques. With currents, the gain of at least one drive, or a load,
/// is needed.
fn gains(model: &Model, currents: bool, request: &PaperRequest) -> Result<Vec<Gain>, Error> {
    let coordinates = model.regressor().coordinates();
    let n = coordinates.len();
    if !currents {
        return match request.gain.first() {
            Some((name, _)) => Err(Error::new(format_args!("[gain={name}]: the logs hold torques, not currents"))),
            None => Ok(vec![Gain::Known(1.0); n]),
        };
    }
    let of_file = request.gain.is_empty() && request.load.is_none();
    let mut known = if of_file { model.drive_gains() } else { vec![None; n] };
    model.give_gains(&mut known, &request.gain)?;
    if request.load.is_none() && known.iter().all(Option::is_none) {
        return Err(Error::new(format_args!(
            "the logs hold currents and no gain of the {n} drives is known; give one with [gain={}=1.0] (the others \
             follow from it), all of them, or a known load with [load]",
            coordinates.last().map_or("q1", |c| c.as_str())
        )));
    }
    Ok(known.into_iter().map(|k| k.map_or(Gain::Free, Gain::Known)).collect())
}
