//! Command-line arguments for a model: its file, and the options for reading it.
//!
//! Reading gives the robot of the description; deriving computes its base parameters and its regressor, which may take some
//! seconds. An artefact (plan, motion, estimate) stores the options with which its model was read.

use std::path::PathBuf;

use clap::Args;
use rist::{DescriptionOptions, Model, ModelOptions, READ_EXTENSIONS, Robot};

use crate::failure::Failure;
use crate::flags::Flags;
use crate::terminal::{at_work, note};

/// The model and how to read it.
#[derive(Args)]
pub(crate) struct ModelArguments {
    #[arg(help = format!("Robot description, a {READ_EXTENSIONS} file; - is standard input"))]
    pub model: PathBuf,

    #[command(flatten)]
    options: Flags<ModelOptions>,
}

impl ModelArguments {
    /// The reading options from the flags.
    pub(crate) fn options(&self) -> Result<ModelOptions, Failure> {
        self.options.read()
    }

    /// Reads the description without deriving a model. Prints a note if the reader replaced rounded angles by exact ones.
    pub(crate) fn read(&self) -> Result<Robot, Failure> {
        self.read_by(&self.options()?)
    }

    fn read_by(&self, options: &ModelOptions) -> Result<Robot, Failure> {
        let text = rist::text_of(&self.model)?;
        let robot = rist::describe::description::parse_robot(&text, &self.model, options)?;
        if let Some(sentence) = rist::describe::description::snapping(&robot, &text, &self.model, options) {
            note(sentence);
        }
        Ok(robot)
    }

    /// Reads the description, and fails if a symbol has no value.
    pub(crate) fn read_with_values(&self) -> Result<Robot, Failure> {
        let robot = self.read()?;
        rist::describe::description::check_values(&robot, &self.model)?;
        Ok(robot)
    }

    /// Derives the model with the reading options of an artefact. An option that is also given as a flag is taken from the
    /// flag.
    pub(crate) fn derive_as(&self, description: Option<&DescriptionOptions>) -> Result<Model, Failure> {
        self.derive_by(&self.options()?.over(&description.cloned().unwrap_or_default())?)
    }

    /// Derives the model with the reading options from the flags.
    pub(crate) fn derive(&self) -> Result<Model, Failure> {
        self.derive_by(&self.options()?)
    }

    fn derive_by(&self, options: &ModelOptions) -> Result<Model, Failure> {
        let robot = self.read_by(options)?;
        rist::describe::description::check_values(&robot, &self.model)?;
        at_work(format_args!("deriving {}", self.model.display()));
        let mut model = Model::of(robot, &self.model, options.any_size)?;
        model.description = options.description();
        Ok(model)
    }
}

/// Whether the joint of the coordinate `name` slides; `None` if there is no such coordinate.
pub(crate) fn is_prismatic(model: &Model, name: &str) -> Option<bool> {
    let regressor = model.regressor();
    let place = regressor.coordinates().iter().position(|known| known == name)?;
    Some(regressor.is_prismatic(place))
}
