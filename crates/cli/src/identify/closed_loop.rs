//! `rist identify --method iv|didim`: the logs of a plan and its simulation -> parameters.

use std::path::{Path, PathBuf};

use identification::estimators::closed_loop::ClosedLoop;
use rist::closed_loop::ClosedLoopLogs;
use rist::output::check_output;
use rist::request::harmonic_request::Delay;

use super::arguments::Arguments;
use super::experiments::told;
use super::samples::options;
use crate::artefact::{gains, read_plan};
use crate::failure::Failure;
use crate::terminal::at_work;

pub fn run(arguments: &Arguments, plan: &Path, method: ClosedLoop) -> Result<(), Failure> {
    let [directory] = arguments.logs.as_slice() else {
        return Err(Failure::new("--plan takes one directory of logs"));
    };
    if arguments.delay == Some(Delay::Auto) {
        return Err(Failure::new("--delay auto: for --method ls and rist-mh; give the seconds that they find"));
    }
    let of_user = [&arguments.model.model].into_iter().chain(&arguments.plan).chain(&arguments.options);
    let inputs: Vec<&Path> = of_user.map(PathBuf::as_path).collect();
    arguments.out.iter().try_for_each(|out| check_output(out, &inputs))?;
    let model = arguments.model.derive()?;
    let options = options(arguments, &model)?;
    let plan = read_plan(plan, &model)?;
    let gains = gains(&arguments.gain, &model)?;
    let logs = ClosedLoopLogs { directory, plan: &plan, gains, options };
    at_work(format_args!("simulating and identifying {}", directory.display()));
    let estimate = rist::closed_loop::identify_experiments_in_loop(&model, &logs, method)?;
    told(arguments, &estimate, inputs)
}
