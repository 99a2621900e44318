//! The model on the command line: its file, and how to read it.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use linear_model::description_options::DescriptionOptions;
use rist::description::RotorInertias;
use rist::{Model, ModelOptions};
use robot::Robot;
use robot::format::{Angles, Mimic};

use crate::failure::Failure;
use crate::terminal::{at_work, note};

/// The model and how to read it.
#[derive(Args)]
pub struct ModelArguments {
    /// Robot description: .yaml (modified DH), .urdf or .par (SYMORO); - is standard input
    pub model: PathBuf,

    /// Value of a symbol of the description, m or rad: D3=0.45 (symbols of a .par file may have no value)
    #[arg(long = "value", value_name = "NAME=VALUE", value_parser = assignment)]
    values: Vec<(String, f64)>,

    /// How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of
    /// their own
    #[arg(long, value_enum, default_value_t = MimicJoints::Constraint)]
    mimic: MimicJoints,

    /// How rounded angles are read: as the angles that were meant (1.5707 and 1.5708 as pi/2), or as given
    #[arg(long, value_enum, default_value_t = GivenAngles::Meant)]
    angles: GivenAngles,

    /// Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a YAML file that does
    /// not say: actuated; a URDF, which cannot say: none]
    #[arg(long, value_name = "JOINTS")]
    rotor_inertia: Option<RotorJoints>,

    /// Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
    /// base_roll), and the base becomes a link with its own parameters
    #[arg(long)]
    floating_base: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum RotorJoints {
    None,
    Actuated,
    All,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum GivenAngles {
    Meant,
    AsGiven,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum MimicJoints {
    Constraint,
    Independent,
}

impl ModelArguments {
    /// The options that the flags ask for.
    pub fn options(&self) -> ModelOptions {
        let rotors = |word| match word {
            RotorJoints::None => RotorInertias::None,
            RotorJoints::Actuated => RotorInertias::Actuated,
            RotorJoints::All => RotorInertias::All,
        };
        ModelOptions {
            values: self.values.clone(),
            mimic: match self.mimic {
                MimicJoints::Constraint => Mimic::Constraint,
                MimicJoints::Independent => Mimic::Independent,
            },
            angles: match self.angles {
                GivenAngles::Meant => Angles::Meant,
                GivenAngles::AsGiven => Angles::AsGiven,
            },
            rotor_inertias: self.rotor_inertia.map(rotors),
            floating_base: self.floating_base,
        }
    }

    /// The description, with nothing derived from it. Says on standard error which angles are not as given.
    pub fn read(&self) -> Result<Robot, Failure> {
        self.read_by(&self.options())
    }

    fn read_by(&self, options: &ModelOptions) -> Result<Robot, Failure> {
        let text = robot::format::text_of(&self.model)?;
        let robot = rist::description::parse_robot(&text, &self.model, options)?;
        if let Some(sentence) = rist::description::snapping(&robot, &text, &self.model, options) {
            note(sentence);
        }
        Ok(robot)
    }

    /// The description; refused where a symbol has no value.
    pub fn read_with_values(&self) -> Result<Robot, Failure> {
        let robot = self.read()?;
        rist::description::check_values(&robot, &self.model)?;
        Ok(robot)
    }

    /// The model as it was read for an artefact, where no flag says how to read it.
    pub fn derive_as(&self, description: Option<&DescriptionOptions>) -> Result<Model, Failure> {
        let given = self.options();
        match (given.description(), description) {
            (None, Some(description)) => self.derive_by(&ModelOptions::of_description(description)),
            _ => self.derive_by(&given),
        }
    }

    /// The model with all that follows from it.
    pub fn derive(&self) -> Result<Model, Failure> {
        self.derive_by(&self.options())
    }

    fn derive_by(&self, options: &ModelOptions) -> Result<Model, Failure> {
        let robot = self.read_by(options)?;
        rist::description::check_values(&robot, &self.model)?;
        at_work(format_args!("deriving {}", self.model.display()));
        let mut model = Model::of(robot, &self.model)?;
        model.description = options.description();
        Ok(model)
    }
}

fn assignment(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    match value.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok((name.trim().to_string(), x)),
        _ => Err(format!("`{value}` is not a finite number")),
    }
}
