//! `rist identify`: identifies the parameters of a model from logs.

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
