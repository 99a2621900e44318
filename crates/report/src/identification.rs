//! The page of an identification.

use ::experiments::plan::experiment_plan::ExperimentPlan;
use gate::shown;
use identification::estimate::artefact::Estimate;
use identification::estimate::validation::Validation;
use identification::estimate::verdict::{Trust, UseVerdict, Verdict, claim_line};
use identification::portrait::Portrait;
use identification::portrait::envelope::Envelope;
use serde::Serialize;

use crate::chart::Chart;
use crate::excitation::{self, MotionPart, ShownMotion};
use crate::experiments::{self, PlanPart, ValidationPart};
use crate::joints::{self, Joint};
use crate::motion::{self, Used};
use crate::number::{percent, significant};
pub use crate::parameters::Subject;
use crate::parameters::{self, Group};
use crate::template::rendered;

/// The content of the page. A part that is not given is left out.
#[derive(Clone, Copy, Default)]
pub struct Page<'a> {
    /// The robot, for rules, meanings, limits and the values of the description.
    pub subject: Option<Subject<'a>>,
    /// The experiments that were planned.
    pub plan: Option<&'a ExperimentPlan>,
    /// The exciting motion.
    pub motion: Option<ShownMotion<'a>>,
    /// The parameters.
    pub estimate: Option<&'a Estimate>,
    /// What the estimate makes of logs.
    pub portrait: Option<&'a Portrait>,
    /// How well it predicts other logs.
    pub validation: Option<&'a Validation>,
    /// Whether to trust it.
    pub verdict: Option<&'a Verdict>,
    /// Where all this comes from.
    pub origin: Origin<'a>,
}

/// Where a page comes from.
#[derive(Clone, Copy, Default)]
pub struct Origin<'a> {
    /// The date, as the user gave it.
    pub date: Option<&'a str>,
    /// Of the program.
    pub version: &'a str,
    /// The command that made the page, as it was typed.
    pub command: &'a str,
    /// Path of the description.
    pub model: Option<&'a str>,
}

#[derive(Serialize)]
struct Content {
    style: &'static str,
    script: &'static str,
    name: String,
    title: &'static str,
    kind: &'static str,
    verdict: Option<VerdictPart>,
    method: String,
    total: String,
    held_out: Option<String>,
    joints: Vec<Joint>,
    part_names: [&'static str; 4],
    logs: Vec<String>,
    /// Samples behind one span of the drawn lines, where there are several.
    thinned: Option<usize>,
    used: Vec<Used>,
    groups: Vec<Group>,
    has_described: bool,
    has_rules: bool,
    count: usize,
    directions: Vec<DirectionPart>,
    condition: Option<String>,
    tenths: Vec<Tenth>,
    remarks: Vec<String>,
    plan: Option<PlanPart>,
    motion: Option<MotionPart>,
    validation: Option<ValidationPart>,
    facts: Vec<(&'static str, String)>,
}

#[derive(Serialize)]
struct VerdictPart {
    word: &'static str,
    class: &'static str,
    found: String,
    reasons: Vec<String>,
    next: String,
    uses: Vec<UsePart>,
    /// What agrees and what cannot be told, a sentence each.
    claims: Vec<String>,
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
    /// The page as HTML.
    pub fn html(&self) -> String {
        rendered(include_str!("../templates/identification.html"), self.content())
    }

    /// Its charts as files of SVG, by name.
    pub fn pictures(&self) -> Vec<(String, String)> {
        let of_logs = self.portrait.map(|p| joints::pictures(p, self.estimate)).unwrap_or_default();
        let of_motions = self.validation.map(experiments::pictures).unwrap_or_default();
        let drawn = |(name, chart): (String, Chart)| (name, chart.alone());
        let of_excitation = self.motion.map(excitation::pictures).unwrap_or_default();
        let of_both = of_logs.into_iter().chain(of_motions).map(drawn);
        let mut files: Vec<(String, String)> = Vec::new();
        for (name, svg) in of_both.chain(of_excitation) {
            // Names of joints may differ by what no name of a file holds.
            let mut name = shown::file_name(&name);
            while files.iter().any(|(file, _)| *file == format!("{name}.svg")) {
                name.push('_');
            }
            files.push((format!("{name}.svg"), svg));
        }
        files
    }

    fn content(&self) -> Content {
        let estimate = self.estimate;
        let thinned = |p: &Portrait| p.joints.iter().map(|j| samples_of_a_span(&j.measured)).max();
        let is_motion_alone = estimate.is_none() && self.plan.is_none() && self.validation.is_none();
        let (title, kind) = match self.motion.filter(|_| is_motion_alone) {
            Some(_) => ("exciting motion", "Exciting motion"),
            None => ("identification", "Identified dynamics"),
        };
        Content {
            style: concat!(include_str!("../templates/page.css"), include_str!("../templates/chart.css")),
            script: include_str!("../templates/page.js"),
            name: self.name(),
            title,
            kind,
            verdict: self.verdict.map(verdict),
            method: estimate.map_or(String::new(), |e| e.method.clone()),
            total: estimate.and_then(|e| e.total).map_or(String::new(), percent),
            held_out: estimate.and_then(|e| e.cross_validation).map(percent),
            joints: self.portrait.map(|p| joints::joints(p, estimate)).unwrap_or_default(),
            part_names: identification::portrait::split::TORQUE_PART_NAMES,
            logs: self.portrait.map(|p| p.logs.iter().map(|log| log.name.clone()).collect()).unwrap_or_default(),
            thinned: self.portrait.and_then(thinned).filter(|n| *n > 1),
            used: self.portrait.map(|p| motion::used(p, self.subject.map(|s| s.robot))).unwrap_or_default(),
            groups: estimate.map(|e| parameters::groups(e, self.subject)).unwrap_or_default(),
            has_described: self.subject.is_some_and(|s| s.described.is_some()),
            has_rules: self.subject.is_some(),
            count: estimate.map_or(0, |e| e.parameters.len()),
            directions: estimate.map(directions).unwrap_or_default(),
            condition: estimate.and_then(|e| e.condition_number).filter(|x| x.is_finite()).map(|x| format!("{x:.0}")),
            tenths: estimate.map(tenths).unwrap_or_default(),
            remarks: estimate.map(|e| e.remarks.clone()).unwrap_or_default(),
            plan: self.plan.map(experiments::plan),
            motion: self.motion.map(excitation::motion),
            validation: self.validation.map(experiments::validation),
            facts: self.facts(),
        }
    }

    fn name(&self) -> String {
        let of_estimate = self.estimate.map(|e| e.model.clone()).filter(|name| !name.is_empty());
        let of_plan = || self.plan.map(|p| p.model.name.clone());
        let of_motion = || self.motion.map(|m| m.artefact.model.name.clone());
        let of_validation = || self.validation.map(|v| v.model.name.clone());
        of_estimate.or_else(of_plan).or_else(of_motion).or_else(of_validation).unwrap_or_else(|| "robot".into())
    }

    /// The facts on where everything comes from, each with its heading.
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

fn samples_of_a_span(envelope: &Envelope) -> usize {
    envelope.samples_of_a_span()
}

fn verdict(verdict: &Verdict) -> VerdictPart {
    let class = |trust: Trust| match trust {
        Trust::Yes => "yes",
        Trust::WithCare => "care",
        Trust::No => "no",
    };
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
        let member = |m: &identification::estimate::directions::Member| {
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
mod tests {
    use super::*;
    use identification::estimate::identified::{Deviations, Identified};
    use identification::estimate::validation::TorquePicture;
    use linear_model::unit::Unit;

    #[test]
    fn the_page_stands_alone() {
        let plan = ExperimentPlan { coordinates: vec!["q<1>".into()], ..ExperimentPlan::default() };
        let estimate = Estimate {
            model: "arm & co".into(),
            parameters: vec![
                Identified::new("ZZR1".parse().unwrap(), Unit::INERTIA, 0.3, Deviations::white(0.01)),
                Identified::unidentifiable("FV1".parse().unwrap(), Unit::VISCOUS, 0.0),
            ],
            tenths: vec![0.1, 0.2],
            ..Estimate::default()
        };
        let picture = TorquePicture {
            coordinate: "q<1>".into(),
            t: vec![0.0, 1.0],
            measured: vec![1.0, 2.0],
            predicted: vec![1.1, 1.9],
        };
        let validation = Validation { pictures: vec![picture], ..Validation::default() };
        let page =
            Page { plan: Some(&plan), estimate: Some(&estimate), validation: Some(&validation), ..Page::default() };
        let html = page.html();
        assert!(!html.contains("could not be made"), "{html}");
        assert!(html.contains("arm &amp; co") && html.contains("Torque of q&lt;1&gt;") && html.contains("ZZR1"));
        assert!(html.contains("not identifiable") && html.contains("0.300"), "{html}");
        // The page loads nothing: its only address is the name of the SVG language.
        assert_eq!(html.matches("http").count(), html.matches("http://www.w3.org/2000/svg").count());
        assert_eq!(html.matches("<svg").count(), page.pictures().len());
        assert!(!Page::default().html().contains("<h2"), "{}", Page::default().html());
    }
}
