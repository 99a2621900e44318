//! Identifies robots from measured logs, as recipes prescribe, and compares the residuals with the residuals of an independent
//! program.
//!
//! A recipe names the logs in a folder, how they are read, what is fitted and predicted, and the residual that an independent
//! program (the baseline) reached with the same columns and the same split of the logs. The recipes are in tests/data/datasets;
//! the logs are not part of the repository.

use std::fmt;
use std::path::Path;
use std::time::Instant;

use serde::Deserialize;

use identification::estimate::consistent::{Consistency, identify_consistent};
use identification::estimate::held_out::validate;
use identification::estimate::identify::Fit;
use identification::estimate::options::Options;
use identification::estimate::residuals::Residuals;
use identification::signals::preparation::states;
use linear_model::linear_model::Model;
use linear_model::regressor::Regressor;
use logs::{Error, Log, Window};
use robot::{Drive, RotorInertia};

use crate::tape_robot::TapeRobot;
use crate::workspace;

/// A folder with logs of one robot, and the identifications for them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dataset {
    pub name: String,
    /// File of the robot description: in the folder, in models/ or in tests/data/robots/.
    pub model: String,
    /// Whether the rotor inertias of the joints are parameters.
    #[serde(default)]
    pub rotors: bool,
    pub runs: Vec<Run>,
}

/// An identification from some logs, and predictions of other logs with its estimate.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    pub title: String,
    #[serde(default)]
    pub options: Options,
    /// If given, physically consistent estimation is used instead of plain least squares.
    #[serde(default)]
    pub consistency: Option<Consistency>,
    pub train: Vec<LogFile>,
    #[serde(default)]
    pub validate: Vec<LogFile>,
    /// Relative residuals that the independent program (baseline) reached: in the training, then in each validation log. `None`
    /// if the baseline does not state it.
    #[serde(default)]
    pub baseline: Vec<Option<f64>>,
}

/// A log in the folder of the data set, or an interval of a log.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogFile {
    pub file: String,
    #[serde(default)]
    pub window: Option<Window>,
}

#[derive(Clone, Debug)]
pub struct Score {
    pub dataset: String,
    pub title: String,
    pub parameters: usize,
    pub condition_number: f64,
    /// Residuals of the training and of each validation, each with the names of the logs.
    pub residuals: Vec<(String, Residuals)>,
    pub baseline: Vec<Option<f64>>,
    pub seconds: f64,
    pub remarks: Vec<String>,
}

/// The recipes in tests/data/datasets: name and text.
const RECIPES: [(&str, &str); 5] = [
    ("panda_gaz2019", include_str!("../../data/datasets/panda_gaz2019.yaml")),
    ("tx40_staubli", include_str!("../../data/datasets/tx40_staubli.yaml")),
    ("ur10e_innopolis", include_str!("../../data/datasets/ur10e_innopolis.yaml")),
    ("cobot6_shanghai", include_str!("../../data/datasets/cobot6_shanghai.yaml")),
    ("kr300_kuka", include_str!("../../data/datasets/kr300_kuka.yaml")),
];

impl Dataset {
    /// Reads all recipes in tests/data/datasets.
    pub fn known() -> Result<Vec<Dataset>, Error> {
        RECIPES.iter().map(|(name, text)| Dataset::from_yaml(&format!("{name}.yaml"), text)).collect()
    }

    pub fn from_yaml(file: &str, text: &str) -> Result<Dataset, Error> {
        serde_yaml::from_str(text).map_err(|e| Error::at(file, 0, e.to_string()))
    }

    /// The robot of the recipe. `folder`: folder of the data set. Fails if there is no such description.
    pub fn robot(&self, folder: &Path) -> Result<TapeRobot, Error> {
        let places = [folder.to_path_buf(), workspace().join("models"), workspace().join("tests/data/robots")];
        let Some(file) = places.iter().map(|p| p.join(&self.model)).find(|p| p.is_file()) else {
            return Err(Error::new(format!(
                "{}: the description {} is neither in {} nor in models/ nor in tests/data/robots/",
                self.name,
                self.model,
                folder.display()
            )));
        };
        let mut robot = robot::format::read(&file).map_err(|e| Error::new(e.to_string()))?;
        for link in robot.links.iter_mut().filter(|l| l.joint.drive == Drive::Actuated) {
            link.joint.rotor_inertia = if self.rotors { RotorInertia::Unknown } else { RotorInertia::Absent };
        }
        Ok(TapeRobot::new(robot))
    }

    pub fn score(&self, folder: &Path, robot: &TapeRobot) -> Result<Vec<Score>, Error> {
        self.runs.iter().map(|run| self.run(run, folder, robot)).collect()
    }

    pub fn run(&self, run: &Run, folder: &Path, robot: &TapeRobot) -> Result<Score, Error> {
        let read = |log: &LogFile| -> Result<Log, Error> {
            let names = &run.options.columns;
            let (mut read, _) = Log::read(&folder.join(&log.file), robot.coordinates(), names)?;
            read.window = log.window;
            Ok(read)
        };
        let start = Instant::now();
        let logs = run.train.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let fit = Fit::of(robot, &logs, &run.options)?;
        let (estimate, x) = match run.consistency {
            None => (fit.estimate, fit.solution.x),
            Some(consistency) => {
                let fit =
                    identify_consistent(robot, &robot.map(), &robot.references(), &fit, &run.options, &consistency)?;
                (fit.estimate, fit.consistent.x)
            }
        };
        let seconds = start.elapsed().as_secs_f64();
        let couplings = run.options.transmission.coupled();
        let model = Model::new(robot, &run.options.friction, &couplings);
        // The residuals of the baseline (independent program) include rows at standstill. So these rows are also used here,
        // unless the recipe excludes them.
        let mut scored = run.options.clone();
        scored.signal.standstill.get_or_insert(0.0);
        let names = |logs: &[LogFile]| logs.iter().map(|l| l.file.as_str()).collect::<Vec<_>>().join(" + ");
        let score = |logs: &[Log]| -> Result<Residuals, Error> {
            let mut records = Vec::new();
            for log in logs {
                records.extend(states(robot, log, &scored.preparation())?);
            }
            validate(&model, &x, records.as_slice())
        };
        let mut residuals = vec![(names(&run.train), score(&logs)?)];
        for log in &run.validate {
            residuals.push((log.file.clone(), score(&[read(log)?])?));
        }
        Ok(Score {
            dataset: self.name.clone(),
            title: run.title.clone(),
            parameters: estimate.parameters.len(),
            condition_number: estimate.condition_number.unwrap_or(f64::NAN),
            residuals,
            baseline: run.baseline.clone(),
            seconds,
            remarks: estimate.remarks,
        })
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} | {} | {} parameters, condition {:.1}, {:.2} s",
            self.dataset, self.title, self.parameters, self.condition_number, self.seconds
        )?;
        for (i, (name, residual)) in self.residuals.iter().enumerate() {
            let joints: Vec<String> = residual.joints.iter().map(|j| format!("{:.3}", j.relative)).collect();
            let role = if i == 0 { "train" } else { "valid" };
            write!(f, "  {role} {} total {:.4}", joints.join(" "), residual.total)?;
            match self.baseline.get(i).copied().flatten() {
                Some(b) => writeln!(f, " (baseline {b:.4}: {:.2} of it)  {name}", residual.total / b)?,
                None => writeln!(f, "  {name}")?,
            }
        }
        self.remarks.iter().try_for_each(|r| writeln!(f, "  {r}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_recipes_can_be_read() {
        for dataset in Dataset::known().unwrap() {
            assert!(!dataset.runs.is_empty(), "{}", dataset.name);
            for run in dataset.runs {
                assert!(run.baseline.len() <= 1 + run.validate.len(), "{}", run.title);
            }
        }
    }
}
