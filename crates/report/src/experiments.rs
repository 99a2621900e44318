//! The page sections on an experiment plan and on a validation.
//!
//! A plan is a list of experiments (motions) for an identification; a validation compares measured and predicted torques on
//! motions that were not fitted. Both sections consist of sentences, table rows and charts. The checksum in the first line of a
//! plan file shows whether somebody edited the file.

use experiments::motion::reference_motion::Reference;
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::experiment_plan::ExperimentPlan;
use experiments::plan::planned_experiment::PlannedExperiment;
use identification::estimate::validation::{TorquePicture, Validation};
use identification::plot_data::envelope::Envelope;
use linear_model::artefact::Checksum;
use serde::Serialize;

use crate::chart::Chart;
use crate::joints::ChartFigure;
use crate::number::{percent, significant};
use crate::plot::Plot;
use crate::timeline::Timeline;

/// Sentences on the proofs of a plan. The proofs were repeated with the robot's model.
#[derive(Clone, Debug)]
pub struct PlanProof {
    /// Sentence on the proven lower bound of the plan's D-efficiency.
    pub worth: String,
    /// For each experiment: its name, and a sentence on its limits.
    pub experiments: Vec<(String, String)>,
    /// Whether all statements about the plan are proven.
    pub is_kept: bool,
}

/// The section on an experiment plan.
#[derive(Serialize)]
pub(crate) struct PlanPart {
    summary: String,
    worth: String,
    is_kept: bool,
    proofs: Vec<(String, String)>,
    open: String,
    rows: Vec<Experiment>,
    motions: Vec<ChartFigure>,
}

#[derive(Serialize)]
struct Experiment {
    name: String,
    kind: String,
    fast: String,
    slow: String,
    centre: String,
    duration: String,
    rank: usize,
    gain: String,
}

/// Makes the page section on a plan: sentences, table rows and charts. With `proof`, the section has the sentences of this new
/// proof. Without `proof`, it says that its numbers are from the plan file and that nobody proved them for this page.
pub(crate) fn plan(plan: &ExperimentPlan, proof: Option<&PlanProof>) -> PlanPart {
    let trajectories = plan.trajectories("").unwrap_or_default();
    let duration = |k: usize| trajectories.get(k).map(|t| seconds(&t.reference()));
    let row = |(k, e): (usize, &PlannedExperiment)| Experiment {
        duration: duration(k).map_or("-".into(), |s| format!("{} s", significant(s, 3))),
        name: e.name.clone(),
        kind: e.kind.clone(),
        fast: e.fast.clone(),
        slow: e.slow.join(", "),
        centre: e.centre.iter().map(|q| format!("{q:.2}")).collect::<Vec<_>>().join(", "),
        rank: e.rank,
        gain: e.adds_log_det.map_or(String::new(), |g| format!("+{g:.2}")),
    };
    // If the checksum of the plan file is wrong or missing, the summary starts with a warning (`origin`).
    let open: Vec<String> = plan.unidentifiable().iter().map(|id| id.to_string()).collect();
    let origin = origin(plan.checksum);
    PlanPart {
        summary: format!(
            "{origin}{} experiments out of {} candidates. The file says that they show {} of {} parameters, and that their \
             condition number is {:.1}, while no plan has less than {:.1}.",
            plan.experiments.len(),
            plan.candidates,
            plan.rank,
            plan.parameters.len(),
            plan.cond_fro,
            plan.cond_fro_at_least
        ),
        worth: match proof {
            Some(proof) => format!("Found again from the plan and the model: {}.", proof.worth),
            None => format!(
                "The file says that the plan is at least {} as good as the best of its size (D-efficiency). Nobody proved it or the \
                 limits of the experiments for this page; rist check does, from the plan and the model.",
                percent(plan.d_efficiency_at_least)
            ),
        },
        is_kept: proof.is_none_or(|proof| proof.is_kept),
        proofs: proof.map(|proof| proof.experiments.clone()).unwrap_or_default(),
        open: open.join(", "),
        rows: plan.experiments.iter().enumerate().map(row).collect(),
        motions: motions(plan),
    }
}

/// A warning before the summary, if the checksum in the first line of the plan file is missing or wrong. The checksum is wrong
/// if somebody edited the file after rist wrote it. The text is empty if the checksum is right.
fn origin(checksum: Checksum) -> String {
    checksum.said().map_or(String::new(), |said| format!("{}{}: ", said[..1].to_uppercase(), &said[1..]))
}

/// Number of points per line in a small chart.
const POINTS_PER_LINE: usize = 120;

/// Duration of a reference motion, s.
fn seconds(reference: &Reference) -> f64 {
    reference.q.first().map_or(0, Vec::len) as f64 * reference.sample_time
}

/// One chart per experiment of the plan, with the positions of all joints. A swing (periodic motion) is drawn over one period, a
/// sweep (slow motion through the range) from start to end and back. Empty if an experiment is invalid.
fn motions(plan: &ExperimentPlan) -> Vec<ChartFigure> {
    let trajectories = plan.trajectories("").unwrap_or_default();
    let picture = |(experiment, trajectory): (&PlannedExperiment, &ExcitingTrajectory)| {
        let reference = trajectory.reference();
        let shown = match &experiment.swing {
            Some(swing) => reference.windows.first().map_or(0..0, |w| w.start..w.start + swing.period_samples + 1),
            None => 0..usize::MAX,
        };
        let shown = shown.start..shown.end.min(reference.q.first().map_or(0, Vec::len));
        let step = shown.len().div_ceil(POINTS_PER_LINE).max(1);
        // Order of the lines: the fast joint (which the experiment excites), the other moving joints, the joints at rest. The
        // legend names all of them.
        let moving = trajectory.moving();
        let mut all: Vec<usize> = (0..plan.coordinates.len().min(reference.q.len())).collect();
        all.sort_by_key(|k| (*k != trajectory.fast, !moving.contains(k)));
        let mut chart = Chart::new(format!("Motion {}", experiment.name), ("time, s", "position, rad (m)"));
        for (k, class) in all.iter().zip(["a", "b", "c", "d"].into_iter().cycle()) {
            let at = |i: usize| ((i - shown.start) as f64 * reference.sample_time, reference.q[*k][i]);
            let points: Vec<(f64, f64)> = shown.clone().step_by(step).map(at).collect();
            let rests = if moving.contains(k) { "" } else { " (rests)" };
            chart = chart.line(format!("{}{rests}", plan.coordinates[*k]), class, &points);
        }
        ChartFigure { caption: format!("{}, {}", experiment.name, experiment.kind.replace('_', " ")), svg: chart.svg() }
    };
    plan.experiments.iter().zip(&trajectories).map(picture).collect()
}

/// The section on a validation.
#[derive(Serialize)]
pub(crate) struct ValidationPart {
    summary: String,
    rows: Vec<JointRow>,
    motions: Vec<(String, String)>,
    /// For each joint, the plots of its torques in the first validation motion, as HTML.
    plots: Vec<String>,
    has_rigid: bool,
    has_white: bool,
}

#[derive(Serialize)]
struct JointRow {
    name: String,
    error: String,
    rigid: String,
    rms: String,
    not_white: String,
}

/// Makes the section on a validation: sentences, rows and charts.
pub(crate) fn validation(validation: &Validation) -> ValidationPart {
    let or = |x: Option<f64>| x.map_or("-".into(), percent);
    let row = |j: &identification::estimate::validation::JointValidation| JointRow {
        name: j.coordinate.clone(),
        error: percent(j.relative),
        rigid: or(j.relative_rigid),
        rms: format!("{} {}", significant(j.rms, 3), j.unit),
        not_white: or(j.not_white),
    };
    ValidationPart {
        summary: format!(
            "{}{} that the estimate was not made from {} predicted with an error of {}; {}.",
            origin(validation.checksum),
            match validation.motions.len() {
                1 => "1 motion".into(),
                n => format!("{n} motions"),
            },
            if validation.motions.len() == 1 { "is" } else { "are" },
            percent(validation.total),
            validation.cutoff_hz.map_or("no low-pass".into(), |hz| format!("low-pass {} Hz", significant(hz, 3)))
        ),
        rows: validation.joints.iter().map(row).collect(),
        motions: validation.motions.iter().map(|m| (m.name.clone(), percent(m.relative))).collect(),
        plots: plots(validation),
        has_rigid: validation.joints.iter().any(|j| j.relative_rigid.is_some()),
        has_white: validation.joints.iter().any(|j| j.not_white.is_some()),
    }
}

/// Three lines of a joint in the first validation motion: measured torque, predicted torque, residual.
fn lines(picture: &TorquePicture) -> [Envelope; 3] {
    let left = picture.measured.iter().zip(&picture.predicted).map(|(a, b)| a - b).collect::<Vec<_>>();
    [&picture.measured, &picture.predicted, &left].map(|values| {
        let mut line = Envelope::of_spans(MOST_SPANS);
        picture.t.iter().zip(values).for_each(|(t, value)| line.push(*t, *value));
        line
    })
}

/// Largest number of time spans per line. It gives enough detail for zooming in.
const MOST_SPANS: usize = 2000;

/// First letters of the keys by which the script finds a joint's lines: measured, predicted, residual.
const KEYS: [&str; 3] = ["m", "p", "r"];

/// Name of the time axis of the first validation motion, as used by the script of the page.
pub(crate) const VALIDATION_TIME: &str = "validation";

/// The torque lines of a validation, encoded for the script of the page; `None` if there are no plots.
pub(crate) fn timeline(validation: &Validation) -> Option<Timeline> {
    let lines: Vec<[Envelope; 3]> = validation.pictures.iter().map(lines).collect();
    let keys = (0..lines.len()).flat_map(|k| KEYS.map(|key| format!("{key}{k}")));
    Timeline::new(keys.zip(lines.iter().flatten()))
}

fn plots(validation: &Validation) -> Vec<String> {
    let plot = |(k, picture): (usize, &TorquePicture)| {
        let lines = lines(picture);
        let spans = lines[0].spans();
        let span = spans.first().zip(spans.last()).map_or((0.0, 1.0), |(a, b)| (a.t, b.end));
        let [torque, residual] = charts(validation, picture, &lines).map(|chart| chart.wide(span));
        let [m, p, r] = KEYS.map(|key| format!("{key}{k}"));
        let svgs = vec![torque.live(vec![m.clone(), p.clone()]).svg(), residual.low().live(vec![r.clone()]).svg()];
        let names = [(m, "a", "measured"), (p, "b", "predicted"), (r, "d", "residual")];
        let legend = names.map(|(key, class, name)| (key, class, name.to_string())).into();
        let caption = format!("Torque of {}, and its residual", picture.coordinate);
        Plot { time: VALIDATION_TIME, caption, legend, svgs }.html()
    };
    validation.pictures.iter().enumerate().map(plot).collect()
}

/// Two charts of a joint, torque and residual, as in figure 2(a-c) of [Vandanjon, Gautier, Desbats 1995].
fn charts<'a>(validation: &Validation, picture: &TorquePicture, lines: &'a [Envelope; 3]) -> [Chart<'a>; 2] {
    let joint = validation.joints.iter().find(|joint| joint.coordinate == picture.coordinate);
    let unit = joint.map_or(String::new(), |joint| format!(", {}", joint.unit));
    let [measured, predicted, left] = lines;
    let chart = |title: &str| {
        let axis = format!("{}{unit}", picture.coordinate);
        Chart::new(format!("{title} of {}", picture.coordinate), ("time, s", &axis)).with_zero()
    };
    [
        chart("Torque").envelope("measured", "a", measured).envelope("predicted", "b", predicted),
        chart("Residual").envelope("measured − predicted", "d", left),
    ]
}

/// The charts of a validation for a folder of pictures: file name and SVG of each.
pub(crate) fn pictures(validation: &Validation) -> Vec<(String, String)> {
    let of_joint = |picture: &TorquePicture| {
        let lines = lines(picture);
        let svgs = charts(validation, picture, &lines).map(|chart| chart.alone());
        let names = ["torque", "residual"].map(|what| format!("{what}_{}", picture.coordinate));
        names.into_iter().zip(svgs).collect::<Vec<_>>()
    };
    validation.pictures.iter().flat_map(of_joint).collect()
}
