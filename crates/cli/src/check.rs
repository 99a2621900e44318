//! `rist check`: a model and a motion -> whether the motion keeps its limits, between samples too.

use std::path::{Path, PathBuf};

use clap::Args;
use rist::request::{CheckRequest, PointsFiles};
use rist::{
    Checked, ColumnNames, ExcitingMotion, ExperimentPlan, Kind, Model, PointTrajectory, Table, certificate_text,
    origins_text,
};
use serde_json::{Value, json};

use crate::artefact::read_text;
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::{ModelArguments, is_prismatic};
use crate::terminal::{self, at_work, print_result};

/// Prove anew that an exciting motion keeps its limits, or a plan, or what others made
///
/// Of the motion's file the coefficients are taken, and limits where they are tighter than those of the description and
/// of --limits. A limit that stands in the motion's file alone is told as an assumption. Position, velocity, acceleration
/// and jerk are always proved. Torque and power are proved where they are limited, with the inertial parameters of the
/// description or of --after. Distances of the robot's own links and the floor are proved where a URDF has their collision
/// geometry, and so are walls and boxes. The last line says what is broken, proven, assumed and not looked at. Exit code
/// 1: something is broken or not proven, or nobody could look at something that --limits asks for.
///
/// A CSV or another table (time, positions, and velocities and accelerations where there are any) and a JointTrajectory in
/// YAML or JSON, MoveIt's too, are held to the limits of the description and of --limits, between the points by
/// --interpolation. Of a plan of `rist plan` each experiment is proved so, and what its proof is worth is found again.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// A motion of `rist excite`, a plan of `rist plan`, a table of points or a JointTrajectory
    motion: PathBuf,

    #[command(flatten)]
    request: Flags<CheckRequest>,

    #[command(flatten)]
    points: Flags<PointsFiles>,
}

/// What a file holds.
enum Content {
    Motion(Box<ExcitingMotion>),
    Plan(Box<ExperimentPlan>),
    Points(Box<PointTrajectory>),
}

/// Ends of the names of files that hold text; others are tables.
const TEXTS: [&str; 3] = ["yaml", "yml", "json"];

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    let file = &arguments.motion;
    let content = read(&model, file)?;
    let request = arguments.request.read()?;
    let PointsFiles { interpolation } = arguments.points.read()?;
    at_work(format_args!("proving the limits of {}", file.display()));
    match content {
        Content::Motion(motion) => print_one(&model, file, &rist::check(&model, file, &motion, &request)?),
        Content::Points(points) => {
            print_one(&model, file, &rist::check_points(&model, file, *points, interpolation, &request)?)
        }
        Content::Plan(plan) => {
            if interpolation.is_some() {
                return Err(Failure::new(format_args!("{}: a plan says itself how it moves", file.display())));
            }
            let experiments = rist::check_experiments(&model, file, &plan, &request)?;
            print_plan(file, &plan, &experiments, rist::efficiency_again(&model, file, &plan)?)
        }
    }
}

fn read(model: &Model, path: &Path) -> Result<Content, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    if extension.is_some_and(|extension| !TEXTS.contains(&extension.as_str())) || path.is_dir() {
        let points = rist::points_of_table(model, &Table::read(path)?, &ColumnNames::default())?;
        return Ok(Content::Points(Box::new(points)));
    }
    let (file, text) = (path.display().to_string(), read_text(path)?);
    let begins = |word: &str| text.lines().any(|line| line.starts_with(word));
    Ok(match Kind::of(&text) {
        Some(Kind::Plan) => Content::Plan(Box::new(ExperimentPlan::from_yaml(&file, &text)?)),
        None if text.contains("joint_names") => Content::Points(Box::new(PointTrajectory::from_ros(&file, &text)?)),
        // Of a file of before the first line the keys differ.
        None if begins("experiments:") => Content::Plan(Box::new(ExperimentPlan::from_yaml(&file, &text)?)),
        _ => Content::Motion(Box::new(ExcitingMotion::from_yaml(&file, &text)?)),
    })
}

fn value(checked: &Checked) -> Result<Value, serde_json::Error> {
    let ledger = checked.ledger();
    Ok(json!({
        "proven": checked.is_proven(),
        "notes": checked.notes,
        "certificate": serde_json::to_value(&checked.certificate)?,
        "limits": serde_json::to_value(&checked.origins)?,
        "claims": serde_json::to_value(ledger.claims())?,
        "standing": serde_json::to_value(ledger.standing())?,
        "floor": checked.floor,
        "lowest": serde_json::to_value(&checked.lowest)?,
    }))
}

fn print_one(model: &Model, file: &Path, checked: &Checked) -> Result<(), Failure> {
    let ledger = checked.ledger();
    let mut text =
        terminal::notes(&checked.notes) + &certificate_text(&checked.certificate, &|name| is_prismatic(model, name));
    text += &ledger.left_out_text();
    text += &format!("\nwhere the limits stand:\n{}\n{ledger}\n", origins_text(&checked.origins));
    print_result(text, || value(checked))?;
    match &checked.faults()[..] {
        [] => Ok(()),
        faults => Err(Failure::verdict(format_args!("{}: {}", file.display(), faults.join("; ")))),
    }
}

/// Each experiment in a line, what all of them leave out, and what the proof is worth.
fn print_plan(
    file: &Path,
    plan: &ExperimentPlan,
    experiments: &[(String, Checked)],
    efficiency: Option<f64>,
) -> Result<(), Failure> {
    let said = plan.d_efficiency_at_least;
    // What is proven again differs from what was written by rounding alone.
    let is_worth = efficiency.is_none_or(|found| found >= said - EFFICIENCY_ROUNDING);
    let worth = match efficiency {
        Some(found) if is_worth => format!("proven again: D-efficiency at least {found:.4}"),
        Some(found) => format!("BROKEN: the file says D-efficiency at least {said:.4}; its proof is worth {found:.4}"),
        None => format!("the file says: D-efficiency at least {said:.4}; it has no proof that could be found again"),
    };
    let mut text = String::new();
    for (name, checked) in experiments {
        text += &format!("{name}: {}\n", checked.ledger());
    }
    if let Some((_, first)) = experiments.first() {
        text += &format!("\nwhere the limits stand:\n{}", origins_text(&first.origins));
    }
    // What is said of the files; of the experiments' notes each stands with the first of them.
    let of_first = experiments.first().map_or(&[][..], |(_, checked)| &checked.notes);
    let notes: Vec<String> = plan.seal.note(file.display()).into_iter().chain(of_first.iter().cloned()).collect();
    print_result(format_args!("{}{text}\n{worth}\n", terminal::notes(&notes)), || {
        let of = |(name, checked): &(String, Checked)| Ok::<_, serde_json::Error>((name.clone(), value(checked)?));
        let experiments = experiments.iter().map(of).collect::<Result<serde_json::Map<_, _>, _>>()?;
        Ok(
            json!({"notes": notes, "experiments": experiments, "d_efficiency_at_least": efficiency, "proven_again": is_worth}),
        )
    })?;
    let of = |(name, checked): &(String, Checked)| {
        checked.faults().into_iter().map(move |fault| format!("{name}: {fault}")).collect::<Vec<_>>()
    };
    let mut faults: Vec<String> = experiments.iter().flat_map(of).collect();
    if !is_worth {
        faults.push(worth);
    }
    match &faults[..] {
        [] => Ok(()),
        faults => Err(Failure::verdict(format_args!("{}: {}", file.display(), faults.join("; ")))),
    }
}

/// How far rounding may take what a proof is worth from what its file says.
const EFFICIENCY_ROUNDING: f64 = 1e-9;
