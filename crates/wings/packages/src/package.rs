//! Makes the files of a package.

use logs::Effort;
use rist::describe::source::{IdentifiedValues, Language};
use rist::{Error, Estimate, Model};
use robot::CoordinateId;

use crate::drive_units::DriveUnits;
use crate::names::{comment, filled, numbers};
use crate::request::{PackageRequest, PackageTarget};
use crate::{arduino, lerobot, ros2_control};

/// Number of cycles for which the last safe torque is kept when states are late or no numbers. At 1 kHz it is 10 ms, in which a
/// joint in free fall gains 0.1 rad/s (with 10 rad/s^2).
pub(crate) const HOLD_CYCLES: usize = 10;

/// A file of a package.
#[derive(Clone, Debug, PartialEq)]
pub struct PackageFile {
    /// The path in the folder of the package, with `/` between folders.
    pub path: String,
    /// The text of the file.
    pub text: String,
}

/// Everything that the templates of a package need.
pub(crate) struct PackageParts<'a> {
    pub model: &'a Model,
    pub values: &'a IdentifiedValues,
    pub drives: DriveUnits,
    /// Largest torque of each joint, N m (N); zero for a joint without a drive.
    pub limits: Vec<f64>,
    pub made_by: &'a str,
    /// The name of the robot as an identifier, as in the generated C file.
    pub prefix: String,
}

/// The files that run the model of an estimate on a robot. `values`: the values of the estimate. `made_by`: the command that the
/// heads of the files name.
///
/// Fails if the request has no target, if a joint has no torque limit, if a drive has no gain, or if the robot has a floating
/// base or loops that are solved numerically.
pub fn package(
    model: &Model,
    estimate: &Estimate,
    values: &IdentifiedValues,
    request: &PackageRequest,
    made_by: &str,
) -> Result<Vec<PackageFile>, Error> {
    let target = request.target.ok_or_else(|| Error::new("[target] is missing"))?;
    let robot = &model.robot;
    if robot.massless > 0 || !robot.passive.is_empty() {
        let what = if robot.massless > 0 { "a base that floats" } else { "passive joints that are solved numerically" };
        return Err(Error::new(format_args!(
            "{}: a package is for arms on a fixed base, and this robot has {what}; [language=c] writes the functions alone",
            robot.name
        )));
    }
    let drives = DriveUnits::of(model, estimate, &request.options.clone().unwrap_or_default())?;
    let limits = limits(model, &drives.is_driven)?;
    let prefix = modeling::module(robot, &[]).map_err(Error::new)?.name;
    let parts = PackageParts { model, values, drives, limits, made_by, prefix };
    match target {
        PackageTarget::Ros2Control => ros2_control::files(&parts),
        PackageTarget::Lerobot => lerobot::files(&parts),
        PackageTarget::Arduino => arduino::files(&parts),
    }
}

/// The torque limits of the description. Fails if a joint with a drive has none.
fn limits(model: &Model, is_driven: &[bool]) -> Result<Vec<f64>, Error> {
    let limit = |(k, is_driven): (usize, &bool)| {
        let coordinate = &model.robot.coordinates[k];
        match coordinate.limits.effort.filter(|effort| *effort > 0.0 && effort.is_finite()) {
            _ if !is_driven => Ok(0.0),
            Some(effort) => Ok(effort),
            None => Err(Error::new(format_args!(
                "{}: the joint {} has no torque limit, and a package needs one of each: in a URDF write \
                 `<limit effort=\"..\"/>`, in YAML `limits: {{effort: ..}}` at the joint, in N m (N)",
                model.path.display(),
                model.robot.coordinate_name(CoordinateId(k))
            ))),
        }
    };
    is_driven.iter().enumerate().map(limit).collect()
}

impl PackageParts<'_> {
    /// The generated source of the controllers and of `functions`, and its header.
    pub(crate) fn controller_in_c(&self, functions: &[&str]) -> Result<(String, String), Error> {
        let functions: Vec<String> = ["controller"].iter().chain(functions).map(|name| name.to_string()).collect();
        let language = Language::C { header: format!("{}.h", self.prefix) };
        let robot = &self.model.robot;
        let made = rist::generate(robot, &functions, &language, self.made_by, Some(self.values), &[], true)?;
        Ok((made.text, made.header.unwrap_or_default()))
    }

    /// The template with the texts that all packages have, and with `more`.
    pub(crate) fn filled(&self, template: &str, more: &[(&str, String)]) -> String {
        let drives = &self.drives;
        let [position, velocity, effort] = drives.units.clone().map(|unit| comment(&unit));
        let real = |x: &[f64]| numbers(x, "(real)");
        let kind = match drives.effort {
            Effort::Torque => "torques",
            Effort::Current => "motor currents",
            Effort::PositionError => "goal offsets of position servos",
        };
        let left_out = match self.values.left_out.is_empty() {
            true => "none".to_string(),
            false => comment(&self.values.left_out.join(", ")),
        };
        let joints: Vec<&str> = self.model.regressor().coordinates().iter().map(String::as_str).collect();
        let limit = |(name, limit): (&&str, &f64)| format!("{} {limit}", comment(name));
        let limits: Vec<String> = joints.iter().zip(&self.limits).map(limit).collect();
        let common = [
            ("PREFIX", self.prefix.clone()),
            ("UPPER", self.prefix.to_ascii_uppercase()),
            ("ROBOT", comment(&self.model.robot.name)),
            ("MADE_BY", comment(self.made_by)),
            ("FINGERPRINT", self.model.reference.fingerprint.clone()),
            ("N", joints.len().to_string()),
            ("HOLD", HOLD_CYCLES.to_string()),
            ("POSITION_UNIT", position),
            ("VELOCITY_UNIT", velocity),
            ("EFFORT_UNIT", effort),
            ("EFFORT_KIND", kind.to_string()),
            ("LEFT_OUT", left_out),
            ("LIMIT_LIST", limits.join(", ")),
            ("POSITIONS", real(&drives.positions)),
            ("VELOCITIES", real(&drives.velocities)),
            ("OFFSETS", real(&drives.offsets)),
            ("EFFORTS", real(&drives.efforts)),
            ("SPRINGS", real(&drives.springs)),
            ("LIMITS", real(&self.limits)),
        ];
        filled(template, &[more, &common].concat())
    }

    /// The files of the C code in `folder`: the generated functions, and one cycle of a controller.
    pub(crate) fn c_files(&self, folder: &str, functions: &[&str]) -> Result<Vec<PackageFile>, Error> {
        let (source, header) = self.controller_in_c(functions)?;
        let path = |name: &str| format!("{folder}{}{name}", self.prefix);
        Ok(vec![
            PackageFile { path: path(".c"), text: source },
            PackageFile { path: path(".h"), text: header },
            PackageFile { path: path("_step.c"), text: self.filled(include_str!("../templates/common/step.c"), &[]) },
            PackageFile { path: path("_step.h"), text: self.filled(include_str!("../templates/common/step.h"), &[]) },
        ])
    }
}
