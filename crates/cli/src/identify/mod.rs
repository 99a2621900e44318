//! `rist identify`: logs and a model -> parameters.

mod arguments;
mod closed_loop;
mod experiments;
mod samples;

use arguments::Method;
pub use arguments::{Arguments, Friction, friction};
use identification::estimators::closed_loop::ClosedLoop;
use identification::spectrum::identify::SpectralMethod;

use crate::failure::Failure;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let method = arguments.method.word();
    let refused = arguments.unused().into_iter();
    let refused = refused.map(|(flag, users)| {
        format!("{flag}: --method {method} does not use that; --method {} does", users.join(" or "))
    });
    let refused: Vec<String> = refused.collect();
    if !refused.is_empty() {
        return Err(Failure::new(refused.join("\n")));
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
