//! `rist wrench`: the load behind a force-torque sensor.

use std::path::PathBuf;

use clap::Args;
use rist::{Wrenches, identify_wrench};

use crate::failure::Failure;
use crate::terminal::print_result;

/// Identify a load from a log of a force-torque sensor and its poses
///
/// Forces and torques are in the axes of the sensor, poses in a frame at rest whose z points up. Columns are found by their
/// names: fx fy fz tx ty tz, x y z, qx qy qz qw or roll pitch yaw. A table without a clock holds postures at rest.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Log of the sensor
    log: PathBuf,

    /// Name of the link whose frame is the sensor's, for the file that --load takes
    #[arg(long, value_name = "LINK", default_value = "tool0")]
    link: String,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Wrenches::read(&arguments.log)?;
    let found = identify_wrench(&log, &arguments.link)?;
    print_result(&found, || Ok(found.to_json()))
}
