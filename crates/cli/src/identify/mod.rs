//! `rist identify`: identifies the parameters of a model from logs.
//!
//! The method decides what is read: `ls` and `essential` fit samples of any logs (`samples`), the other methods need the logs
//! of a plan (`plan_logs`). Output: an estimate, that is the parameters with standard deviations, and a verdict on it.

mod arguments;
mod plan_logs;
mod samples;

pub(crate) use arguments::Arguments;
use rist::request::Method;

use crate::failure::Failure;

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.asked.check()?;
    match arguments.asked.method {
        Method::Ls | Method::Essential => samples::run(arguments),
        Method::Rist | Method::Tls | Method::RistMh | Method::Iv | Method::Didim => plan_logs::run(arguments),
    }
}
