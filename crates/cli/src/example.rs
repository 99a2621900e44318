//! `rist example`: writes a robot description and two logs for trying the program.

use std::path::PathBuf;

use clap::Args;
use rist::example::write_example;

use crate::failure::Failure;
use crate::terminal::print;

/// Write a robot description and two logs of the robot, to try the program with
///
/// The robot is a UR5, described by a URDF. The logs are simulated, with a gripper of 2 kg that is not in the URDF. The poses
/// are simulated too, of a UR5 with errors of its geometry, for `rist calibrate`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Directory for the files; it is created if it does not exist
    #[arg(default_value = "ur5")]
    directory: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let paths: Vec<String> =
        write_example(&arguments.directory)?.iter().map(|path| path.display().to_string()).collect();
    let [robot, log, other, poses] = paths.as_slice() else {
        return Err(Failure::new("the example has lost a file: please report it"));
    };
    print(&format!(
        "wrote {robot}, {log}, {other} and {poses}\nnext: rist identify {robot} {log} --validate {other} --report ur5.html\n"
    ))
}
