//! Searches the inertial parameters of a description for frequent mistakes.
//!
//! A finding is one suspected mistake with its remedy, for example an inertia that no body can have. The hull of a mesh is the
//! convex hull of its vertices.

use std::fmt;
use std::path::Path;

use clearance::bodies::{bodies, mesh_points};
use clearance::outside::outside;
use robot::lint::{Finding, LintOptions, Mistake, NEGLIGIBLE_SHARE, Severity, grouped};
use robot::{Collision, CollisionShape, Part, Robot};
use serde_json::{Value, json};

/// A centre of mass is reported if its distance from the hull of the mesh of its body exceeds this share of the size of the
/// hull. Collision meshes omit motors and cables, so smaller distances are normal.
const REPORTED_DISTANCE_SHARE: f64 = 0.2;

/// The suspected mistakes in a description.
#[derive(Clone, Debug)]
pub struct Lint {
    /// One finding for each fact, the worst first.
    pub findings: Vec<Finding>,
    /// Number of links.
    pub links: usize,
    /// Number of links without inertial parameters.
    pub without_parameters: usize,
    /// Two masses, kg: the mass of all bodies including the base, and the mass of the base alone.
    pub mass: [f64; 2],
}

/// Searches a description for mistakes; base parameters are not derived. Meshes are not read.
pub fn lint(robot: &Robot) -> Lint {
    with_findings(robot, robot::lint::lint(robot))
}

/// Searches for the mistakes of [`lint`], also with the sizes of meshes, and for centres of mass outside the collision meshes.
/// `directory`: folder of the description, to which the paths of meshes are relative. A mesh that cannot be read gives no
/// finding. `mass`: total mass of the data sheet, kg, for a comparison.
pub fn lint_with_meshes(robot: &Robot, directory: &Path, mass: Option<f64>) -> Lint {
    let meshes = |shape: &Collision| match &shape.shape {
        CollisionShape::Mesh { file, scale } => mesh_points(file, scale, directory).ok(),
        _ => None,
    };
    let mut findings = robot::lint::lint_with(robot, LintOptions { meshes: &meshes, mass });
    let is_known = |f: &Finding| {
        let mut others = findings.iter().filter(|other| other.mistake == Mistake::CentreOutside);
        others.any(|other| other.subjects.contains(&f.subjects[0]))
    };
    let outside: Vec<Finding> = outside_meshes(robot, directory).into_iter().filter(|f| !is_known(f)).collect();
    findings.extend(outside);
    let findings = grouped(findings);
    with_findings(robot, findings)
}

fn with_findings(robot: &Robot, findings: Vec<Finding>) -> Lint {
    // The sum of an empty list of numbers is -0. Adding 0.0 makes it 0.
    let of_base = 0.0 + robot.base.parts.iter().map(|part| part.mass).sum::<f64>();
    let of_links = 0.0 + robot.links.iter().filter_map(|link| link.inertial).map(|x| x[9]).sum::<f64>();
    Lint {
        findings,
        links: robot.links.len(),
        without_parameters: robot.links.iter().filter(|l| l.inertial.is_none()).count(),
        mass: [of_base + of_links, of_base],
    }
}

/// The bodies whose centre of mass lies outside the hull of their collision meshes.
fn outside_meshes(robot: &Robot, directory: &Path) -> Vec<Finding> {
    let of_base = std::iter::once((None, "", &robot.base.parts));
    let of_links = robot.links.iter().enumerate().map(|(k, link)| (Some(k), link.name.as_str(), &link.parts));
    let parts: Vec<(Option<usize>, &str, &Part)> =
        of_base.chain(of_links).flat_map(|(k, name, parts)| parts.iter().map(move |part| (k, name, part))).collect();
    let total: f64 = parts.iter().map(|(_, _, part)| part.mass).sum();
    // A body of the link itself is always examined. A part that is fixed to the link, such as a frame or a sensor, is examined
    // only if its mass is not negligible.
    let counts = |name: &str, part: &Part| part.name == name || part.mass > NEGLIGIBLE_SHARE * total;
    let mut found = Vec::new();
    for body in bodies(robot, directory) {
        let own = parts.iter().filter(|(link, name, part)| {
            *link == body.link && part.name == body.name && part.mass > 0.0 && counts(name, part)
        });
        for (_, _, part) in own {
            let Some((apart, across)) = outside(&body, part.pose.position) else { continue };
            if apart > REPORTED_DISTANCE_SHARE * across {
                let fact = "the centre of mass lies outside the hull of the collision meshes";
                let text = format!("by {apart:.3} m, of meshes {across:.3} m across");
                found.push(Finding::new(&part.name, Mistake::CentreOutside, fact, text));
            }
        }
    }
    found
}

impl Lint {
    /// Number of findings without those that are only notes.
    pub fn count(&self) -> usize {
        self.findings.iter().filter(|f| f.severity() != Severity::Note).count()
    }

    /// All findings as JSON.
    pub fn to_json(&self) -> Value {
        let findings: Vec<_> = self
            .findings
            .iter()
            .map(|f| {
                let severity = format!("{:?}", f.severity()).to_lowercase();
                let repair = f.repair.as_ref().map(|repair| &repair.text);
                json!({"subjects": f.subjects, "severity": severity, "text": f.text(), "repair": repair})
            })
            .collect();
        json!({
            "findings": findings,
            "links": self.links,
            "without_parameters": self.without_parameters,
            "mass": self.mass[0],
            "base_mass": self.mass[1]
        })
    }
}

impl fmt::Display for Lint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.findings.iter().try_for_each(|finding| writeln!(f, "{finding}"))?;
        writeln!(f, "total mass {:.3} kg, {:.3} kg of it the base", self.mass[0], self.mass[1])?;
        writeln!(
            f,
            "{} in {}, {} of them without parameters",
            counted(self.count(), "finding"),
            counted(self.links, "link"),
            self.without_parameters
        )
    }
}

/// A number with its noun: `1 finding`, `2 findings`.
pub fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
