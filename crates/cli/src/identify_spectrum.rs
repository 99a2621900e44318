//! `rist identify --method rist|rist-mh`: the logs of a plan -> parameters.

use std::path::Path;

use identification::estimators::drive_gains::likelihood::Gain;
use identification::experiments::exciting_trajectory::ExcitingTrajectory;
use identification::experiments::experiment_plan::ExperimentPlan;
use identification::experiments::record::Record;
use identification::spectrum::experiment::SpectralExperiment;
use identification::spectrum::identify::{SpectralMethod, identify_spectrum};
use identification::spectrum::rist_mh::data::HarmonicOptions;
use logs::{ColumnNames, Effort, Log};

use crate::failure::{Failure, print, write_file};
use crate::model::ModelArguments;
use crate::spectrum::{Subject, read_text};

/// What says how great everything is.
pub struct Scale<'a> {
    /// `q3=1.0`, of the drives that are known.
    pub gain: &'a [String],
    /// The file of a known load.
    pub load: Option<&'a Path>,
}

/// Reads `<logs>/<experiment>.csv` for each experiment of the plan, and with a load `<experiment>_loaded.csv` where
/// it is there.
pub fn run(
    model: &ModelArguments,
    logs: &Path,
    plan: &Path,
    method: SpectralMethod,
    scale: &Scale,
    names: &ColumnNames,
    out: Option<&Path>,
) -> Result<(), Failure> {
    let subject = Subject::read(model)?;
    let regressor = subject.regressor.as_ref();
    let file = plan.display().to_string();
    let plan_of_file = ExperimentPlan::from_yaml(&file, &read_text(plan)?)?;
    subject.check(plan, &plan_of_file.model.name, &plan_of_file.model.fingerprint)?;
    let trajectories = plan_of_file.trajectories(&file)?;
    let mut experiments = Vec::new();
    let mut currents = false;
    let mut files = Vec::new();
    let mut read = |path: &Path, trajectory: ExcitingTrajectory| -> Result<SpectralExperiment, Failure> {
        let (log, _) = Log::read(path, regressor.coordinates(), names)?;
        currents |= log.effort_is == Effort::Current;
        files.push(path.display().to_string());
        experiment(path, &log, trajectory)
    };
    for (e, trajectory) in plan_of_file.experiments.iter().zip(&trajectories) {
        experiments.push(read(&logs.join(format!("{}.csv", e.name)), trajectory.clone())?);
    }
    let mut remark = None;
    if let Some(file) = scale.load {
        let (load, added) = subject.load(file)?;
        remark = Some(format!("the load of {}: {} kg on {}", file.display(), load.mass, load.link));
        let unloaded = experiments.len();
        for (e, trajectory) in plan_of_file.experiments.iter().zip(&trajectories) {
            let path = logs.join(format!("{}_loaded.csv", e.name));
            if path.exists() {
                experiments.push(read(&path, trajectory.clone())?.loaded(&added));
            }
        }
        if experiments.len() == unloaded {
            return Err(Failure::new(format_args!(
                "{}: no log of an experiment with the load (e01_loaded.csv, ..) in it",
                logs.display()
            )));
        }
    }
    let gains = gains(&subject, currents, scale)?;
    let options = HarmonicOptions::default();
    let mut estimate = identify_spectrum(&subject.reference, regressor, &experiments, method, &gains, &options)?;
    estimate.logs = files;
    estimate.remarks.extend(remark);
    print(&estimate.to_string())?;
    match out {
        Some(out) => write_file(out, &estimate.to_yaml()?),
        None => Ok(()),
    }
}

/// The experiment behind a log, whose clock must be the plan's and which must be long enough.
fn experiment(path: &Path, log: &Log, trajectory: ExcitingTrajectory) -> Result<SpectralExperiment, Failure> {
    let record = Record::from_log(log)?;
    if (record.sample_time / trajectory.sample_time - 1.0).abs() > 1e-3 {
        return Err(Failure::new(format_args!(
            "{}: sampled every {:.6} s, but the plan counts its periods in samples of {:.6} s",
            path.display(),
            record.sample_time,
            trajectory.sample_time
        )));
    }
    let (found, needed) = (log.len(), trajectory.windows().last().map_or(0, |w| w.end));
    SpectralExperiment::new(trajectory, &record).ok_or_else(|| {
        Failure::new(format_args!("{}: {found} samples; its experiment takes {needed} from its start", path.display()))
    })
}

/// Torques need no gains; currents need those of all drives, or of some, or a load.
fn gains(subject: &Subject, currents: bool, scale: &Scale) -> Result<Vec<Gain>, Failure> {
    let n = subject.regressor.coordinates().len();
    if !currents {
        return Ok(vec![Gain::Known(1.0); n]);
    }
    let of_file = scale.gain.is_empty() && scale.load.is_none();
    let mut known = if of_file { subject.drive_gains() } else { vec![None; n] };
    for text in scale.gain {
        let (k, gain) = subject.gain_of(text)?;
        known[k] = Some(gain);
    }
    if scale.load.is_none() && known.iter().all(Option::is_none) {
        return Err(Failure::new(format_args!(
            "the logs hold currents and no gain of the {n} drives is known; give one with --gain {}=1.0 (the others \
             follow from it), all of them, or a known load with --load",
            subject.regressor.coordinates().last().map_or("q1", |c| c.as_str())
        )));
    }
    Ok(known.into_iter().map(|k| k.map_or(Gain::Free, Gain::Known)).collect())
}
