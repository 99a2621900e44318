//! `rist convert`: a description from one format to another, or its parameters from one convention to another.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use robot::convention::Convention;
use robot::format::{write_par, write_urdf, write_yaml};
use robot::{Robot, transform_inertial};

use crate::failure::{Failure, print};
use crate::model::ModelArguments;
use crate::output::write_file;

/// Write a robot's description in another format, and say what that format cannot carry
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Format to write
    #[arg(long, value_enum, required_unless_present = "parameters")]
    to: Option<Format>,

    /// Instead, list the inertial parameters of every link by the names of a convention: symoro (in our
    /// link frames), pinocchio, urdf, figaroh, sympybotics, matlab, mujoco or drake (in the joint frames of the
    /// file)
    #[arg(long, value_name = "CONVENTION", conflicts_with = "to", value_parser = convention)]
    parameters: Option<Convention>,

    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    Par,
    Yaml,
    Urdf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(format) = arguments.to else {
        let text = listed(&arguments.model.read()?, arguments.parameters.unwrap_or(Convention::Symoro));
        return match &arguments.out {
            Some(out) => write_file(out, &text, &[&arguments.model.model]),
            None => print(&text),
        };
    };
    let (text, notes) = match format {
        Format::Par => write_par(&arguments.model.read()?),
        Format::Yaml => write_yaml(&arguments.model.read()?),
        // The conventions are in numbers: a symbol needs its value.
        Format::Urdf => write_urdf(&arguments.model.read_with_values()?),
    };
    match &arguments.out {
        Some(out) => write_file(out, &text, &[&arguments.model.model])?,
        None => print(&text)?,
    }
    for note in notes {
        eprintln!("{}: {}", note.subject, note.text);
    }
    Ok(())
}

fn convention(text: &str) -> Result<Convention, String> {
    Convention::ALL.into_iter().find(|c| c.name() == text).ok_or_else(|| {
        let names = Convention::ALL.map(Convention::name);
        format!("there is no convention `{text}`; there are {}", names.join(", "))
    })
}

/// CSV: link, parameter, value. The value is missing where the parameters of a link are not known, and where the
/// convention would divide by a mass of zero.
fn listed(robot: &Robot, convention: Convention) -> String {
    let mut text = String::from("link,parameter,value\n");
    for link in &robot.links[robot.massless..] {
        let in_frame = |x: [f64; 10]| match convention {
            Convention::Symoro => x,
            _ => transform_inertial(&x, &link.file_frame.inverse()),
        };
        let named = link.inertial.map(in_frame).and_then(|x| convention.write(&x));
        for (i, name) in convention.names().into_iter().enumerate() {
            let value = named.as_ref().map_or(String::new(), |n| format!("{:?}", n.values[i].1));
            text += &format!("{},{name},{value}\n", link.label);
        }
    }
    text
}
