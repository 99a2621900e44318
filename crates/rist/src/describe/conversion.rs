//! Writes a robot in another format, and its inertial parameters in another convention.
//!
//! A convention defines the frame and the point to which the inertial parameters refer. A written text is read again, and the
//! two robots are compared, to find properties that were lost.

use std::sync::OnceLock;

use robot::convention::Convention;
use robot::format::{AngleSnapping, ReadOptions, write_urdf, write_yaml};
use robot::{Note, PassiveCoordinate, Robot, transform_inertial};

use crate::describe::torque_difference::torque_difference;
use crate::error::Error;
use crate::request::DescriptionFormat;

/// The result of [`convert`]: a description in another format.
#[derive(Clone, Debug)]
pub struct Converted {
    /// The text of the file.
    pub text: String,
    /// Sentences on properties that the format cannot state.
    pub notes: Vec<String>,
    /// Properties of the robot that are missing in the text. They are found by reading the text back.
    pub differences: Vec<String>,
}

/// Writes a robot in another format, and reads the text back to find lost properties.
///
/// Fails if the format cannot describe the robot.
pub fn convert(robot: &Robot, format: DescriptionFormat) -> Result<Converted, Error> {
    let (text, notes) = match format {
        DescriptionFormat::Par => registered_writer(format)?(robot),
        DescriptionFormat::Yaml => write_yaml(robot),
        DescriptionFormat::Urdf => write_urdf(robot),
    };
    let differences = read_back(robot, &text, format)?;
    let notes = notes.iter().map(|note| format!("{}: {}", note.subject, note.text)).collect();
    Ok(Converted { text, notes, differences })
}

/// A function that writes a robot as text. The notes name properties that the format cannot express.
pub type WriteDescription = fn(&Robot) -> (String, Vec<Note>);

/// The writer of one output format. Another package registers it.
#[derive(Clone, Copy)]
pub struct DescriptionWriter {
    /// The output format.
    pub format: DescriptionFormat,
    /// The function that writes this format; an error text if this build does not contain the function.
    pub write: Result<WriteDescription, &'static str>,
}

static WRITERS: OnceLock<Vec<DescriptionWriter>> = OnceLock::new();

/// Registers the writers of other packages; only the first call has an effect.
pub(crate) fn register(writers: Vec<DescriptionWriter>) {
    WRITERS.get_or_init(|| writers);
}

/// The registered writer of `format`. Fails if no writer is registered for this format.
fn registered_writer(format: DescriptionFormat) -> Result<WriteDescription, Error> {
    let mut writers = WRITERS.get().into_iter().flatten();
    let writer = writers.find(|writer| writer.format == format).map(|writer| writer.write);
    writer.unwrap_or(Err("no writer of this format is registered")).map_err(Error::new)
}

/// Relative torque differences up to this value count as rounding. They occur because a URDF has other frames and writes angles
/// as decimals.
const RELATIVE_TORQUE_ROUNDING: f64 = 1e-9;

/// The properties of the robot that are missing in `text`, which is read back. Fails if the text cannot be read.
fn read_back(robot: &Robot, text: &str, format: DescriptionFormat) -> Result<Vec<String>, Error> {
    let options =
        ReadOptions { angles: AngleSnapping::AsGiven, floating_base: robot.massless > 0, ..ReadOptions::default() };
    let read = match format {
        DescriptionFormat::Par => robot::format::read_par(text, "the result"),
        DescriptionFormat::Yaml => robot::format::read_yaml(text, "the result"),
        DescriptionFormat::Urdf => robot::format::read_urdf_with(text, "the result", options),
    };
    let read = read.map_err(|e| {
        Error::new(format_args!("{}: this format cannot carry the robot: written, it is refused with: {e}", robot.name))
    })?;
    let mut differences = Vec::new();
    // The text may list the coordinates in another order, or lack some coordinates.
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
    // Properties of this robot that the format cannot express.
    if robot.massless > 0 {
        let n = robot.massless;
        differences.push(format!(
            "the {n} links without mass that carry the base are written as bodies with parameters of their own; write the \
             robot without [floating_base] and let it float when it is read"
        ));
    }
    let starts = |r: &Robot| r.passive.iter().map(|p| p.start).collect::<Vec<_>>();
    if starts(robot).iter().any(|s| *s != 0.0) && starts(robot) != starts(&read) {
        let start = |p: &PassiveCoordinate| format!("{} = {}", p.name, p.start);
        let starts: Vec<String> = robot.passive.iter().map(start).collect();
        differences.push(format!("where the search for passive joints starts is not carried: {}", starts.join(", ")));
    }
    // Any other lost property changes the torques.
    if let Some(x) = torque_difference(robot, &read).filter(|x| *x > RELATIVE_TORQUE_ROUNDING) {
        differences.push(format!("the result is another robot: its torques differ by {x:.1e} of the largest"));
    }
    Ok(differences)
}

/// The inertial parameters as CSV: link, parameter, value. The value is empty if the parameters of the link are not known, or
/// if the convention would divide by a mass of zero.
pub fn inertial_table(robot: &Robot, convention: Convention) -> String {
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
