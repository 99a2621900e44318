//! `rist identify --method rist|rist-mh`: the logs of a plan -> parameters.

use std::path::Path;

use identification::{
    ColumnNames, Effort, ExperimentPlan, Gains, HarmonicOptions, Log, Record, SpectralExperiment, SpectralMethod,
    identify_spectrum,
};

use crate::failure::{Failure, print, write_file};
use crate::model::ModelArguments;
use crate::spectrum::{Subject, read_text};

/// Reads `<logs>/<experiment>.csv` for each experiment of the plan. `gain`: `q3=1.0`, of the drives that are known.
pub fn run(
    model: &ModelArguments,
    logs: &Path,
    plan: &Path,
    method: SpectralMethod,
    gain: &[String],
    names: &ColumnNames,
    out: Option<&Path>,
) -> Result<(), Failure> {
    let subject = Subject::read(model)?;
    let regressor = subject.regressor.as_ref();
    let file = plan.display().to_string();
    let plan_of_file = ExperimentPlan::from_yaml(&file, &read_text(plan)?)?;
    subject.check(plan, &plan_of_file.model.name, &plan_of_file.model.fingerprint)?;
    let mut experiments = Vec::new();
    let mut currents = false;
    let mut files = Vec::new();
    for (e, trajectory) in plan_of_file.experiments.iter().zip(plan_of_file.trajectories(&file)?) {
        let path = logs.join(format!("{}.csv", e.name));
        let (log, _) = Log::read(&path, regressor.coordinates(), names)?;
        currents |= log.effort_is == Effort::Current;
        let record = Record::from_log(&log)?;
        if (record.sample_time / trajectory.sample_time - 1.0).abs() > 1e-3 {
            return Err(Failure::new(format_args!(
                "{}: sampled every {:.6} s, but the plan counts its periods in samples of {:.6} s",
                path.display(),
                record.sample_time,
                trajectory.sample_time
            )));
        }
        let (found, needed) = (log.len(), trajectory.windows().last().map_or(0, |w| w.end));
        let Some(experiment) = SpectralExperiment::new(trajectory, &record) else {
            return Err(Failure::new(format_args!(
                "{}: {found} samples; experiment {} takes {needed} from its start",
                path.display(),
                e.name
            )));
        };
        experiments.push(experiment);
        files.push(path.display().to_string());
    }
    let gains = gains(&subject, currents, gain)?;
    let options = HarmonicOptions::default();
    let mut estimate = identify_spectrum(&subject.reference, regressor, &experiments, method, &gains, &options)?;
    estimate.logs = files;
    print(&estimate.to_string())?;
    match out {
        Some(out) => write_file(out, &estimate.to_yaml()?),
        None => Ok(()),
    }
}

/// Torques need no gains; currents need those of all drives, or of one.
fn gains(subject: &Subject, currents: bool, given: &[String]) -> Result<Gains, Failure> {
    let n = subject.regressor.coordinates().len();
    if !currents {
        return Ok(Gains::Known(vec![1.0; n]));
    }
    let mut known = if given.is_empty() { subject.drive_gains() } else { vec![None; n] };
    for text in given {
        let (k, gain) = subject.gain_of(text)?;
        known[k] = Some(gain);
    }
    if let Some(all) = known.iter().copied().collect::<Option<Vec<f64>>>() {
        return Ok(Gains::Known(all));
    }
    match known.iter().enumerate().filter_map(|(k, g)| g.map(|g| (k, g))).collect::<Vec<_>>().as_slice() {
        [(joint, gain)] => Ok(Gains::Reference { joint: *joint, gain: *gain }),
        some => Err(Failure::new(format_args!(
            "the logs hold currents and the gains of {} of {n} drives are known; give one with --gain {}=1.0 (the others \
             follow from it) or all of them",
            some.len(),
            subject.regressor.coordinates().last().map_or("q1", |c| c.as_str())
        ))),
    }
}
