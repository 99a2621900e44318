//! Writes a calibration back: joint origins of a URDF, a table of zeros.

use rist::Error;
use rist::write_back::write_origins;
use robot::{Pose, Robot};

use crate::calibrate::Calibration;
use crate::chain::{Convention, Placed};
use crate::level::Level;
use crate::parameter::{Parameter, ParameterGroup};

/// The URDF `text` with the calibrated origins of the joints; zeros are part of the origins. All other bytes stay.
///
/// Fails if the text is no URDF of this robot, or if a joint is missing in it.
pub fn calibrated_urdf(
    text: &str,
    file: &str,
    robot: &Robot,
    found: &Calibration,
    level: &Level,
) -> Result<String, Error> {
    let chain = &found.problem.chain;
    let nominal = chain.placements(&vec![0.0; chain.parameters.len()]);
    let calibrated = chain.placements(&level.fit.unknowns.chain);
    let change = |((j, old), new): ((&robot::LinkId, Placed), Placed)| {
        let link = robot.link(*j);
        // Of the joint frame: in link frames, the joint frame follows after the link frame.
        let own = match chain.convention() {
            Convention::Dh => Placed::of(&link.file_frame),
            Convention::Frames => Placed::identity(),
        };
        let moved: Pose = own.inverse().then(&old.inverse()).then(&new).then(&own).pose();
        (link.joint.name.clone(), moved)
    };
    let changes: Vec<(String, Pose)> = chain.links.iter().zip(nominal).zip(calibrated).map(change).collect();
    Ok(write_origins(text, file, &changes)?)
}

/// The zeros of a level as CSV: joint, zero error and half of its 95 % interval, rad or m. A joint whose zero is not determined has
/// an empty cell. Two more columns have the errors of scales, if scales were fitted: q of the robot is (1 + scale) q + zero.
pub fn zeros_table(found: &Calibration, level: &Level) -> String {
    let all = found.parameters(level);
    let with_scales = all.iter().any(|p| p.parameter.group() == ParameterGroup::Gears);
    let mut text = String::from("joint,zero,interval,unit");
    text += if with_scales { ",scale,scale_interval\n" } else { "\n" };
    let cells = |parameter: Parameter| {
        let of = all.iter().find(|p| p.parameter == parameter);
        of.map_or(",".into(), |p| format!("{},{}", p.value, p.interval))
    };
    for &coordinate in &found.problem.chain.coordinates {
        let (name, zero) = (&found.names.coordinates[coordinate], Parameter::Zero { coordinate });
        text += &format!("{name},{},{}", cells(zero), found.names.unit(zero));
        if with_scales {
            text += &format!(",{}", cells(Parameter::Gear { coordinate }));
        }
        text += "\n";
    }
    text
}
