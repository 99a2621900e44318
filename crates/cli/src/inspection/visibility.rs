//! `rist visibility`: a model and a motion or a log -> what an identification from it would tell.

use std::path::PathBuf;

use clap::Args;
use inspection::{Outlook, ToldBy, VisibilityRequest, told_by};
use rist::request::PointsFiles;
use rist::{PlayedFile, parameters_text};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{self, print_result};

/// Say whether a motion or a log is exciting enough, for what, and what would tell more
///
/// No torque is needed: the deviations to expect follow from the motion and from the noise. Taken are a motion of
/// rist excite, a plan of rist plan, a JointTrajectory, and a log or another table. Positions of a table alone are
/// differentiated as rist identify does by its defaults. For each purpose the joint stands there whose torques will be most
/// unsure. A joint that uses little of its limits is named with the parameters that it keeps back.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// A motion, a plan, a JointTrajectory, or a log
    file: PathBuf,

    #[command(flatten)]
    request: Flags<VisibilityRequest>,

    #[command(flatten)]
    points: Flags<PointsFiles>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let content = PlayedFile::read(&model, &arguments.file)?;
    let (request, PointsFiles { interpolation }) = (arguments.request.read()?, arguments.points.read()?);
    let told = told_by(&model, &arguments.file, &content, interpolation, &request)?;
    print_result(text(&told), || value(&told))
}

fn purpose(Outlook { purpose, coordinate, deviation, share }: &Outlook) -> String {
    match (deviation, share) {
        (None, _) => format!("{purpose}: not told (a parameter of {coordinate} is missing)"),
        (Some(deviation), None) => format!("{purpose}: unsure by {} ({coordinate})", figure(*deviation)),
        (Some(deviation), Some(share)) => format!(
            "{purpose}: unsure by {} %, {} N m (N), at most ({coordinate})",
            figure(100.0 * share),
            figure(*deviation)
        ),
    }
}

/// Two digits.
fn figure(x: f64) -> String {
    rist::significant(x, 2)
}

fn text(told: &ToldBy) -> String {
    let mut text = terminal::notes(&told.notes) + &parameters_text(&told.parameters);
    text += &format!("\ncondition number {}, {} instants\n", rist::significant(told.condition_number, 3), told.samples);
    for outlook in &told.purposes {
        text += &format!("{}\n", purpose(outlook));
    }
    for sentence in &told.to_add {
        text += &format!("{sentence}\n");
    }
    let all = told.parameters.len();
    let seen = told.parameters.iter().filter(|p| p.deviation.is_some()).count();
    let weak = told.parameters.iter().filter(|p| p.deviation.is_some() && p.remark().is_some()).count();
    let weak = if weak == 0 { "none of them weak".to_string() } else { format!("{weak} of them weak") };
    text + &format!("\ntold: {seen} of {all} parameters, {weak}\n")
}

fn value(told: &ToldBy) -> Result<Value, serde_json::Error> {
    let purpose = |Outlook { purpose, coordinate, deviation, share }: &Outlook| json!({"purpose": purpose, "coordinate": coordinate, "deviation": deviation, "share": share});
    Ok(json!({
        "notes": told.notes,
        "parameters": serde_json::to_value(&told.parameters)?,
        "condition_number": told.condition_number,
        "samples": told.samples,
        "purposes": told.purposes.iter().map(purpose).collect::<Vec<_>>(),
        "to_add": told.to_add,
    }))
}
