//! Compares mass matrix and bias torque with MuJoCo, for MJCF models in Python packages.
//!
//! This needs a Python with mujoco (`python3`, or the program in `RIST_PYTHON`). The models are from gymnasium, dm_control and
//! robosuite, if they are installed, and from the folders in `RIST_MJCF`. Without models, the test prints a message.

mod cost;
mod recursion;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use robot::format::{AngleSnapping, Mimic, ReadOptions, read_with};
use robot::{Error, Robot};

/// Largest difference to MuJoCo, relative to the largest entry. MuJoCo stores an inertia by its principal axes, which causes
/// rounding.
const TOLERANCE: f64 = 1e-10;
/// Largest relative difference for bodies with masses from meshes. MuJoCo stores vertices in single precision and omits the
/// smallest faces.
const MESH_TOLERANCE: f64 = 1e-5;

fn python(arguments: &[&str], input: &str) -> Option<String> {
    let program = std::env::var("RIST_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/states_of_mujoco.py");
    let mut command = Command::new(program);
    // MuJoCo writes its warnings to a file in the working directory, so the program runs in a temporary directory.
    command
        .arg(script)
        .args(arguments)
        .current_dir(std::env::temp_dir())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    let mut running = command.spawn().ok()?;
    running.stdin.take()?.write_all(input.as_bytes()).ok()?;
    let output = running.wait_with_output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Reads the robot as MuJoCo does: every joint is a coordinate, and angles are kept as given. Returns the robot, and whether its
/// base floats.
fn read(path: &str) -> Result<(Robot, bool), Error> {
    let options = ReadOptions { mimic: Mimic::Independent, angles: AngleSnapping::AsGiven, ..ReadOptions::default() };
    match read_with(Path::new(path), options) {
        Err(error) if error.message.contains("floating_base=true") => {
            let floating = ReadOptions { floating_base: true, ..options };
            read_with(Path::new(path), floating).map(|robot| (robot.floating(), true))
        }
        read => read.map(|robot| (robot, false)),
    }
}

#[test]
fn mass_matrix_and_bias_are_those_of_mujoco() {
    let Some(list) = python(&["list"], "") else {
        println!("NOT looked at: no Python with mujoco");
        return;
    };
    let (mut robots, mut asked) = (Vec::new(), String::new());
    for path in list.lines() {
        match read(path) {
            Ok((robot, floats)) => {
                asked += &format!("{} {path}\n", u8::from(floats));
                robots.push((path.to_string(), robot));
            }
            Err(error) => println!("refused: {error}"),
        }
    }
    if robots.is_empty() {
        println!("NOT looked at: no model is here (RIST_MJCF names folders)");
        return;
    }
    let answer = python(&["run"], &asked).expect("a Python that lists models runs them");
    let (mut agree, mut by_meshes) = (0, 0);
    let (mut wrong, mut rows) = (Vec::new(), Vec::<String>::new());
    let mut models = answer.split("model ").skip(1);
    for (path, robot) in &robots {
        let block = models.next().unwrap_or_else(|| panic!("{path}: no answer"));
        let mut lines = block.lines().skip(1);
        let first = lines.next().unwrap_or("");
        let numbers: Vec<usize> = first.split(' ').map_while(|x| x.parse().ok()).collect();
        let [n, by_mesh] = numbers[..] else {
            println!("MuJoCo: {path}: {first}");
            continue;
        };
        let tolerance = if by_mesh == 1 { MESH_TOLERANCE } else { TOLERANCE };
        assert_eq!(n, robot.n_coordinates(), "{path}");
        let worst = lines.map(|line| difference(robot, n, line)).fold(0.0, f64::max);
        println!("{worst:.1e} {n:3} {path}");
        rows.extend(cost::row(&called(path), robot, worst, &|| read(path).map(|read| read.0), None));
        match (worst <= tolerance, by_mesh) {
            (true, 1) => by_meshes += 1,
            (true, _) => agree += 1,
            (false, _) => wrong.push(format!("{worst:.1e} {path}")),
        }
    }
    println!("{}", rows.join("\n"));
    println!("{agree} models agree, and {by_meshes} whose bodies weigh by meshes");
    assert!(wrong.is_empty() && agree > 0, "{}", wrong.join("\n"));
}

/// Name of a file with the name of its folder, for example `ant/ant.xml`.
fn called(path: &str) -> String {
    let parts: Vec<&str> = path.rsplit('/').take(2).collect();
    parts.into_iter().rev().collect::<Vec<_>>().join("/")
}

/// Largest difference of an entry of the mass matrix or of the bias torque, relative to the largest entry of the same quantity.
/// `line`: q and dq, then the mass matrix and the bias torque from MuJoCo.
fn difference(robot: &Robot, n: usize, line: &str) -> f64 {
    let numbers: Vec<f64> = line.split(' ').map(|x| x.parse().unwrap()).collect();
    let (q, rest) = numbers.split_at(n);
    let (dq, rest) = rest.split_at(n);
    let (mass, bias) = rest.split_at(n * n);
    let (found_mass, found_bias) = mass_matrix_and_bias(robot, q, dq);
    let of = |found: &[f64], wanted: &[f64]| {
        let scale = wanted.iter().fold(1e-3, |s: f64, x| s.max(x.abs()));
        found.iter().zip(wanted).map(|(a, b)| (a - b).abs() / scale).fold(0.0, f64::max)
    };
    of(&found_mass, mass).max(of(&found_bias, bias))
}

/// The mass matrix M(q), row by row, and the bias torque: the torque at velocities `dq` and zero accelerations.
fn mass_matrix_and_bias(robot: &Robot, q: &[f64], dq: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = dq.len();
    let rest = vec![0.0; n];
    let still = recursion::torque(robot, q, &rest, &rest);
    let mut matrix = vec![0.0; n * n];
    for k in 0..n {
        let mut unit = rest.clone();
        unit[k] = 1.0;
        for (i, (moved, still)) in recursion::torque(robot, q, &rest, &unit).iter().zip(&still).enumerate() {
            matrix[i * n + k] = moved - still;
        }
    }
    (matrix, recursion::torque(robot, q, dq, &rest))
}
