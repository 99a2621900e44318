//! `rist convert`: a description from one format to another, or its parameters from one convention to another.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use robot::convention::Convention;
use robot::format::{Angles, ReadOptions, write_par, write_urdf, write_yaml};
use robot::{PassiveCoordinate, Robot, transform_inertial};

use crate::failure::Failure;
use crate::model::ModelArguments;
use crate::terminal::{self, print};
use rist::output::write_file;

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
            Some(out) => Ok(write_file(out, &text, &[&arguments.model.model])?),
            None => print(&text),
        };
    };
    let robot = match format {
        Format::Par | Format::Yaml => arguments.model.read()?,
        // The conventions are in numbers: a symbol needs its value.
        Format::Urdf => arguments.model.read_with_values()?,
    };
    let (text, notes) = match format {
        Format::Par => write_par(&robot),
        Format::Yaml => write_yaml(&robot),
        Format::Urdf => write_urdf(&robot),
    };
    let differences = read_back(&robot, &text, format)?;
    match &arguments.out {
        Some(out) => write_file(out, &text, &[&arguments.model.model])?,
        None => print(&text)?,
    }
    for note in notes {
        terminal::note(format_args!("{}: {}", note.subject, note.text));
    }
    for difference in differences {
        terminal::note(format_args!("{}: {difference}", arguments.model.model.display()));
    }
    Ok(())
}

/// Relative difference of torques that rounding explains: a URDF has other frames and its angles as decimals.
const ROUNDING: f64 = 1e-9;

/// What of the robot is not in the text, by reading it. Fails where it cannot be read: then nothing is written.
fn read_back(robot: &Robot, text: &str, format: Format) -> Result<Vec<String>, Failure> {
    let options = ReadOptions { angles: Angles::AsGiven, floating_base: robot.massless > 0, ..ReadOptions::default() };
    let read = match format {
        Format::Par => robot::format::read_par(text, "the result"),
        Format::Yaml => robot::format::read_yaml(text, "the result"),
        Format::Urdf => robot::format::read_urdf_with(text, "the result", options),
    };
    let read = read.map_err(|e| {
        Failure::new(format_args!(
            "{}: this format cannot carry the robot: written, it is refused with: {e}",
            robot.name
        ))
    })?;
    let mut differences = Vec::new();
    let names = |r: &Robot| r.coordinates.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let (before, after) = (names(robot), names(&read));
    let mut sorted = [before.clone(), after.clone()];
    sorted.iter_mut().for_each(|names| names.sort());
    if before != after && sorted[0] == sorted[1] {
        differences.push(format!("the coordinates come in another order: {}", after.join(", ")));
    }
    if before.len() != after.len() {
        differences.push(format!("{} coordinates become {}", before.len(), after.len()));
    }
    if robot.massless > 0 {
        let n = robot.massless;
        differences.push(format!(
            "the {n} links without mass that carry the base are written as bodies with parameters of their own; write the \
             robot without --floating-base and let it float when it is read"
        ));
    }
    let starts = |r: &Robot| r.passive.iter().map(|p| p.start).collect::<Vec<_>>();
    if starts(robot).iter().any(|s| *s != 0.0) && starts(robot) != starts(&read) {
        let start = |p: &PassiveCoordinate| format!("{} = {}", p.name, p.start);
        let starts: Vec<String> = robot.passive.iter().map(start).collect();
        differences.push(format!("where the search for passive joints starts is not carried: {}", starts.join(", ")));
    }
    if let Some(x) = rist::torque_difference::torque_difference(robot, &read).filter(|x| *x > ROUNDING) {
        differences.push(format!("the result is another robot: its torques differ by {x:.1e} of the largest"));
    }
    Ok(differences)
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
