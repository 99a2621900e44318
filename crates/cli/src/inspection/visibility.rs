//! `rist visibility`: predicts which parameters a motion or a log makes identifiable, and with which accuracy.
//!
//! Input: a description, and a motion, a plan or a log. Torques are not needed: the standard deviations follow from the motion
//! and an assumed noise.

use std::path::PathBuf;

use clap::Args;
use inspection::{JointForecast, PredictedAccuracy, VisibilityRequest, predicted_accuracy};
use rist::request::PointsFiles;
use rist::{PlayedFile, parameters_text};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{self, print_result};

/// Predict what can be identified from a motion or a log, and what would improve it
///
/// No torque is needed, because the expected standard deviations follow from the motion and the noise. FILE is a motion of
/// rist excite, a plan of rist plan, a JointTrajectory, a log or another table. If a table has only positions, they are
/// differentiated as by rist identify with its defaults. For each purpose, the output names the joint whose torque will be
/// most uncertain. A joint that uses little of its limits is named together with the parameters that it keeps inaccurate.
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
    let accuracy = predicted_accuracy(&model, &arguments.file, &content, interpolation, &request)?;
    print_result(text(&accuracy), || value(&accuracy))
}

fn purpose(JointForecast { purpose, coordinate, deviation, share }: &JointForecast) -> String {
    match (deviation, share) {
        (None, _) => format!("{purpose}: not identifiable (a parameter of {coordinate} is missing)"),
        (Some(deviation), None) => format!("{purpose}: uncertainty {} ({coordinate})", figure(*deviation)),
        (Some(deviation), Some(share)) => format!(
            "{purpose}: uncertainty {} %, {} N m (N), largest ({coordinate})",
            figure(100.0 * share),
            figure(*deviation)
        ),
    }
}

/// Writes a number with two significant digits.
fn figure(x: f64) -> String {
    rist::significant(x, 2)
}

fn text(accuracy: &PredictedAccuracy) -> String {
    let mut text = terminal::notes(&accuracy.notes) + &parameters_text(&accuracy.parameters);
    let condition_number = rist::significant(accuracy.condition_number, 3);
    text += &format!("\ncondition number {condition_number}, {} instants\n", accuracy.samples);
    for forecast in &accuracy.purposes {
        text += &format!("{}\n", purpose(forecast));
    }
    for sentence in &accuracy.to_add {
        text += &format!("{sentence}\n");
    }
    let all = accuracy.parameters.len();
    let seen = accuracy.parameters.iter().filter(|p| p.deviation.is_some()).count();
    let weak = accuracy.parameters.iter().filter(|p| p.deviation.is_some() && p.remark().is_some()).count();
    let weak = if weak == 0 { "none of them weak".to_string() } else { format!("{weak} of them weak") };
    text + &format!("\nidentifiable: {seen} of {all} parameters, {weak}\n")
}

fn value(accuracy: &PredictedAccuracy) -> Result<Value, serde_json::Error> {
    let purpose = |JointForecast { purpose, coordinate, deviation, share }: &JointForecast| json!({"purpose": purpose, "coordinate": coordinate, "deviation": deviation, "share": share});
    Ok(json!({
        "notes": accuracy.notes,
        "parameters": serde_json::to_value(&accuracy.parameters)?,
        "condition_number": accuracy.condition_number,
        "samples": accuracy.samples,
        "purposes": accuracy.purposes.iter().map(purpose).collect::<Vec<_>>(),
        "to_add": accuracy.to_add,
    }))
}
