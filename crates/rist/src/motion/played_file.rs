//! Reads and checks a file with motions for a robot: a motion of `rist excite`, a plan of `rist plan`, or points from another
//! source.
//!
//! The result has one proof per motion in the file. If the file is a plan with a proof of its D-efficiency (information
//! compared with the best possible plan), this proof is repeated too. Readers of points from other sources are registered by
//! another package.

use std::path::Path;
use std::sync::OnceLock;

use experiments::excitation::artefact::ExcitingMotion;
use experiments::motion::point_trajectory::{Interpolation, PointTrajectory};
use experiments::plan::experiment_plan::ExperimentPlan;
use linear_model::artefact::ArtefactKind;
use report::experiments::PlanProof;
use robot::format::read_text;

use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::checking::{Checked, check};
use crate::motion::checking_trajectories::{check_experiments, check_points, efficiency_again};
use crate::request::CheckRequest;

/// The content of a file with motions for a robot.
pub enum PlayedFile {
    /// A motion of `rist excite`.
    Motion(Box<ExcitingMotion>),
    /// A plan of `rist plan`.
    Plan(Box<ExperimentPlan>),
    /// Points of a JointTrajectory of ROS.
    Points(Box<PointTrajectory>),
    /// Points of a table, or of a recording that is a folder.
    Table(Box<PointTrajectory>),
}

/// Extensions of text files. A file with another extension is read as a table.
const TEXTS: [&str; 3] = ["yaml", "yml", "json"];
/// The D-efficiency that a file states may exceed the bound from its proof by at most this value, which is rounding.
const EFFICIENCY_ROUNDING: f64 = 1e-9;

/// The repeated check of the D-efficiency that a plan's file states.
pub struct ProofCheck {
    /// The lower bound of the D-efficiency that follows from the proof in the file; `None` if the file has no proof.
    pub found: Option<f64>,
    /// Whether the stated D-efficiency is at most the bound `found`, up to rounding. True if the file has no proof.
    pub is_kept: bool,
    /// A sentence that compares the bound with the stated value.
    pub sentence: String,
}

/// The result of a repeated proof of all motions in a file.
pub struct CheckedFile {
    /// The results with their names: one result per experiment of a plan; otherwise a single result with an empty name.
    pub parts: Vec<(String, Checked)>,
    /// Remarks on the file itself.
    pub notes: Vec<String>,
    /// The check of the D-efficiency; `None` if the file is no plan.
    pub worth: Option<ProofCheck>,
}

impl CheckedFile {
    /// The reasons why the file is not accepted, as sentences; empty if it is accepted.
    pub fn faults(&self) -> Vec<String> {
        let of = |(name, checked): &(String, Checked)| -> Vec<String> {
            let with_name = |fault: String| if name.is_empty() { fault } else { format!("{name}: {fault}") };
            checked.faults().into_iter().map(with_name).collect()
        };
        let worth = self.worth.iter().filter(|worth| !worth.is_kept).map(|worth| worth.sentence.clone());
        self.parts.iter().flat_map(of).chain(worth).collect()
    }
}

/// Functions that read points from other sources. Another package registers these functions.
#[derive(Clone, Copy)]
pub struct PointReader {
    /// Reads the points of a table, for the coordinates of a model.
    pub of_table: fn(&Model, &Path) -> Result<PointTrajectory, Error>,
    /// Reads the text of a JointTrajectory; arguments: name of the file, text.
    pub of_ros: fn(&str, &str) -> Result<PointTrajectory, logs::Error>,
}

static POINTS: OnceLock<Result<PointReader, &'static str>> = OnceLock::new();

/// Registers the readers of points, or the error text if this build does not contain them. Only the first call has an effect.
pub(crate) fn register(points: Result<PointReader, &'static str>) {
    POINTS.get_or_init(|| points);
}

/// The registered readers of points; `path` is named in messages.
fn point_reader(path: &Path) -> Result<PointReader, Error> {
    let reader = POINTS.get().copied().unwrap_or(Err("no reader of points is registered"));
    reader.map_err(|why| Error::new(format_args!("{}: points that others made: {why}", path.display())))
}

impl PlayedFile {
    /// Reads a file. The kind of the file follows from its extension and content.
    ///
    /// Fails if the file has none of the known formats.
    pub fn read(model: &Model, path: &Path) -> Result<PlayedFile, Error> {
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        if extension.is_some_and(|extension| !TEXTS.contains(&extension.as_str())) || path.is_dir() {
            let points = (point_reader(path)?.of_table)(model, path)?;
            return Ok(PlayedFile::Table(Box::new(points)));
        }
        let (file, text) = (path.display().to_string(), read_text(path)?);
        let begins = |word: &str| text.lines().any(|line| line.starts_with(word));
        Ok(match ArtefactKind::of(&text) {
            Some(ArtefactKind::Plan) => PlayedFile::Plan(Box::new(ExperimentPlan::from_yaml(&file, &text)?)),
            None if text.contains("joint_names") => {
                PlayedFile::Points(Box::new((point_reader(path)?.of_ros)(&file, &text)?))
            }
            // Files of earlier versions have no first line that states the kind. So the kind follows from the keys of the file.
            None if begins("experiments:") => PlayedFile::Plan(Box::new(ExperimentPlan::from_yaml(&file, &text)?)),
            _ => PlayedFile::Motion(Box::new(ExcitingMotion::from_yaml(&file, &text)?)),
        })
    }

    /// Proves again that the motions of the file keep their limits. `file` is named in messages.
    ///
    /// Fails like [`check`], [`check_points`] and [`check_experiments`], and if an interpolation is given for a file that
    /// defines its motion completely.
    pub fn check(
        &self,
        model: &Model,
        file: &Path,
        interpolation: Option<Interpolation>,
        request: &CheckRequest,
    ) -> Result<CheckedFile, Error> {
        let says_itself = matches!(self, PlayedFile::Motion(_) | PlayedFile::Plan(_));
        if interpolation.is_some() && says_itself {
            let what = if matches!(self, PlayedFile::Plan(_)) { "plan" } else { "motion" };
            return Err(Error::new(format_args!("{}: a {what} says itself how it moves", file.display())));
        }
        let one = |checked: Checked| CheckedFile { parts: vec![(String::new(), checked)], notes: vec![], worth: None };
        match self {
            PlayedFile::Motion(motion) => Ok(one(check(model, file, motion, request)?)),
            PlayedFile::Points(points) | PlayedFile::Table(points) => {
                Ok(one(check_points(model, file, (**points).clone(), interpolation, request)?))
            }
            PlayedFile::Plan(plan) => Ok(CheckedFile {
                parts: check_experiments(model, file, plan, request)?,
                notes: plan.checksum.note(file.display()).into_iter().collect(),
                worth: Some(proof_check(plan, efficiency_again(model, file, plan)?)),
            }),
        }
    }
}

/// Repeats the proofs of a plan for a page of the report.
///
/// Fails like [`PlayedFile::check`].
pub fn plan_proof(model: &Model, file: &Path, plan: &ExperimentPlan) -> Result<PlanProof, Error> {
    let checked = PlayedFile::Plan(Box::new(plan.clone())).check(model, file, None, &CheckRequest::default())?;
    let stands = |(name, checked): &(String, Checked)| (name.clone(), checked.claims().to_string());
    Ok(PlanProof {
        worth: checked.worth.as_ref().map(|worth| worth.sentence.clone()).unwrap_or_default(),
        experiments: checked.parts.iter().map(stands).collect(),
        is_kept: checked.faults().is_empty(),
    })
}

fn proof_check(plan: &ExperimentPlan, found: Option<f64>) -> ProofCheck {
    let said = plan.d_efficiency_at_least;
    // The D-efficiency in the file may exceed the repeated proof only by rounding.
    let is_kept = found.is_none_or(|found| found >= said - EFFICIENCY_ROUNDING);
    let sentence = match found {
        Some(found) if is_kept => format!("proven again: D-efficiency at least {found:.4}"),
        Some(found) => format!("BROKEN: the file says D-efficiency at least {said:.4}; its proof gives {found:.4}"),
        None => format!("the file says: D-efficiency at least {said:.4}; it has no proof that could be found again"),
    };
    ProofCheck { found, is_kept, sentence }
}
