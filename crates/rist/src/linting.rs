//! Classic mistakes in the inertial parameters of a description.

use std::fmt;

use robot::Robot;
use serde_json::{Value, json};

/// What was found in a description.
#[derive(Clone, Debug)]
pub struct Lint {
    /// The link and what is odd about it.
    pub findings: Vec<(String, String)>,
    /// Number of links.
    pub links: usize,
    /// Of those, the number without parameters.
    pub without_parameters: usize,
}

/// Looks for mistakes in a description; nothing is derived.
pub fn lint(robot: &Robot) -> Lint {
    Lint {
        findings: robot::lint::lint(robot).into_iter().map(|f| (f.link, f.text)).collect(),
        links: robot.links.len(),
        without_parameters: robot.links.iter().filter(|l| l.inertial.is_none()).count(),
    }
}

impl Lint {
    /// All of it as values.
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

/// `1 finding`, `2 findings`.
pub fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
