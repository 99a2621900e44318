//! Finds usual mistakes in the inertial parameters of a description: values that no real body can have, and values that were
//! probably not intended. If exactly one repair of a value is plausible, the finding names this repair. Otherwise it may name
//! plausible values that can be used in their place.
//!
//! Whether the values are correct for the real robot is not checked here; this is the task of identification.

use crate::body::{Body, bodies};
use crate::body_doubt::{doubts, shown};
use crate::gravity_load::gravity_load;
use crate::inertial::turned_inertia;
use crate::inertial_conventions::inertial_conventions;
use crate::inertial_repair::repair;
use crate::mirror_comparison::compare;
use crate::mirror_pairs::mirror_pairs;
use crate::principal::principal_axes;
use crate::relative_density::relative_density;
use crate::robot::Robot;
use crate::substitute::substitute;

pub use crate::body_doubt::NEGLIGIBLE_SHARE;
pub use crate::extent::MeshPoints;
pub use crate::finding::{Finding, Mistake, Repair, RepairedBody, Severity};

/// What the user knows in addition to the description.
#[derive(Clone, Copy)]
pub struct LintOptions<'a> {
    /// Reads the vertices of meshes.
    pub meshes: MeshPoints<'a>,
    /// The total mass that the data sheet gives, kg.
    pub mass: Option<f64>,
}

/// The findings on a robot whose meshes are not read, the worst first.
pub fn lint(robot: &Robot) -> Vec<Finding> {
    lint_with(robot, LintOptions { meshes: &|_| None, mass: None })
}

/// The findings on a robot, the worst first. Each fact gives one finding, which names all links or joints with this fact.
pub fn lint_with(robot: &Robot, options: LintOptions) -> Vec<Finding> {
    let bodies = bodies(robot, options.meshes);
    let mut findings = Vec::new();
    for body in &bodies {
        judged(robot, body, &mut findings);
    }
    inertial_conventions(robot, &bodies, options.mass, &mut findings);
    compare(robot, &mirror_pairs(robot), &bodies, &mut findings);
    substitute(&bodies, &mut findings);
    relative_density(&bodies, &mut findings);
    bodies.iter().for_each(|body| turned_frame(body, &mut findings));
    // If a mass is wrong, the gravity torque that follows from it is wrong too. So this torque is not reported as a second
    // fact.
    let is_mass = |f: &Finding| f.subjects.iter().any(|name| bodies.iter().any(|body| body.name == *name));
    let is_doubted = findings.iter().any(|f| is_mass(f) && f.severity() != Severity::Note);
    gravity_load(robot, is_doubted, &mut findings);
    findings.extend(robot.oddities.iter().cloned());
    grouped(findings)
}

/// Adds the findings on one body: one finding with the repair if there is a unique repair, otherwise one finding for each
/// doubt.
fn judged(robot: &Robot, body: &Body, findings: &mut Vec<Finding>) {
    let doubts = doubts(body);
    let Some(worst) = doubts.first() else { return };
    let repair = repair(body, robot.format);
    let finding =
        |doubt: &crate::body_doubt::Doubt| Finding::new(&body.name, doubt.mistake, doubt.fact, &*doubt.evidence);
    if repair.is_some() {
        findings.push(Finding { repair, ..finding(worst) });
    } else {
        findings.extend(doubts.iter().map(finding));
    }
}

/// Joins findings with the same fact into one finding. The worst facts come first, and the first subject is the subject of the
/// first finding.
pub fn grouped(findings: Vec<Finding>) -> Vec<Finding> {
    let mut groups: Vec<Finding> = Vec::new();
    let clause = |finding: &Finding| finding.repair.as_ref().map(|repair| repair.text.clone());
    for finding in findings {
        let is_one = |group: &&mut Finding| {
            (group.mistake, &group.fact) == (finding.mistake, &finding.fact) && clause(group) == clause(&finding)
        };
        match groups.iter_mut().find(is_one) {
            None => groups.push(finding),
            Some(group) => {
                group.subjects.extend(finding.subjects);
                if let (Some(all), Some(more)) = (&mut group.repair, finding.repair) {
                    all.bodies.extend(more.bodies);
                }
            }
        }
    }
    groups.sort_by_key(Finding::severity);
    groups
}

/// The inertial frame counts as not rotated if its rotation changes each entry of the inertia by at most this fraction of the
/// largest principal moment. Angles in files have six digits.
const ROUNDED_TURN_SHARE: f64 = 1e-6;

/// Reports an inertial frame if its rotation relative to the link changes the inertia.
fn turned_frame(body: &Body, findings: &mut Vec<Finding>) {
    if !body.own || body.mass <= 0.0 || body.about_origin {
        return;
    }
    let turned = turned_inertia(&body.given, &body.pose.rotation);
    let largest = principal_axes(&body.given).0[2].abs();
    let away = (0..6).map(|k| (turned[k] - body.given[k]).abs()).fold(0.0, f64::max);
    if away > ROUNDED_TURN_SHARE * largest {
        let fact = "the inertial frame is turned (rpy), which is right where it was meant; whoever ignores it reads other entries";
        let text =
            format!("up to {} kg m^2, {:.0} % of the largest principal moment", shown(away, 3), 100.0 * away / largest);
        findings.push(Finding::new(&body.name, Mistake::TurnedInertialFrame, fact, text));
    }
}
