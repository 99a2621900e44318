//! `rist excite`: searches a motion that makes the parameters of a model identifiable, within proved limits.
//!
//! The motion is written as YAML with its certificate (for each limit, a proven bound of the motion), and, if the user asks for
//! it, as samples for a controller and as an HTML page.

use std::path::{Path, PathBuf};

use clap::Args;
use rist::request::ExciteRequest;
use rist::{ExcitingMotion, PlayFormat};

use crate::artefact::{check_outputs, write_file};
use crate::failure::Failure;
use crate::flags::Flags;
use crate::interrupt::interruptible;
use crate::model::{ModelArguments, is_prismatic};
use crate::report::page_of_motion;
use crate::terminal::{self, print_result, progress};

/// Search for a motion that excites the parameters, and prove that it keeps its limits
///
/// The motion is a finite Fourier series that starts and ends at rest, or a quintic spline (--motion). Its limits are the
/// limits of the description, tightened by --limits. If both lack a kinematic limit, a value is assumed, with a note.
///
/// The limits are proved for all times, also between the samples. Position, velocity, acceleration and jerk are always
/// proved. Torque and power are proved if they are limited and the description has inertial parameters. The distances
/// between the robot's own links and to the floor are proved if a URDF has their collision geometry. The walls and boxes of
/// --limits are proved too.
///
/// A fixed base has the plane z = 0 as its floor in two cases: no moving link is below this plane at the zero pose, or the
/// robot stands on the plane and a motion above the plane is found. If there is room, turning joints stay 0.02 rad away
/// from the ends of their ranges, and links stay 2 cm away from each other and from this floor.
///
/// The last line says what is proven, what is assumed and what is not checked. Ctrl-C ends the search with the best motion
/// found so far. Before you use the motion, watch it in a simulator, and then slowly on the robot.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    #[command(flatten)]
    request: Flags<ExciteRequest>,

    /// Write the motion as YAML, with its certificate and the parameters that it excites
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write the samples for a controller: .csv, .yaml or .json (ROS JointTrajectory), .script (URScript servoj, 500 Hz,
    /// or 125 Hz with --rate 125); may be given several times
    #[arg(long, value_name = "FILE")]
    play: Vec<PathBuf>,

    /// Write an HTML page with the motion within its limits, the path of the tip and the excited parameters
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    /// The date on the page of --report, in any form
    #[arg(long, requires = "report")]
    date: Option<String>,

    /// Write the motion even if the proof of its limits fails; the file then says so
    #[arg(long)]
    unproven: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    // File names are checked before the search, because the search may take minutes.
    let players: Vec<PlayFormat> =
        arguments.play.iter().map(|file| PlayFormat::of_file(file, &model)).collect::<Result<_, _>>()?;
    let inputs: Vec<&Path> = [arguments.model.model.as_path()].into_iter().chain(arguments.request.files()).collect();
    check_outputs(arguments.play.iter().chain(&arguments.out).chain(&arguments.report), &inputs)?;
    let request = arguments.request.read()?;
    let report_progress = |done: usize, all: usize, text: &str| progress(format_args!("start {done} of {all}: {text}"));
    let found = interruptible(|| rist::excite(&model, &request, &report_progress))??;
    let text = found.text(&|name| is_prismatic(&model, name));
    print_result(format_args!("{}{text}", terminal::notes(&found.notes)), || serde_json::to_value(&found))?;
    if !found.proven && !arguments.unproven {
        return Err(Failure::verdict(format_args!(
            "no motion was found whose limits are proven to be kept; the best one: {}; nothing is written (--unproven writes \
             it anyway, and its file says so)",
            found.claims().faults().join("; ")
        )));
    }
    for (file, player) in arguments.play.iter().zip(players) {
        write_file(file, player.text(&found)?)?;
    }
    if let Some(out) = &arguments.out {
        write_file(out, &ExcitingMotion::to_yaml(&found)?)?;
    }
    if let Some(out) = &arguments.report {
        write_file(out, page_of_motion(&model, &found, arguments.date.as_deref())?)?;
    }
    Ok(())
}
