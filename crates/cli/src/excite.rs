//! `rist excite`: a model -> one motion that makes its parameters visible, within proved limits.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::criterion::Aim;
use experiments::motion::servo_script::servo_script;
use experiments::motion::trajectory_file::{TrajectoryFormat, trajectory_file};
use linear_model::friction::terms::FrictionTerm;
use rist::request::excite_request::{ExciteRequest, Family, FamilyWord};
use rist::{Estimate, Model};

use crate::artefact::{check_outputs, read_limits, read_text};
use crate::failure::Failure;
use crate::identify::{Friction, friction};
use crate::interrupt::interruptible;
use crate::model::ModelArguments;
use crate::report::page_of_motion;
use crate::terminal::{self, print_result, progress};
use rist::output::write_file;

/// Search one motion of all joints that makes the parameters visible, and prove that it keeps its limits
///
/// The motion is a finite Fourier series that starts and ends at rest, or a quintic spline (--motion). Its limits are
/// those of the description, tightened by --limits. A kinematic limit that neither gives is assumed, with a note.
/// Position, velocity, acceleration and jerk are proved between the samples too. So are torque and power, where they
/// are limited and the description has inertial parameters; the distances of the robot's own links, where a URDF has
/// their collision geometry; and the floors, walls and boxes of --limits. Notes say what is not checked. Ctrl-C ends
/// the search with the best motion found so far. Watch the motion in a simulator, and slowly on the robot, first.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The form of the motion
    #[arg(long, value_enum, default_value_t = MotionWord::Fourier)]
    motion: MotionWord,

    /// Seconds of a period, of a spline from rest to rest [default: by the limits, 5 to 20]
    #[arg(long, allow_negative_numbers = true, value_name = "SECONDS", conflicts_with = "frequency")]
    period: Option<f64>,

    /// Base frequency, Hz: one over the period
    #[arg(long, allow_negative_numbers = true, value_name = "HZ")]
    frequency: Option<f64>,

    /// Harmonics of the base frequency [default: 5]
    #[arg(long)]
    harmonics: Option<usize>,

    /// Spans of a spline: the more, the freer, and the longer the search [default: by the limits, 8 to 30]
    #[arg(long)]
    spans: Option<usize>,

    /// Whole periods between the blends; times that a spline is played
    #[arg(long, default_value_t = 3)]
    repetitions: usize,

    /// Seconds from rest to the series, and back to rest [default: by the limits]
    #[arg(long, allow_negative_numbers = true, value_name = "SECONDS")]
    blend: Option<f64>,

    /// Sample rate of the file to play and of the log, Hz
    #[arg(long, allow_negative_numbers = true, value_name = "HZ", default_value_t = 200.0)]
    rate: f64,

    /// YAML with tighter limits: `coordinates: {NAME: {position: [LOW, HIGH], velocity, acceleration, jerk, effort,
    /// power, locked: POSITION, slowed: FACTOR}}`; `all:` has them for every coordinate; `space:` has the room of the bodies in
    /// the base frame, m: `{floor: Z, walls: [{point, normal, links}], boxes: [{low, high, links}], distance: 0.01,
    /// own_links: true, ignored_pairs: [[A, B]]}`
    #[arg(long, value_name = "FILE")]
    limits: Option<PathBuf>,

    /// Share of the limits of effort and power that the torque of the description may use
    #[arg(long, allow_negative_numbers = true, value_name = "SHARE", default_value_t = 0.9)]
    effort_share: f64,

    /// Friction columns a joint that the identification will have, as of `rist identify`, or none
    #[arg(long, value_delimiter = ',', value_name = "TERMS", value_parser = friction)]
    friction: Option<Vec<Friction>>,

    /// What the motion makes best
    #[arg(long, value_enum, default_value_t = AimWord::Determinant)]
    criterion: AimWord,

    /// Noise of a torque sample, as a share of the effort limit
    #[arg(long, allow_negative_numbers = true, value_name = "SHARE", default_value_t = 0.01)]
    noise: f64,

    /// Starts of the search: a third are random, the others begin near the best so far
    #[arg(long, default_value_t = 12)]
    starts: usize,

    /// Maximum number of iterations of a start at each weight of the barrier
    #[arg(long, default_value_t = 100)]
    iterations: usize,

    /// Seed of the random starts; the same seed gives the same motion
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// An earlier estimate of this model: the motion shows what it leaves open, and the torques follow from its
    /// parameters. Best with its covariance (`covariance: true` in the --options of `rist identify`)
    #[arg(long, value_name = "ESTIMATE")]
    after: Option<PathBuf>,

    /// Write the motion as YAML, with its certificate and what it makes visible
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write the samples for a controller: .csv, .yaml or .json (ROS JointTrajectory), .script (URScript servoj); may
    /// be given several times
    #[arg(long, value_name = "FILE")]
    play: Vec<PathBuf>,

    /// Write a page that draws the motion within its limits, the path of the tip and what it makes visible
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    /// The date on that page, in any form
    #[arg(long, requires = "report")]
    date: Option<String>,

    /// Write the motion even where its limits are not proven to be kept; the file then says so
    #[arg(long)]
    unproven: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MotionWord {
    /// Whole periods of a few frequencies between two blends: can be averaged, or filtered without loss
    Fourier,
    /// From rest to rest: tells more in a short time, or within narrow limits; may be quick here and slow there
    Spline,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AimWord {
    /// The determinant of the information
    Determinant,
    /// The condition number of the columns, scaled to unit norm
    Condition,
}

/// What is written for a controller.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Player {
    Trajectory(TrajectoryFormat),
    ServoScript,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.derive()?;
    // Before the search: nobody wants to lose one to a name.
    let players: Vec<Player> = arguments.play.iter().map(|file| player(file, &model)).collect::<Result<_, _>>()?;
    let of_user = [&arguments.model.model].into_iter().chain(&arguments.limits).chain(&arguments.after);
    let inputs: Vec<&Path> = of_user.map(PathBuf::as_path).collect();
    check_outputs(arguments.play.iter().chain(&arguments.out).chain(&arguments.report), &inputs)?;
    let request = request(arguments)?;
    let told = |done: usize, all: usize, text: &str| progress(format_args!("start {done} of {all}: {text}"));
    let found = interruptible(|| rist::excite(&model, &request, &told))??;
    print_result(format_args!("{}{found}", terminal::notes(&found.notes)), || serde_json::to_value(&found))?;
    if !found.proven && !arguments.unproven {
        return Err(Failure::verdict(
            "no motion was found whose limits are proven to be kept; nothing is written (--unproven writes it anyway, \
             and its file says so)",
        ));
    }
    let reference = found.motion("the motion")?.reference();
    for (file, player) in arguments.play.iter().zip(players) {
        let text = match player {
            Player::Trajectory(format) => {
                trajectory_file(&reference, model.regressor().coordinates(), found.rate_hz, format)
            }
            Player::ServoScript => servo_script(&reference),
        };
        write_file(file, &text, &inputs)?;
    }
    if let Some(out) = &arguments.out {
        write_file(out, &ExcitingMotion::to_yaml(&found)?, &inputs)?;
    }
    if let Some(out) = &arguments.report {
        write_file(out, page_of_motion(&model, &found, arguments.date.as_deref())?, &inputs)?;
    }
    Ok(())
}

fn request(arguments: &Arguments) -> Result<ExciteRequest, Failure> {
    let period = match arguments.frequency {
        Some(f) if !(f.is_finite() && f > 0.0) => {
            return Err(Failure::new(format_args!("--frequency must be a positive number, not {f}")));
        }
        frequency => arguments.period.or(frequency.map(|f| 1.0 / f)),
    };
    let word = match arguments.motion {
        MotionWord::Fourier => FamilyWord::Fourier,
        MotionWord::Spline => FamilyWord::Spline,
    };
    Ok(ExciteRequest {
        family: Family::new(word, arguments.blend, arguments.harmonics, arguments.spans)?,
        period,
        repetitions: arguments.repetitions,
        rate: arguments.rate,
        limits: arguments.limits.as_deref().map(read_limits).transpose()?.unwrap_or_default(),
        effort_share: arguments.effort_share,
        friction: friction_terms(arguments.friction.as_deref())?,
        aim: match arguments.criterion {
            AimWord::Determinant => Aim::Determinant,
            AimWord::Condition => Aim::Condition,
        },
        noise: arguments.noise,
        starts: arguments.starts,
        iterations: arguments.iterations,
        seed: arguments.seed,
        after: arguments.after.as_ref().map(|file| read_estimate(file)).transpose()?,
    })
}

fn read_estimate(file: &Path) -> Result<Estimate, Failure> {
    Ok(Estimate::from_yaml(&file.display().to_string(), &read_text(file)?)?)
}

fn friction_terms(words: Option<&[Friction]>) -> Result<Vec<FrictionTerm>, Failure> {
    match words {
        None => Ok(FrictionTerm::STANDARD.to_vec()),
        Some([Friction::None]) => Ok(vec![]),
        Some(words) => words
            .iter()
            .map(|word| match word {
                Friction::Term(term) => Ok(*term),
                Friction::Auto | Friction::None => {
                    Err(Failure::new("--friction: name the terms, or none alone; auto needs a log"))
                }
            })
            .collect(),
    }
}

fn player(file: &Path, model: &Model) -> Result<Player, Failure> {
    let end = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let regressor = model.regressor();
    let n = regressor.coordinates().len();
    match end.as_str() {
        "csv" => Ok(Player::Trajectory(TrajectoryFormat::Csv)),
        "yaml" | "yml" => Ok(Player::Trajectory(TrajectoryFormat::RosYaml)),
        "json" => Ok(Player::Trajectory(TrajectoryFormat::RosJson)),
        "script" if n == 6 && !(0..n).any(|k| regressor.is_prismatic(k)) => Ok(Player::ServoScript),
        "script" => Err(Failure::new(format_args!(
            "{}: URScript plays robots with six joints that turn; {} has {n} coordinates",
            file.display(),
            model.robot.name
        ))),
        _ => Err(Failure::new(format_args!(
            "{}: the end of the name chooses the format: .csv, .yaml or .json (ROS JointTrajectory), .script (URScript)",
            file.display()
        ))),
    }
}
