//! `rist identify --method rist|tls|rist-mh|iv|didim`: identifies parameters from the logs of a plan.
//!
//! A plan is a list of experiments (motions) from `rist plan`, and each experiment has one log. Methods: `rist` and `tls` use
//! one projection of the spectrum per experiment; `rist-mh` uses all harmonics; `iv` and `didim` simulate the experiments in
//! closed loop.

use std::path::{Path, PathBuf};

use rist::fit::experiments::{ExperimentLogs, identify_experiments, identify_gains_of_rows, identify_paper_rows};
use rist::identify_experiments_in_loop;
use rist::output::check_output;
use rist::request::{HarmonicRequest, Method, PaperRequest};

use super::arguments::Arguments;
use crate::artefact::read_plan;
use crate::failure::Failure;
use crate::terminal::at_work;
use crate::verdict::conclude;

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (asked, given) = (&arguments.asked, &arguments.asked.given);
    let plan_file = asked.plan()?;
    let [directory] = arguments.logs.as_slice() else {
        return Err(Failure::new("[plan] takes one directory of logs"));
    };
    // Outputs are compared with inputs before the work, so that no input can be overwritten.
    let of_user = [arguments.model.model.as_path(), plan_file].into_iter();
    let mut inputs: Vec<&Path> = of_user.chain(given.files()).collect();
    arguments.out.iter().try_for_each(|out| check_output(out, &inputs))?;
    let model = arguments.model.derive()?;
    let plan = read_plan(plan_file, &model)?;
    let logs = ExperimentLogs { directory, plan: &plan };
    // The logs are inputs too. Their names are known only after the plan is read.
    let files = logs.files();
    inputs.extend(files.iter().map(PathBuf::as_path));
    arguments.out.iter().try_for_each(|out| check_output(out, &inputs))?;
    let of_options = |e| Failure::new(format_args!("{}: {e}", given.file("options").display()));
    let at = || at_work(format_args!("identifying from {}", directory.display()));
    let estimate = match asked.method {
        Method::Iv | Method::Didim => {
            let request = given.read()?;
            at_work(format_args!("simulating and identifying {}", directory.display()));
            identify_experiments_in_loop(&model, logs, &request, asked.method)?
        }
        Method::Rist | Method::Tls => {
            let request: PaperRequest = given.read()?;
            request.columns().map_err(of_options)?;
            at();
            let identify = if asked.method == Method::Tls { identify_gains_of_rows } else { identify_paper_rows };
            identify(&model, logs, &request)?
        }
        Method::RistMh | Method::Ls | Method::Essential => {
            let request: HarmonicRequest = given.read()?;
            request.paper.columns().map_err(of_options)?;
            at();
            identify_experiments(&model, logs, &request)?
        }
    };
    let verdict = rist::fit::verdict::estimate_verdict(&estimate);
    conclude(&estimate, &verdict, arguments.out.as_deref())
}
