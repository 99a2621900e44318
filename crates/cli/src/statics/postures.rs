//! `rist postures`: identifies parameters from a robot at rest.
//!
//! It identifies the gravity parameters, the zeros of the encoders and the mount (orientation) of the base.

use std::path::PathBuf;

use clap::Args;
use rist::Postures;
use rist::request::DoctorRequest;
use serde_json::json;
use statics::postures::gravity_text;
use statics::{gravity_parameters, identify_postures};

use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::print_result;

/// Identify gravity parameters, zeros and mount from postures at rest
///
/// The postures are the rows of a table without a clock, or the intervals of a log in which the robot stands still. Without
/// a file, the command lists the gravity parameters; a robot at rest determines no others. Exit code 1: signs, units or
/// columns are wrong.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Table with positions and torques of postures, or a log in which the robot stands still now and then
    #[arg(value_name = "POSTURES")]
    postures: Option<PathBuf>,

    #[command(flatten)]
    request: Flags<DoctorRequest>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let Some(path) = &arguments.postures else {
        let parameters = gravity_parameters(&model)?;
        let values = parameters.iter().map(|p| json!({"name": p.name, "unit": p.unit}));
        return print_result(gravity_text(&parameters), || Ok(json!({"parameters": values.collect::<Vec<_>>()})));
    };
    let (request, said) = arguments.request.read()?.with_arm(&model.robot, Some(path))?;
    let options = request.options(&model)?;
    let (postures, _) = Postures::read(path, model.regressor().coordinates(), &options.columns)?;
    let found = identify_postures(&model, &postures, &options)?;
    print_result(format!("{said}{found}"), || Ok(found.to_json()))?;
    match found.mistakes.as_slice() {
        [] => Ok(()),
        [_] => Err(Failure::verdict("1 finding")),
        several => {
            Err(Failure::verdict(format_args!("{} findings, of which one explains the postures", several.len())))
        }
    }
}
