//! A plan and a validation, for the page.

use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::experiment_plan::ExperimentPlan;
use experiments::plan::planned_experiment::PlannedExperiment;
use identification::estimate::validation::Validation;
use linear_model::artefact::Seal;
use serde::Serialize;

use crate::chart::Chart;
use crate::joints::Figure;
use crate::number::{percent, significant};

/// A plan of experiments.
#[derive(Serialize)]
pub(crate) struct PlanPart {
    summary: String,
    open: String,
    rows: Vec<Experiment>,
    motions: Vec<Figure>,
}

#[derive(Serialize)]
struct Experiment {
    name: String,
    kind: String,
    fast: String,
    slow: String,
    centre: String,
    rank: usize,
    gain: String,
}

/// The plan in words and rows.
pub(crate) fn plan(plan: &ExperimentPlan) -> PlanPart {
    let row = |e: &PlannedExperiment| Experiment {
        name: e.name.clone(),
        kind: e.kind.clone(),
        fast: e.fast.clone(),
        slow: e.slow.join(", "),
        centre: e.centre.iter().map(|q| format!("{q:.2}")).collect::<Vec<_>>().join(", "),
        rank: e.rank,
        gain: e.adds_log_det.map_or(String::new(), |g| format!("+{g:.2}")),
    };
    // A plan that was edited says so first.
    let open: Vec<String> = plan.unidentifiable().iter().map(|id| id.to_string()).collect();
    let origin = origin(plan.seal);
    PlanPart {
        summary: format!(
            "{origin}{} experiments out of {} candidates show {} of {} parameters. The plan is at least {} as good as the best of its \
             size (D-efficiency); its condition number is {:.1}, and no plan has less than {:.1}.",
            plan.experiments.len(),
            plan.candidates,
            plan.rank,
            plan.parameters.len(),
            percent(plan.d_efficiency_at_least),
            plan.cond_fro,
            plan.cond_fro_at_least
        ),
        open: open.join(", "),
        rows: plan.experiments.iter().map(row).collect(),
        motions: motions(plan),
    }
}

/// What the summary of a file begins with that is not as rist wrote it.
fn origin(seal: Seal) -> String {
    seal.said().map_or(String::new(), |said| format!("{}{}: ", said[..1].to_uppercase(), &said[1..]))
}

/// Points of a line that fills a small picture.
const POINTS_PER_LINE: usize = 120;

/// A chart of each motion: the positions of the joints that move, over one period of a swing or a sweep there and back.
/// There is none if a motion of the plan is invalid.
fn motions(plan: &ExperimentPlan) -> Vec<Figure> {
    let trajectories = plan.trajectories("").unwrap_or_default();
    let picture = |(experiment, trajectory): (&PlannedExperiment, &ExcitingTrajectory)| {
        let reference = trajectory.reference();
        let shown = match &experiment.swing {
            Some(swing) => reference.windows.first().map_or(0..0, |w| w.start..w.start + swing.period_samples + 1),
            None => 0..usize::MAX,
        };
        let shown = shown.start..shown.end.min(reference.q.first().map_or(0, Vec::len));
        let step = shown.len().div_ceil(POINTS_PER_LINE).max(1);
        let mut moving = trajectory.moving();
        moving.sort_by_key(|k| *k != trajectory.fast);
        let mut chart =
            Chart::new(format!("Motion {}", experiment.name), ("time, s", "from the centre, rad (m)")).small();
        for (k, class) in moving.iter().zip(["a", "b", "c", "d"]) {
            let at = |i: usize| {
                ((i - shown.start) as f64 * reference.sample_time, reference.q[*k][i] - trajectory.centre[*k])
            };
            let points: Vec<(f64, f64)> = shown.clone().step_by(step).map(at).collect();
            chart = chart.line(plan.coordinates[*k].clone(), class, &points);
        }
        Figure { caption: format!("{}, {}", experiment.name, experiment.kind.replace('_', " ")), svg: chart.svg() }
    };
    plan.experiments.iter().zip(&trajectories).map(picture).collect()
}

/// A validation.
#[derive(Serialize)]
pub(crate) struct ValidationPart {
    summary: String,
    rows: Vec<JointRow>,
    motions: Vec<(String, String)>,
    charts: Vec<Figure>,
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

/// The validation in words, rows and charts.
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
            origin(validation.seal),
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
        charts: pictures(validation)
            .into_iter()
            .map(|(_, chart)| Figure { caption: String::new(), svg: chart.svg() })
            .collect(),
        has_rigid: validation.joints.iter().any(|j| j.relative_rigid.is_some()),
        has_white: validation.joints.iter().any(|j| j.not_white.is_some()),
    }
}

/// Measured and predicted torque of each joint in the first motion: figure 2(a-c) of the paper.
pub(crate) fn pictures(validation: &Validation) -> Vec<(String, Chart<'static>)> {
    let picture = |p: &identification::estimate::validation::TorquePicture| {
        let points = |y: &[f64]| p.t.iter().copied().zip(y.iter().copied()).collect::<Vec<_>>();
        let joint = validation.joints.iter().find(|joint| joint.coordinate == p.coordinate);
        let unit = joint.map_or(String::new(), |joint| format!(", {}", joint.unit));
        let chart = Chart::new(format!("Torque of {}", p.coordinate), ("time, s", &format!("{}{unit}", p.coordinate)))
            .with_zero()
            .line("measured", "a", &points(&p.measured))
            .line("predicted", "b", &points(&p.predicted));
        (format!("torque_{}", p.coordinate), chart)
    };
    validation.pictures.iter().map(picture).collect()
}
