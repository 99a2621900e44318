//! The robots for whose logs mistakes are simulated, read from their description files.
//!
//! An arm is a robot that is read from a file, in which some joints are locked. It gives the ranges and speeds of the joints
//! for the motions.

use std::path::{Path, PathBuf};

use rist::describe::description::{ModelOptions, RotorInertias, read_robot};
use robot::{JointKind, Limits, Robot};

/// Names of the robots whose descriptions are in the folder `../shared/findings/inputs/statistics2`.
const NAMES: [&str; 6] = ["gen3", "iiwa", "ur10e", "tx40", "scara", "gantry"];
/// A joint that moves less than this mass, kg, belongs to a gripper.
const LEAST_MASS: f64 = 0.1;
/// If the range between the position limits is larger than this, the joint counts as unlimited, rad (m).
const WIDEST: f64 = 7.0;
/// Half of the range of a joint without known limits, rad (m). `UNKNOWN_SPEED`: its largest speed, rad/s (m/s).
const UNKNOWN_RANGE: f64 = 1.5;
const UNKNOWN_SPEED: f64 = 1.5;

/// A robot from a file.
pub struct Arm {
    /// Name of the file.
    pub name: String,
    pub path: PathBuf,
    /// The locked joints: name and position of each.
    pub locks: Vec<(String, f64)>,
    /// The robot of the description. Rotor inertias that the description does not contain are parameters.
    pub robot: Robot,
}

impl Arm {
    /// Reads a robot from a file. Joints without a known torque limit, and joints that move less than 0.1 kg, are locked.
    ///
    /// Fails if the file cannot be read, or if no joint remains.
    pub fn of(path: &Path) -> Result<Arm, String> {
        let whole = read(path, &[], None)?;
        let locks: Vec<(String, f64)> = (0..whole.n_coordinates())
            .filter(|&k| !is_driven(&whole, k))
            .map(|k| (whole.coordinates[k].name.clone(), middle(whole.coordinates[k].limits)))
            .collect();
        let robot = read(path, &locks, None)?;
        if robot.n_coordinates() < 2 {
            return Err(format!("{}: fewer than two joints have a torque limit and carry something", path.display()));
        }
        let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Arm { name, path: path.to_path_buf(), locks, robot })
    }

    /// The robot with its base rotated by roll, pitch and yaw, rad.
    pub fn mounted(&self, base: Option<[f64; 3]>) -> Robot {
        read(&self.path, &self.locks, base).unwrap_or_else(|e| panic!("{e}"))
    }

    /// The number of joints.
    pub fn n(&self) -> usize {
        self.robot.n_coordinates()
    }

    /// The names of the joints.
    pub fn names(&self) -> Vec<String> {
        self.robot.coordinates.iter().map(|c| c.name.clone()).collect()
    }

    /// Whether joint k is prismatic.
    pub fn slides(&self, k: usize) -> bool {
        let moves = |link: &&robot::Link| link.joint.variable.terms.iter().any(|(of, _)| of.0 == k);
        self.robot.links.iter().find(moves).is_some_and(|link| link.joint.kind == JointKind::Prismatic)
    }

    /// The lowest and the highest position of joint k, rad (m).
    pub fn range(&self, k: usize) -> (f64, f64) {
        let limits = self.robot.coordinates[k].limits.position;
        limits.filter(|(low, high)| low < high && high - low < WIDEST).unwrap_or((-UNKNOWN_RANGE, UNKNOWN_RANGE))
    }

    /// The largest speed of joint k, rad/s (m/s).
    pub fn speed(&self, k: usize) -> f64 {
        self.robot.coordinates[k].limits.velocity.filter(|v| *v > 0.0 && *v < 1e3).unwrap_or(UNKNOWN_SPEED)
    }

    /// The flags that every command for this robot needs, to lock its joints.
    pub fn flags(&self) -> Vec<String> {
        self.locks.iter().flat_map(|(name, position)| ["--lock".into(), format!("{name}={position}")]).collect()
    }
}

/// The robots in `../shared/findings/inputs/statistics2` and in the folder of the environment variable `RIST_ARMS`. A robot that
/// cannot be read is skipped with a message.
pub fn arms() -> Vec<Arm> {
    let folder = crate::shared().map(|shared| shared.join("findings/inputs/statistics2")).filter(|f| f.is_dir());
    if folder.is_none() {
        println!("skipped: the robots of ../shared/findings/inputs/statistics2 are absent");
    }
    let known = folder.iter().flat_map(|folder| NAMES.map(|name| folder.join(format!("{name}.urdf"))));
    let mut paths: Vec<PathBuf> = known.filter(|path| path.is_file()).collect();
    if let Some(more) = std::env::var_os("RIST_ARMS") {
        let files = std::fs::read_dir(&more).unwrap_or_else(|e| panic!("{}: {e}", more.display()));
        let mut more: Vec<PathBuf> = files.filter_map(|file| Some(file.ok()?.path())).collect();
        more.retain(|path| path.extension().is_some_and(|e| e == "urdf"));
        more.sort();
        paths.extend(more);
    }
    let read = |path: &PathBuf| match Arm::of(path) {
        Ok(arm) => Some(arm),
        Err(why) => {
            println!("skipped: {why}");
            None
        }
    };
    paths.iter().filter_map(read).collect()
}

fn read(path: &Path, locks: &[(String, f64)], base: Option<[f64; 3]>) -> Result<Robot, String> {
    let rotor_inertia = Some(RotorInertias::All);
    let options = ModelOptions { lock: locks.to_vec(), base, rotor_inertia, ..ModelOptions::default() };
    read_robot(path, &options).map_err(|e| e.to_string())
}

/// Whether joint k has a torque limit and moves at least [`LEAST_MASS`].
fn is_driven(robot: &Robot, k: usize) -> bool {
    let has_limit = robot.coordinates[k].limits.effort.is_some_and(|effort| effort > 0.0);
    // Links come after their antecedents, so one pass is enough.
    let mut carried = vec![false; robot.links.len()];
    for (j, link) in robot.links.iter().enumerate() {
        let is_own = link.joint.variable.terms.iter().any(|(of, _)| of.0 == k);
        carried[j] = is_own || link.antecedent.is_some_and(|i| carried[i.0]);
    }
    let masses =
        robot.links.iter().zip(&carried).filter(|(_, c)| **c).map(|(link, _)| link.inertial.map_or(0.0, |x| x[9]));
    has_limit && masses.sum::<f64>() >= LEAST_MASS
}

/// The position within the limits that is nearest to zero.
fn middle(limits: Limits) -> f64 {
    limits.position.map_or(0.0, |(low, high)| 0f64.clamp(low.min(high), high.max(low)))
}
