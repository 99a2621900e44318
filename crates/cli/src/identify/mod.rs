//! `rist identify`: logs and a model -> parameters.

mod arguments;
mod closed_loop;
mod experiments;
mod samples;

use arguments::Method;
pub use arguments::{Arguments, Friction, friction};
use clap::ValueEnum as _;
use identification::estimators::closed_loop::ClosedLoop;
use identification::spectrum::identify::SpectralMethod;

use crate::failure::Failure;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let unheeded = arguments.unheeded();
    let method = arguments.method.to_possible_value().map_or(String::new(), |value| value.get_name().to_string());
    if !unheeded.is_empty() {
        let instead = match arguments.method {
            Method::Ls => "it reads samples of logs; --method rist-mh has the experiments of a plan",
            Method::Essential => "it leaves parameters out, and a body needs all of its own",
            _ => "--method ls has them; `rist validate` predicts other logs, `rist report` draws the page",
        };
        return Err(Failure::new(format_args!(
            "{}: --method {method} does not use that: {instead}",
            unheeded.join(", ")
        )));
    }
    let plan = || {
        let message = format!("--method {method} needs the plan behind the logs: --plan plan.yaml");
        arguments.plan.as_deref().ok_or_else(|| Failure::new(message))
    };
    match arguments.method {
        Method::Ls | Method::Essential => samples::run(arguments),
        Method::Rist => experiments::run(arguments, plan()?, SpectralMethod::Paper),
        Method::RistMh => experiments::run(arguments, plan()?, SpectralMethod::Harmonic),
        Method::Iv => closed_loop::run(arguments, plan()?, ClosedLoop::InstrumentalVariables),
        Method::Didim => closed_loop::run(arguments, plan()?, ClosedLoop::DirectAndInverse),
    }
}
