//! A file of a package (a folder that runs an identified model), and the data that the templates of such files need.
//!
//! A template is a text with placeholders such as `@PREFIX@`.

use logs::Effort;
use rist::describe::source::{IdentifiedValues, Language};
use rist::{Error, Model};

use crate::drive_units::DriveUnits;
use crate::names::{comment, filled, numbers};

/// Number of cycles for which the last safe torque is kept when states are late or are not finite. At 1 kHz these are 10 ms. In
/// this time, a joint in free fall (10 rad/s^2) gains 0.1 rad/s.
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
        // `comment` changes texts of the user so that they cannot end the comment of the generated file that contains them.
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
        // The first entry with a name counts, so `more` has priority over the common texts.
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
