//! How a description is read.

use linear_model::description_options::{DescriptionOptions, RotorInertias};
use robot::format::{Angles, Mimic};

use super::request;

request! {
    /// How a description is read; the default is as it stands.
    pub struct ModelOptions {
        /// Value of a symbol of the description, m or rad: D3=0.45 (symbols of a .par file may have no value).
        value: Vec<(String, f64)> = Vec::new(), value_name("NAME=VALUE");
        /// Value of an argument of a xacro, which `$(arg NAME)` asks for [default: as the file says].
        arg: Vec<(String, String)> = Vec::new(), value_name("NAME=VALUE");
        /// Folder of a package that a xacro includes from, which `$(find NAME)` asks for; no other is opened but that of
        /// the file.
        package: Vec<(String, String)> = Vec::new(), value_name("NAME=FOLDER");
        /// How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of their own.
        mimic: Mimic = Mimic::Constraint;
        /// How rounded angles are read: as the angles that were meant (1.5707 and 1.5708 as pi/2), or as given.
        angles: Angles = Angles::Meant;
        /// Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a YAML file that does
        /// not say: actuated; a URDF, which cannot say: none].
        rotor_inertia: Option<RotorInertias> = None, value_name("JOINTS");
        /// Joints that stand still at a position, rad or m, as a gripper that the log does not have: finger=0.02. Without it
        /// no joint is locked.
        lock: Vec<(String, f64)> = Vec::new(), value_name("JOINT=POSITION");
        /// How the base is mounted, rad: roll, pitch and yaw of its frame in one in which gravity is as the file says.
        /// 3.1416,0,0 is a robot on a ceiling [default: as the file says].
        base: Option<[f64; 3]> = None, value_name("ROLL,PITCH,YAW");
        /// Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch, base_roll), and
        /// the base becomes a link with its own parameters.
        floating_base: bool = false;
        /// Derive the model even where that takes more than about 10 s or 1 GiB, which is refused with the figures otherwise.
        any_size: bool = false;
    }
}

impl ModelOptions {
    /// The options that an artefact was made with.
    pub fn of_description(description: &DescriptionOptions) -> ModelOptions {
        ModelOptions {
            value: description.values.iter().map(|(name, value)| (name.clone(), *value)).collect(),
            arg: description.arguments.iter().map(|(name, text)| (name.clone(), text.clone())).collect(),
            package: description.packages.iter().map(|(name, folder)| (name.clone(), folder.clone())).collect(),
            mimic: if description.independent_mimic { Mimic::Independent } else { Mimic::Constraint },
            angles: if description.angles_as_given { Angles::AsGiven } else { Angles::Meant },
            rotor_inertia: description.rotor_inertia,
            lock: description.locked.iter().map(|(name, position)| (name.clone(), *position)).collect(),
            base: description.base,
            floating_base: description.floating_base,
            any_size: false,
        }
    }

    /// The options for an artefact; `None` where the description is read as it stands.
    pub fn description(&self) -> Option<DescriptionOptions> {
        let description = DescriptionOptions {
            values: self.value.iter().cloned().collect(),
            arguments: self.arg.iter().cloned().collect(),
            packages: self.package.iter().cloned().collect(),
            independent_mimic: self.mimic == Mimic::Independent,
            angles_as_given: self.angles == Angles::AsGiven,
            rotor_inertia: self.rotor_inertia,
            locked: self.lock.iter().cloned().collect(),
            base: self.base,
            floating_base: self.floating_base,
        };
        (description != DescriptionOptions::default()).then_some(description)
    }
}
