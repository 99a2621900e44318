//! Makes the report page of an identification.
//!
//! Input: what is known on the identification ([`Page`]), each part optional: robot, plan, motion, estimate, plot data of the
//! logs, validation, verdict. Output: one HTML file with a section for each part, and its charts as SVG. The script of the page
//! redraws the lines over time; it finds the data of a line by the name of the time axis (logs, motion, validation) and by the
//! key of the line.

use ::experiments::plan::experiment_plan::ExperimentPlan;
use gate::shown;
use identification::estimate::artefact::Estimate;
use identification::estimate::validation::Validation;
use identification::estimate::verdict::{Trust, UseVerdict, Verdict, claim_line};
use identification::plot_data::envelope::DRAWN_SPANS;
use identification::plot_data::{JointPlotData, PlotData};
use serde::Serialize;

use crate::chart::Chart;
use crate::compact::compact;
use crate::comparison::{Comparison, OtherEstimate, comparison};
use crate::drawing::Drawing;
use crate::excitation::{self, MOTION_TIME, MotionPart, ShownMotion};
use crate::experiments::{self, PlanPart, PlanProof, VALIDATION_TIME, ValidationPart};
use crate::grades::{self, Grades, class};
use crate::information::{self, MapPart};
use crate::joints::{self, JointSection, LOG_TIME};
use crate::motion::{self, Used};
use crate::number::{percent, significant};
pub use crate::parameters::Subject;
use crate::parameters::{self, LinkParameters};
use crate::template::rendered;

const STYLE: &str = concat!(
    include_str!("../templates/page.css"),
    include_str!("../templates/chart.css"),
    include_str!("../templates/drawing.css")
);

/// The content of the page. Sections for `None` are omitted.
#[derive(Clone, Copy, Default)]
pub struct Page<'a> {
    /// The robot. It gives regrouping rules, parameter meanings, limits and nominal values.
    pub subject: Option<Subject<'a>>,
    /// The plan of the experiments.
    pub plan: Option<&'a ExperimentPlan>,
    /// The repeated proofs of the plan.
    pub plan_proof: Option<&'a PlanProof>,
    /// The exciting motion with its plot data.
    pub motion: Option<ShownMotion<'a>>,
    /// The estimate of the parameters.
    pub estimate: Option<&'a Estimate>,
    /// Another estimate with which `estimate` is compared.
    pub against: Option<OtherEstimate<'a>>,
    /// Data for plots of logged and predicted torques.
    pub plot_data: Option<&'a PlotData>,
    /// The prediction errors of the estimate on logs that were not fitted.
    pub validation: Option<&'a Validation>,
    /// The verdict: whether the estimate can be trusted.
    pub verdict: Option<&'a Verdict>,
    /// Date, program version and command, which the page shows.
    pub origin: Origin<'a>,
}

/// Date, program version, command line and model file of a page.
#[derive(Clone, Copy, Default)]
pub struct Origin<'a> {
    /// The date as the user gave it; `None` without a date.
    pub date: Option<&'a str>,
    /// Version of rist.
    pub version: &'a str,
    /// The command line that made the page.
    pub command: &'a str,
    /// Path of the robot description; `None` if there is no description.
    pub model: Option<&'a str>,
}

impl Origin<'_> {
    /// The known facts, each with a heading and a text.
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        let made = if self.version.is_empty() { String::new() } else { format!("rist {}", self.version) };
        let facts = [
            ("date", self.date.unwrap_or_default().into()),
            ("description", self.model.unwrap_or_default().into()),
            ("command", self.command.into()),
            ("made with", made),
        ];
        facts.into_iter().filter(|(_, text): &(_, String)| !text.is_empty()).collect()
    }
}

#[derive(Serialize)]
struct IdentificationContext {
    style: &'static str,
    script: String,
    name: String,
    title: String,
    kind: &'static str,
    /// For each time axis: its name, and its lines as JSON. The JSON is escaped so that it cannot end the script element of the
    /// page.
    times: Vec<(&'static str, String)>,
    /// The drawing of the robot as HTML, and the name of the time axis by which it moves.
    drawing: Option<(String, &'static str)>,
    has_nominal: bool,
    verdict: Option<VerdictPart>,
    plot_data: Option<PlotPart>,
    estimate: Option<EstimatePart>,
    plan: Option<PlanPart>,
    motion: Option<MotionPart>,
    validation: Option<ValidationPart>,
    facts: Vec<(&'static str, String)>,
}

#[derive(Serialize)]
struct PlotPart {
    joints: Vec<JointSection>,
    part_names: [&'static str; 4],
    logs: Vec<String>,
    /// Number of samples per time span of the drawn lines; `None` if each span is a single sample.
    thinned: Option<usize>,
    used: Vec<Used>,
    map: Option<MapPart>,
}

#[derive(Serialize)]
struct EstimatePart {
    count: usize,
    method: String,
    total: Option<String>,
    held_out: Option<String>,
    groups: Vec<LinkParameters>,
    has_rules: bool,
    comparison: Option<Comparison>,
    directions: Vec<DirectionPart>,
    condition: Option<String>,
    tenths: Vec<Tenth>,
    remarks: Vec<String>,
}

#[derive(Serialize)]
struct VerdictPart {
    word: &'static str,
    class: &'static str,
    found: String,
    reasons: Vec<String>,
    next: String,
    uses: Vec<UsePart>,
    /// One sentence per claim that the data do not contradict.
    claims: Vec<String>,
    grades: Option<Grades>,
}

#[derive(Serialize)]
struct UsePart {
    name: String,
    word: &'static str,
    class: &'static str,
    error: Option<String>,
}

#[derive(Serialize)]
struct DirectionPart {
    sentence: String,
    strength: String,
    members: String,
    is_open: bool,
}

#[derive(Serialize)]
struct Tenth {
    error: String,
    share: f64,
}

impl Page<'_> {
    /// The whole page as HTML.
    pub fn html(&self) -> String {
        rendered(include_str!("../templates/identification.html"), self.content())
    }

    /// The charts of the page as separate pictures: file name and SVG of each.
    pub fn pictures(&self) -> Vec<(String, String)> {
        let of_logs = self.plot_data.map(|p| joints::pictures(p, self.estimate)).unwrap_or_default();
        let of_validation = self.validation.map(experiments::pictures).unwrap_or_default();
        let of_logs = of_logs.into_iter().map(|(name, chart): (String, Chart)| (name, chart.alone()));
        let of_excitation = self.motion.map(excitation::pictures).unwrap_or_default();
        let mut files: Vec<(String, String)> = Vec::new();
        for (name, svg) in of_logs.chain(of_validation).chain(of_excitation) {
            // Two joint names may differ only in characters that file names cannot contain. The file names are then equal, so
            // the second gets an underscore.
            let mut name = shown::file_name(&name);
            while files.iter().any(|(file, _)| *file == format!("{name}.svg")) {
                name.push('_');
            }
            files.push((format!("{name}.svg"), svg));
        }
        files
    }

    fn content(&self) -> IdentificationContext {
        let kind = self.kind();
        let times = self.times();
        let drawing = self.drawing(&times);
        let plot_data = self.plot_data.map(|plot_data| self.plot_part(plot_data));
        let has_map = plot_data.as_ref().is_some_and(|part| part.map.is_some());
        IdentificationContext {
            style: STYLE,
            script: self.script(!times.is_empty(), has_map, drawing.is_some()),
            name: self.name(),
            title: kind.to_lowercase(),
            kind,
            times,
            drawing,
            has_nominal: self.subject.is_some_and(|s| s.described.is_some()),
            verdict: self.verdict.map(|found| verdict(found, self.estimate)),
            plot_data,
            estimate: self.estimate.map(|estimate| self.estimate_part(estimate)),
            plan: self.plan.map(|plan| experiments::plan(plan, self.plan_proof)),
            motion: self.motion.map(excitation::motion),
            validation: self.validation.map(experiments::validation),
            facts: self.facts(),
        }
    }

    fn plot_part(&self, plot_data: &PlotData) -> PlotPart {
        // Number of samples per time span in charts that the script does not redraw.
        let thinned = |j: &JointPlotData| j.measured.thinned_to(DRAWN_SPANS).samples_of_a_span();
        PlotPart {
            joints: joints::joints(plot_data, self.estimate),
            part_names: identification::plot_data::split::TORQUE_PART_NAMES,
            logs: plot_data.logs.iter().map(|log| log.name.clone()).collect(),
            thinned: plot_data.joints.iter().map(thinned).max().filter(|n| *n > 1),
            used: motion::used(plot_data, self.subject.map(|s| s.robot)),
            map: information::map(plot_data),
        }
    }

    fn estimate_part(&self, estimate: &Estimate) -> EstimatePart {
        EstimatePart {
            count: estimate.parameters.len(),
            method: estimate.method.clone(),
            total: estimate.total.map(percent),
            held_out: estimate.cross_validation.map(percent),
            groups: parameters::groups(estimate, self.subject),
            has_rules: self.subject.is_some(),
            comparison: self.against.map(|other| comparison(estimate, other)),
            directions: directions(estimate),
            condition: estimate.condition_number.filter(|x| x.is_finite()).map(|x| format!("{x:.0}")),
            tenths: tenths(estimate),
            remarks: estimate.remarks.clone(),
        }
    }

    /// The heading of the page. The page can have an estimate, a validation, a motion and a plan; the first of these in this
    /// order determines the heading.
    fn kind(&self) -> &'static str {
        match (self.estimate, self.validation, self.motion, self.plan) {
            (Some(_), ..) if self.against.is_some() => "Two estimates compared",
            (Some(estimate), ..) if estimate.options.is_none() => "Identified dynamics, from experiments",
            (Some(_), ..) => "Identified dynamics",
            (None, Some(_), ..) => "Validation",
            (None, None, Some(_), _) => "Exciting motion",
            (None, None, None, Some(_)) => "Plan of experiments",
            (None, None, None, None) => "Robot",
        }
    }

    /// For each time axis of the page, its name and its lines as JSON.
    fn times(&self) -> Vec<(&'static str, String)> {
        let of_logs = self.plot_data.and_then(joints::timeline);
        let of_motion = self.motion.and_then(excitation::timeline);
        let of_validation = self.validation.and_then(experiments::timeline);
        let all = [(LOG_TIME, of_logs), (MOTION_TIME, of_motion), (VALIDATION_TIME, of_validation)];
        all.into_iter().filter_map(|(name, time)| Some((name, time?.to_json()))).collect()
    }

    /// The drawing of the robot, and the name of the time axis by which it moves: the logs, or else the exciting motion. `None`
    /// for a robot with numerically solved loops, because only the page of the robot itself has the script that closes such
    /// loops.
    fn drawing(&self, times: &[(&'static str, String)]) -> Option<(String, &'static str)> {
        let along = [LOG_TIME, MOTION_TIME].into_iter().find(|name| times.iter().any(|time| time.0 == *name))?;
        let robot = self.subject.map(|s| s.robot).filter(|robot| robot.passive.is_empty())?;
        Some((Drawing::new(robot, &[])?.html(), along))
    }

    /// The scripts that the sections of this page need.
    fn script(&self, has_times: bool, has_map: bool, has_drawing: bool) -> String {
        let parts = [
            (true, include_str!("../templates/dom.js")),
            (self.estimate.is_some(), include_str!("../templates/page.js")),
            (has_times, include_str!("../templates/plot.js")),
            (has_map, include_str!("../templates/map.js")),
            (has_drawing, include_str!("../templates/drawing.js")),
            (has_times, include_str!("../templates/alive.js")),
        ];
        parts.into_iter().filter(|(is_there, _)| *is_there).map(|(_, script)| compact(script)).collect()
    }

    fn name(&self) -> String {
        let of_estimate = self.estimate.map(|e| e.model.clone()).filter(|name| !name.is_empty());
        let of_plan = || self.plan.map(|p| p.model.name.clone());
        let of_motion = || self.motion.map(|m| m.artefact.model.name.clone());
        let of_validation = || self.validation.map(|v| v.model.name.clone());
        of_estimate.or_else(of_plan).or_else(of_motion).or_else(of_validation).unwrap_or_else(|| "robot".into())
    }

    /// Facts on the origin of the data, each with a heading and a text.
    fn facts(&self) -> Vec<(&'static str, String)> {
        let Origin { date, version, command, model } = self.origin;
        let of_estimate = |f: fn(&Estimate) -> String| self.estimate.map(f).unwrap_or_default();
        let of_motion = || self.motion.map(|m| m.artefact.model.fingerprint.clone()).unwrap_or_default();
        let fingerprint = self.estimate.map_or_else(of_motion, |e| e.fingerprint.clone().unwrap_or_default());
        let facts = vec![
            ("date", date.unwrap_or_default().to_string()),
            ("description", model.unwrap_or_default().to_string()),
            ("fingerprint of the model", fingerprint),
            ("fitted logs", of_estimate(|e| e.logs.join(", "))),
            ("method", of_estimate(|e| e.method.clone())),
            ("rows", of_estimate(|e| e.rows.to_string())),
            ("cut-off", of_estimate(|e| e.cutoff.map_or(String::new(), |hz| format!("{} Hz", significant(hz, 3))))),
            ("command", command.to_string()),
            ("made with", if version.is_empty() { String::new() } else { format!("rist {version}") }),
        ];
        facts.into_iter().filter(|(_, text)| !text.is_empty()).collect()
    }
}

fn verdict(verdict: &Verdict, estimate: Option<&Estimate>) -> VerdictPart {
    let word = match verdict.trust {
        Trust::Yes => "Trust it",
        Trust::WithCare => "With care",
        Trust::No => "Do not use it",
    };
    let of_use = |u: &UseVerdict| UsePart {
        name: u.name.clone(),
        word: u.trust.word(),
        class: class(u.trust),
        error: u.error.map(percent),
    };
    VerdictPart {
        word,
        class: class(verdict.trust),
        found: verdict.found.clone(),
        reasons: verdict.reasons.clone(),
        next: verdict.next.clone(),
        uses: verdict.uses.iter().map(of_use).collect(),
        claims: verdict.claims.iter().filter(|claim| !claim.is_contradicted()).map(claim_line).collect(),
        grades: grades::grades(verdict, estimate),
    }
}

fn directions(estimate: &Estimate) -> Vec<DirectionPart> {
    let unit = |id: &linear_model::parameter::ParameterId| {
        estimate
            .parameters
            .iter()
            .find(|p| p.id == *id)
            .map_or(String::new(), |p| crate::number::unit(&p.unit.to_string()))
    };
    let part = |d: &identification::estimate::directions::Direction| {
        let member = |m: &identification::estimate::directions::DirectionMember| {
            let sign = if m.change < 0.0 { "−" } else { "+" };
            format!("{} {sign}{} {}", m.parameter, significant(m.change.abs(), 2), unit(&m.parameter))
        };
        DirectionPart {
            sentence: d.sentence(),
            strength: match d.strength {
                0.0 => "not at all".into(),
                strength => format!("1/{:.0} of the strongest", 1.0 / strength),
            },
            members: d.members.iter().map(member).collect::<Vec<_>>().join(", "),
            is_open: d.open,
        }
    };
    estimate.directions.iter().map(part).collect()
}

fn tenths(estimate: &Estimate) -> Vec<Tenth> {
    let largest = estimate.tenths.iter().copied().fold(0.0, f64::max);
    let tenth =
        |&error: &f64| Tenth { error: percent(error), share: if largest > 0.0 { error / largest } else { 0.0 } };
    estimate.tenths.iter().map(tenth).collect()
}

#[cfg(test)]
#[path = "identification_tests.rs"]
mod tests;
