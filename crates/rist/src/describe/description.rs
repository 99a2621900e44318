//! Reads a description with the options of a user. Finds angles that were replaced by exact values at reading, and symbols
//! without a value.
//!
//! An angle such as 1.5708 in a file is read as pi/2, unless the user forbids it; such a replacement can change the torques
//! slightly. The mount is the orientation of the base, which determines the direction of gravity in the base frame.

use std::path::{Path, PathBuf};

use clearance::mesh::mesh_files;
use gate::opened;
pub use linear_model::description_options::RotorInertias;
use modeling::Size;
use nalgebra::{Rotation3, Vector3};
use robot::format::{AngleSnapping, ReadOptions};
use robot::value::Value;
use robot::{Drive, JointKind, Robot, RotorInertia};

use crate::describe::torque_difference::torque_difference;
use crate::error::Error;
use crate::output::directory_of;
pub use crate::request::ModelOptions;

/// Reads a description from its file and applies the options; base parameters and functions are not derived.
///
/// Fails with the line of an entry that cannot be read, and if `options.value` names an unknown symbol.
pub fn read_robot(path: &Path, options: &ModelOptions) -> Result<Robot, Error> {
    parse_robot(&robot::format::text_of(path)?, path, options)
}

/// Reads a description from a text; the extension of `path` gives its format. Only files to which the text refers are opened;
/// each is noted as an input of the step ([`crate::output`]).
pub fn parse_robot(text: &str, path: &Path, options: &ModelOptions) -> Result<Robot, Error> {
    opened::with(path, || {
        let robot = parsed(text, path, options)?;
        mesh_files(&robot, directory_of(path)).iter().for_each(|file| opened::note(file));
        Ok(robot)
    })
}

/// Expands the macros (xacro) of a description. Identified bodies can then be written into the text.
///
/// Fails if a xacro cannot be expanded.
pub fn without_macros(text: &str, path: &Path, options: &ModelOptions) -> Result<String, Error> {
    let packages = packages(options);
    let read = ReadOptions { arguments: &options.arg, packages: &packages, ..ReadOptions::default() };
    Ok(robot::format::without_macros(text, path, read)?)
}

fn packages(options: &ModelOptions) -> Vec<(String, PathBuf)> {
    options.package.iter().map(|(name, folder)| (name.clone(), PathBuf::from(folder))).collect()
}

fn parsed(text: &str, path: &Path, options: &ModelOptions) -> Result<Robot, Error> {
    let ModelOptions { mimic, angles, floating_base, value: ref values, arg: ref arguments, .. } = *options;
    let packages = packages(options);
    let root = options.root.as_deref();
    let read = ReadOptions { mimic, angles, floating_base, values, arguments, packages: &packages, root };
    let mut robot = robot::format::parse_with(text, path, read)?;
    for (name, position) in &options.lock {
        let refused = |why: String| Error::new(format_args!("{}: [lock]: {why}", path.display()));
        robot = robot.locked(name, *position).map_err(refused)?;
    }
    if let Some(rotors) = options.rotor_inertia {
        set_rotor_inertias(&mut robot, rotors);
    }
    if let Some(base) = options.base {
        if options.floating_base {
            return Err(Error::new(
                "[base] says how a fixed base is mounted, and [floating_base] that it is not: give one",
            ));
        }
        turn_base(&mut robot, base);
    }
    Ok(if options.floating_base { robot.floating() } else { robot })
}

/// The rotation R = Rz(yaw) Ry(pitch) Rx(roll), the convention of URDF; angles in rad.
pub(crate) fn turn_of_rpy([roll, pitch, yaw]: [f64; 3]) -> Rotation3<f64> {
    Rotation3::from_euler_angles(roll, pitch, yaw)
}

/// Largest rounding error of an angle near pi that is written with five digits, rad.
const ANGLE_ROUNDING_RAD: f64 = 2e-5;

/// Roll, pitch and yaw of a rotation, rad, rounded to `digits` decimals, so that printed values equal the values in use.
pub fn rounded_rpy(turn: &Rotation3<f64>, digits: i32) -> [f64; 3] {
    let (roll, pitch, yaw) = turn.euler_angles();
    let unit = 10f64.powi(digits);
    // Adding 0 turns -0 into 0.
    [roll, pitch, yaw].map(|angle| (angle * unit).round() / unit + 0.0)
}

/// Mounts the base with roll, pitch and yaw `base`, rad, instead of an earlier mount: g_base = R^T g_file, with g_file the
/// gravity vector in the file. Components of g_base that are as small as the rounding of an angle are set to zero.
pub(crate) fn turn_base(robot: &mut Robot, base: [f64; 3]) {
    let now = robot.gravity_number();
    let of_file = *robot.file_gravity.get_or_insert(now);
    let gravity = turn_of_rpy(base).inverse() * Vector3::from(of_file);
    let least = ANGLE_ROUNDING_RAD * gravity.norm();
    robot.gravity = [0, 1, 2].map(|i| Value::Number(if gravity[i].abs() < least { 0.0 } else { gravity[i] }));
}

/// A sentence on the angles and axes that the reader replaced by exact values, and on the resulting change of the torque;
/// `None` if nothing was replaced.
pub fn snapping(robot: &Robot, text: &str, path: &Path, options: &ModelOptions) -> Option<String> {
    /// Number of replaced angles that the sentence lists; the others are counted.
    const NAMED_ANGLES: usize = 4;
    if robot.snapped.is_empty() {
        return None;
    }
    let mut taken: Vec<String> =
        robot.snapped.iter().take(NAMED_ANGLES).map(|n| format!("{}: {}", n.subject, n.text)).collect();
    if robot.snapped.len() > NAMED_ANGLES {
        taken.push(format!("{} more", robot.snapped.len() - NAMED_ANGLES));
    }
    let as_given = parse_robot(text, path, &ModelOptions { angles: AngleSnapping::AsGiven, ..options.clone() });
    let change = match as_given.ok().and_then(|given| torque_difference(&given, robot)) {
        Some(x) => format!("the torque changes by up to {x:.1e} of its largest component"),
        None => "what that does to the torque is not known".into(),
    };
    Some(format!(
        "{}: angles are taken for what was meant ({}); {change}; [angles=as-given] keeps them",
        path.display(),
        taken.join("; ")
    ))
}

/// Fails if a symbol of the description has no value. Numeric results need all values.
pub fn check_values(robot: &Robot, path: &Path) -> Result<(), Error> {
    let missing: Vec<&str> = robot.symbols.iter().filter(|s| s.generic).map(|s| s.name.as_str()).collect();
    match missing.first() {
        None => Ok(()),
        Some(first) => Err(Error::new(format_args!(
            "{}: no value for {}: figures need one ([value={first}=0.45], or `(* Value {first} = 0.45 *)` in the file)",
            path.display(),
            missing.join(", ")
        ))),
    }
}

/// Fails if the derivation would need much time or memory. The error states the estimated time and memory. With `any_size`, the
/// check never fails.
pub fn check_size(robot: &Robot, any_size: bool) -> Result<(), Error> {
    let size = Size::of(robot);
    if size.is_large() && !any_size {
        return Err(Error::new(format_args!("{size}; [any_size] derives it all the same")));
    }
    Ok(())
}

pub(crate) fn set_rotor_inertias(robot: &mut Robot, rotors: RotorInertias) {
    for link in &mut robot.links {
        let has = match rotors {
            RotorInertias::None => false,
            RotorInertias::Actuated => link.joint.drive == Drive::Actuated,
            RotorInertias::All => link.joint.drive != Drive::Locked && link.joint.kind != JointKind::Fixed,
        };
        link.joint.rotor_inertia = match (has, link.joint.rotor_inertia) {
            (false, _) => RotorInertia::Absent,
            (true, RotorInertia::Absent) => RotorInertia::Unknown,
            (true, known) => known,
        };
    }
}
