//! Searches the inertial parameters of a description for frequent mistakes.

use std::fmt;
use std::path::Path;

use clearance::bodies::bodies;
use clearance::outside::outside;
use robot::{Part, Robot};
use serde_json::{Value, json};

/// A centre of mass is reported if its distance from the hull of its mesh exceeds this share of the hull's size. Smaller
/// distances are normal, because collision meshes omit motors and cables.
const REPORTED_DISTANCE_SHARE: f64 = 0.1;

/// The suspected mistakes in a description.
#[derive(Clone, Debug)]
pub struct Lint {
    /// For each finding, the link and a sentence on the suspected mistake.
    pub findings: Vec<(String, String)>,
    /// Number of links.
    pub links: usize,
    /// Number of links without inertial parameters.
    pub without_parameters: usize,
}

/// Searches a description for mistakes; base parameters are not derived.
pub fn lint(robot: &Robot) -> Lint {
    Lint {
        findings: robot::lint::lint(robot).into_iter().map(|f| (f.link, f.text)).collect(),
        links: robot.links.len(),
        without_parameters: robot.links.iter().filter(|l| l.inertial.is_none()).count(),
    }
}

/// Searches for the mistakes of [`lint`], and for centres of mass outside the collision meshes. `directory`: folder of the
/// description, to which the paths of meshes are relative. A mesh that cannot be read gives no finding.
pub fn lint_with_meshes(robot: &Robot, directory: &Path) -> Lint {
    let mut found = lint(robot);
    let of_base = std::iter::once((None, &robot.base.parts));
    let of_links = robot.links.iter().enumerate().map(|(k, link)| (Some(k), &link.parts));
    let parts: Vec<(Option<usize>, &Part)> =
        of_base.chain(of_links).flat_map(|(link, parts)| parts.iter().map(move |part| (link, part))).collect();
    for body in bodies(robot, directory) {
        let own = parts.iter().filter(|(link, part)| *link == body.link && part.name == body.name && part.mass > 0.0);
        for (_, part) in own {
            let Some((apart, across)) = outside(&body, part.pose.position) else { continue };
            if apart > REPORTED_DISTANCE_SHARE * across {
                let text = format!(
                    "its centre of mass lies {apart:.3} m outside the hull of its collision meshes, which are {across:.3} m \
                     across"
                );
                found.findings.push((part.name.clone(), text));
            }
        }
    }
    found
}

impl Lint {
    /// All findings as JSON.
    pub fn to_json(&self) -> Value {
        let findings: Vec<_> = self.findings.iter().map(|(link, text)| json!({"link": link, "text": text})).collect();
        json!({"findings": findings, "links": self.links, "without_parameters": self.without_parameters})
    }
}

impl fmt::Display for Lint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.findings.iter().try_for_each(|(link, text)| writeln!(f, "{link}: {text}"))?;
        writeln!(
            f,
            "{} in {}, {} of them without parameters",
            counted(self.findings.len(), "finding"),
            counted(self.links, "link"),
            self.without_parameters
        )
    }
}

/// A number with its noun: `1 finding`, `2 findings`.
pub fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
