//! `rist schema`: prints the options of all steps as a JSON schema.

use clap::Args;

use crate::failure::Failure;
use crate::terminal::print;

/// Print the options of every command as a JSON schema: types, defaults and ranges
#[derive(Args)]
pub(crate) struct Arguments {}

pub(crate) fn run(Arguments {}: &Arguments) -> Result<(), Failure> {
    print(&format!("{:#}\n", rist::request::schema::schema()))
}
