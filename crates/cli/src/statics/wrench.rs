//! `rist wrench`: identifies a load from a log of a force-torque sensor.
//!
//! Input: forces, torques and poses of the sensor. Output: the inertial parameters of the load, the offsets of the sensor, and
//! a verdict. If the verdict is no, the exit code is 1.

use std::path::PathBuf;

use clap::Args;
use rist::fit::verdict::Trust;
use statics::{WrenchRequest, Wrenches, identify_wrench};

use crate::failure::Failure;
use crate::flags::Flags;
use crate::terminal::print_result;

/// Identify a load from a log of a force-torque sensor and its poses
///
/// Forces and torques are in the axes of the sensor. Poses are in a frame at rest whose z axis points up. Columns are found
/// by their names: fx fy fz tx ty tz, x y z, qx qy qz qw or roll pitch yaw, or the names of RTDE. In a table without a
/// clock, each row is a posture at rest. Exit code 1: the load is not to be trusted.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Log of the sensor
    log: PathBuf,

    #[command(flatten)]
    request: Flags<WrenchRequest>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let request = arguments.request.read()?;
    let log = Wrenches::read(&arguments.log, &request.options.unwrap_or_default())?;
    let found = identify_wrench(&log, &request.link)?;
    print_result(&found, || Ok(found.to_json()))?;
    match found.verdict.trust {
        Trust::No => Err(Failure::verdict(format_args!("not to be trusted: {}", found.verdict.reasons.join("; ")))),
        Trust::WithCare | Trust::Yes => Ok(()),
    }
}
