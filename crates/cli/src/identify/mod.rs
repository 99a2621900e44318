//! `rist identify`: logs and a model -> parameters.

mod arguments;
mod experiments;
mod samples;

use arguments::Method;
pub use arguments::{Arguments, Friction, friction};
use identification::spectrum::identify::SpectralMethod;

use crate::failure::Failure;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let spectral = match arguments.method {
        Method::Ls => None,
        Method::Rist => Some(SpectralMethod::Paper),
        Method::RistMh => Some(SpectralMethod::Harmonic),
    };
    match (spectral, &arguments.plan) {
        (None, None) if arguments.load.is_some() => Err(Failure::new("--load is for --method rist and rist-mh")),
        (None, None) => samples::run(arguments),
        (Some(method), Some(plan)) => experiments::run(arguments, plan, method),
        (None, Some(_)) => Err(Failure::new("--plan is for --method rist and rist-mh")),
        (Some(_), None) => {
            Err(Failure::new("--method rist and rist-mh need the plan behind the logs: --plan plan.yaml"))
        }
    }
}
