//! `rist datasets`: the scoreboard on folders of measured robots.

use std::path::PathBuf;

use clap::Args;
use identification::benchmark::dataset::{Dataset, Subject};

use crate::failure::{Failure, print};
use rist::{Model, ModelOptions, RotorInertias};

/// Run the known recipes on folders of measured logs, and print residuals beside their baselines
#[derive(Args)]
pub struct Arguments {
    /// The folder that holds the sets, each in a folder of its name
    folder: PathBuf,

    /// Where the robots' descriptions are, beside the sets' own folders
    #[arg(long, value_name = "DIR", default_values = ["models", "crates/identification/datasets/robots"])]
    models: Vec<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut found = 0;
    for dataset in Dataset::known()? {
        let folder = arguments.folder.join(&dataset.name);
        if !folder.is_dir() {
            continue;
        }
        found += 1;
        let places = std::iter::once(&folder).chain(&arguments.models);
        let model = places.map(|p| p.join(&dataset.model)).find(|p| p.is_file()).ok_or_else(|| {
            Failure::new(format_args!("{}: the description {} is not found", dataset.name, dataset.model))
        })?;
        let rotors = if dataset.rotors { RotorInertias::Actuated } else { RotorInertias::None };
        let options = ModelOptions { rotor_inertias: Some(rotors), ..ModelOptions::default() };
        let model = Model::read_with(&model, &options)?;
        let map = Some(model.standard_map());
        let subject = Subject { map, references: model.reference_bodies(), regressor: model.into_regressor() };
        for score in dataset.score(&folder, &subject)? {
            print(&format!("{score}\n"))?;
        }
    }
    match found {
        0 => Err(Failure::new(format_args!("{}: none of the known sets is there", arguments.folder.display()))),
        _ => Ok(()),
    }
}
