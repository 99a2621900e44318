//! `rist lint`: looks for classic mistakes in a description.

use std::fmt::Write;

use clap::Args;

use crate::failure::{Failure, print};
use crate::model::ModelArguments;

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
    print(&text)?;
    match findings.len() {
        0 => Ok(()),
        n => Err(Failure::verdict(counted(n, "finding"))),
    }
}

fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
