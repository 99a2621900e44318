//! `rist lint`: looks for classic mistakes in a description.

use std::fmt::Write;

use clap::Args;
use serde_json::json;

use crate::failure::Failure;
use crate::model::ModelArguments;
use crate::terminal::print_result;

/// Look for classic mistakes in a description's inertial parameters
///
/// Exit code 1 where there is one.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let robot = arguments.model.read()?;
    let findings = robot::lint::lint(&robot);
    let mut text = String::new();
    for finding in &findings {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}: {}", finding.link, finding.text);
    }
    let unknown = robot.links.iter().filter(|l| l.inertial.is_none()).count();
    let _ = writeln!(
        text,
        "{} in {}, {unknown} of them without parameters",
        counted(findings.len(), "finding"),
        counted(robot.links.len(), "link")
    );
    print_result(text, || {
        let findings: Vec<_> = findings.iter().map(|f| json!({"link": f.link, "text": f.text})).collect();
        Ok(json!({"findings": findings, "links": robot.links.len(), "without_parameters": unknown}))
    })?;
    match findings.len() {
        0 => Ok(()),
        n => Err(Failure::verdict(counted(n, "finding"))),
    }
}

fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
