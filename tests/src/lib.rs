//! Models, random states, independent mechanics and benchmarks, which several test files use.
//!
//! The mechanics of `recursion` and `lagrangian` use plain f64 in the base frame, with textbook formulas and the data of a
//! [`robot::Robot`]. They share no code with `modeling` or with the kinematics of `robot`, so a common error is improbable. In
//! contrast, [`tape_robot::TapeRobot`] uses the functions that the program derives. It is for tests of the steps that follow the
//! derivation.

pub mod benchmark;
pub mod bodied_robots;
pub mod dense_samples;
pub mod docstrings;
pub mod faults;
pub mod formula_text;
pub mod hostile;
pub mod joint_log;
pub mod known_arms;
pub mod lagrangian;
pub mod loops;
pub mod mutation;
pub mod number;
pub mod on_robot;
pub mod planar_log;
pub mod planar_loop;
pub mod pose;
pub mod program;
pub mod promise;
pub mod random;
pub mod random_situations;
pub mod random_structures;
pub mod recursion;
pub mod remedies;
pub mod rules;
pub mod running_error;
pub mod scrambled;
pub mod snapshot;
pub mod tape_robot;
pub mod urdf_text;

use std::path::{Path, PathBuf};

use expr::{Function, Tape};
use modeling::{BaseParameters, Derivation, UnclearRank};
use robot::{Inertial, LinkId, Robot, StandardParameter};

use crate::random::Random;

/// Registers all wings, as the program does.
pub fn register_wings() {
    rist::wings::register(vec![
        calibration::wing(),
        fleet::wing(),
        foreign::wing(),
        formulas::wing(),
        inspection::wing(),
        packages::wing(),
        research::wing(),
        statics::wing(),
    ]);
}

/// The root folder of the workspace.
pub fn workspace() -> PathBuf {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().unwrap_or(manifest).to_path_buf()
}

/// The text of a file of the workspace, for example `docs/files.md`.
pub fn text_of(file: &str) -> String {
    std::fs::read_to_string(workspace().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// The lines of the code blocks of a Markdown text that begin with exactly the line `opening`.
pub fn fenced<'a>(text: &'a str, opening: &str) -> Vec<&'a str> {
    let mut is_inside = None;
    let mut lines = Vec::new();
    for line in text.lines() {
        match (is_inside, line.starts_with("```")) {
            (None, true) => is_inside = Some(line == opening),
            (Some(_), true) => is_inside = None,
            (Some(true), false) => lines.push(line),
            _ => {}
        }
    }
    lines
}

/// All files below a folder, sorted by name, without build output and without hidden folders (except `.ci` and `.cargo`).
pub fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut entries: Vec<PathBuf> = entries.map(|entry| entry.unwrap_or_else(|e| panic!("{e}")).path()).collect();
    entries.sort();
    let is_skipped = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name == "target" || name.starts_with('.') && name != ".cargo" && name != ".ci"
    };
    let of = |path: PathBuf| match path.is_dir() {
        true if is_skipped(&path) => vec![],
        true => files_below(&path),
        false => vec![path],
    };
    entries.into_iter().flat_map(of).collect()
}

/// All Rust source files below a folder, in all its subfolders.
pub fn sources_below(folder: &Path) -> Vec<PathBuf> {
    files_below(folder).into_iter().filter(|path| path.extension().is_some_and(|end| end == "rs")).collect()
}

/// Path of a model in models/, for example `race.yaml`.
pub fn model_path(file: &str) -> PathBuf {
    workspace().join("models").join(file)
}

/// Path of a robot in tests/data/robots, for example `r3g.yaml`.
pub fn test_robot_path(file: &str) -> PathBuf {
    workspace().join("tests/data/robots").join(file)
}

/// The text of a model, which a test can change.
pub fn model_text(file: &str) -> String {
    text_of(&format!("models/{file}"))
}

pub fn model(file: &str) -> Robot {
    robot::format::read(&model_path(file)).unwrap_or_else(|e| panic!("{e}"))
}

/// All robots of models/ whose joint variables are affine functions of the coordinates (no loops that are solved numerically),
/// with their file names.
pub fn models() -> Vec<(String, Robot)> {
    let folder = workspace().join("models");
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut files: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|file| [".yaml", ".urdf", ".par"].iter().any(|e| file.ends_with(e)))
        .collect();
    files.sort();
    assert!(files.len() >= 15, "models/ has lost models: {files:?}");
    let robots = files.into_iter().map(|file| (file.clone(), model(&file)));
    robots.filter(|(_, robot)| robot.passive.is_empty()).collect()
}

/// The folder with reference material. If it does not exist, a message is printed and the result is `None`.
pub fn shared() -> Option<PathBuf> {
    let folder = std::env::var_os("RIST_SHARED").map_or_else(|| workspace().join("../shared"), PathBuf::from);
    if folder.join("facts").is_dir() {
        return Some(folder);
    }
    println!("skipped: ../shared is absent");
    None
}

/// The folder with logs from users. If it does not exist, a message is printed and the result is `None`.
pub fn field() -> Option<PathBuf> {
    let folder = shared()?.join("findings/inputs/field");
    if !folder.is_dir() {
        println!("skipped: shared/findings is absent");
        return None;
    }
    Some(folder)
}

/// Names of the standard parameters, in the order of the columns of the regressor D.
pub fn standard_names(robot: &Robot) -> Vec<String> {
    StandardParameter::all(robot).into_iter().map(|s| s.display(robot).to_string()).collect()
}

/// The base parameters of a robot. Fails if their number is ambiguous.
pub fn try_base_parameters(robot: &Robot) -> Result<BaseParameters, UnclearRank> {
    let mut derivation = Derivation::new(robot).unwrap_or_else(|open| panic!("{}: {open}", robot.name));
    let regressor = derivation.regressor();
    derivation.base_parameters(&regressor)
}

/// The derivation of a robot, with its regressor and its base parameters.
pub fn derived(robot: &Robot) -> (Derivation<'_>, Function, BaseParameters) {
    let mut derivation = Derivation::new(robot).unwrap_or_else(|open| panic!("{}: {open}", robot.name));
    let regressor = derivation.regressor();
    let base = derivation.base_parameters(&regressor).unwrap_or_else(|unclear| panic!("{}: {unclear}", robot.name));
    (derivation, regressor, base)
}

pub fn base_parameters(robot: &Robot) -> BaseParameters {
    derived(robot).2
}

/// The entries of all outputs of a function. The function is evaluated by a tape (a list of its operations).
pub fn evaluated(function: &Function, inputs: &[&[f64]]) -> Vec<f64> {
    let tape = Tape::new(&function.bound());
    let mut outputs = vec![f64::NAN; tape.n_outputs()];
    tape.evaluate(&inputs.concat(), &mut tape.workspace(), &mut outputs);
    outputs
}

/// A robot with random, physically possible standard parameters.
pub struct Case {
    pub robot: Robot,
    pub base: BaseParameters,
    pub x: Vec<f64>,
    pub x_base: Vec<f64>,
}

/// All models with random parameters. The models named in `floating` occur a second time, with a floating base.
pub fn cases(seed: u64, floating: &[&str]) -> Vec<Case> {
    let mut random = Random(seed);
    let mut robots: Vec<Robot> = models().into_iter().map(|(_, robot)| robot).collect();
    let floating: Vec<Robot> =
        robots.iter().filter(|r| floating.contains(&r.name.as_str())).map(Robot::floating).collect();
    robots.extend(floating);
    let case = |robot: Robot| {
        let base = base_parameters(&robot);
        let x = random.physical_parameters(&robot);
        Case { x_base: base.values(&x), x, base, robot }
    };
    robots.into_iter().map(case).collect()
}

/// Fails if a text does not contain each of these parts.
#[track_caller]
pub fn has(text: &str, parts: &[&str]) {
    parts.iter().for_each(|part| assert!(text.contains(part), "no `{part}` in {text}"));
}

/// Fails if an entry of `a` differs from the entry of `b` by more than `tolerance` times the largest entry (at least 1).
#[track_caller]
pub fn agree(what: &str, robot: &Robot, a: &[f64], b: &[f64], tolerance: f64) {
    let scale = a.iter().chain(b).fold(1.0, |s: f64, x| s.max(x.abs()));
    assert_eq!(a.len(), b.len(), "{what} of {}", robot.name);
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= tolerance * scale, "{what} of {}, entry {i}: {a} and {b}", robot.name);
    }
}

/// For each link: the body parameters XX XY XZ YY YZ ZZ MX MY MZ M, and the rotor inertia. `x`: all standard parameters.
pub fn by_link(robot: &Robot, x: &[f64]) -> Vec<([f64; 10], f64)> {
    let mut links = vec![([0.0; 10], 0.0); robot.links.len()];
    for (parameter, &value) in StandardParameter::all(robot).into_iter().zip(x) {
        let LinkId(j) = parameter.link;
        match parameter.inertial {
            Inertial::Ia => links[j].1 = value,
            inertial => links[j].0[inertial as usize] = value,
        }
    }
    links
}

/// sum a_i b_i and sum |a_i b_i|. The rounding error of the first sum is proportional to the second.
pub fn dot(a: &[f64], b: &[f64]) -> (f64, f64) {
    a.iter().zip(b).fold((0.0, 0.0), |(sum, size), (a, b)| (sum + a * b, size + (a * b).abs()))
}
