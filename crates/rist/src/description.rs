//! A description as a user gives it: how it is read, which values the reader rounded, which it lacks.

use std::path::Path;

use linear_model::description_options::DescriptionOptions;
pub use linear_model::description_options::RotorInertias;
use robot::format::{Angles, Mimic, ReadOptions};
use robot::{Drive, JointKind, Robot, RotorInertia};

use crate::error::Error;
use crate::torque_difference::torque_difference;

/// How a description is read; the default is as it stands.
#[derive(Clone, Debug, Default)]
pub struct ModelOptions {
    /// Values of symbols, m or rad.
    pub values: Vec<(String, f64)>,
    /// How the mimic joints of a URDF are read.
    pub mimic: Mimic,
    /// Whether angles near a right angle are taken for what they were meant to be.
    pub angles: Angles,
    /// Which joints have a rotor inertia among their parameters; `None`: as the file says.
    pub rotor_inertias: Option<RotorInertias>,
    /// Six coordinates in front, and the base a link with parameters of its own.
    pub floating_base: bool,
}

impl ModelOptions {
    /// The options that an artefact was made with.
    pub fn of_description(description: &DescriptionOptions) -> ModelOptions {
        ModelOptions {
            values: description.values.iter().map(|(name, value)| (name.clone(), *value)).collect(),
            mimic: if description.independent_mimic { Mimic::Independent } else { Mimic::Constraint },
            angles: if description.angles_as_given { Angles::AsGiven } else { Angles::Meant },
            rotor_inertias: description.rotor_inertia,
            floating_base: description.floating_base,
        }
    }

    /// The flags of the program that give these options, each after a space.
    pub fn flags(&self) -> String {
        let mut text: String = self.values.iter().map(|(name, x)| format!(" --value {name}={x}")).collect();
        if self.mimic == Mimic::Independent {
            text += " --mimic independent";
        }
        if self.angles == Angles::AsGiven {
            text += " --angles as-given";
        }
        match self.rotor_inertias {
            None => {}
            Some(RotorInertias::None) => text += " --rotor-inertia none",
            Some(RotorInertias::Actuated) => text += " --rotor-inertia actuated",
            Some(RotorInertias::All) => text += " --rotor-inertia all",
        }
        if self.floating_base {
            text += " --floating-base";
        }
        text
    }

    /// The options for an artefact; `None` where the description is read as it stands.
    pub fn description(&self) -> Option<DescriptionOptions> {
        let description = DescriptionOptions {
            values: self.values.iter().cloned().collect(),
            independent_mimic: self.mimic == Mimic::Independent,
            angles_as_given: self.angles == Angles::AsGiven,
            rotor_inertia: self.rotor_inertias,
            floating_base: self.floating_base,
        };
        (description != DescriptionOptions::default()).then_some(description)
    }
}

/// A description as it stands in its file, with the options applied; nothing is derived.
///
/// Fails with the place of what cannot be read, and where a symbol of `values` is not there.
pub fn read_robot(path: &Path, options: &ModelOptions) -> Result<Robot, Error> {
    parse_robot(&robot::format::text_of(path)?, path, options)
}

/// As [`read_robot`] of a text; the extension of `path` tells its format, and no file is opened.
pub fn parse_robot(text: &str, path: &Path, options: &ModelOptions) -> Result<Robot, Error> {
    let ModelOptions { mimic, angles, floating_base, .. } = *options;
    let mut robot = robot::format::parse_with(text, path, ReadOptions { mimic, angles, floating_base })?;
    if let Some(rotors) = options.rotor_inertias {
        set_rotor_inertias(&mut robot, rotors);
    }
    for (name, value) in &options.values {
        let failed = |e| Error::new(format_args!("{}: --value {name}: {e}", path.display()));
        robot.set_symbol(name, *value).map_err(failed)?;
    }
    Ok(if options.floating_base { robot.floating() } else { robot })
}

/// A sentence on the angles and axes that the reader took for other values, and on how much this changes the torque;
/// `None` where everything is as given.
pub fn snapping(robot: &Robot, text: &str, path: &Path, options: &ModelOptions) -> Option<String> {
    /// This many are named, and the others counted.
    const NAMED: usize = 4;
    if robot.snapped.is_empty() {
        return None;
    }
    let mut taken: Vec<String> =
        robot.snapped.iter().take(NAMED).map(|n| format!("{}: {}", n.subject, n.text)).collect();
    if robot.snapped.len() > NAMED {
        taken.push(format!("{} more", robot.snapped.len() - NAMED));
    }
    let as_given = parse_robot(text, path, &ModelOptions { angles: Angles::AsGiven, ..options.clone() });
    let change = match as_given.ok().and_then(|given| torque_difference(&given, robot)) {
        Some(x) => format!("the torque changes by up to {x:.1e} of its largest component"),
        None => "what that does to the torque is not known".into(),
    };
    Some(format!(
        "{}: angles are taken for what was meant ({}); {change}; --angles as-given keeps them",
        path.display(),
        taken.join("; ")
    ))
}

/// Refuses a description in which a symbol has no value, because numbers are to be computed.
pub fn check_values(robot: &Robot, path: &Path) -> Result<(), Error> {
    let missing: Vec<&str> = robot.symbols.iter().filter(|s| s.generic).map(|s| s.name.as_str()).collect();
    match missing.first() {
        None => Ok(()),
        Some(first) => Err(Error::new(format_args!(
            "{}: no value for {}: figures need one (--value {first}=0.45, or `(* Value {first} = 0.45 *)` in the file)",
            path.display(),
            missing.join(", ")
        ))),
    }
}

fn set_rotor_inertias(robot: &mut Robot, rotors: RotorInertias) {
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
