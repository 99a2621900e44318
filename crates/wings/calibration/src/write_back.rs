//! Writes the result of a calibration into files: the joint origins of a URDF, the table of a YAML description, the file of
//! kinematics of a UR, or a table of zeros.
//!
//! A level is one fit of the calibration, with zeros (errors of joint positions) and possibly errors of the geometry. Scales
//! (gear ratios) cannot be written into a description.

use random::Random;
use rist::Error;
use rist::write_back::{origins, write_origins};
use robot::format::{GeometryErrors, write_geometry_into_yaml};
use robot::{Format, JointKind, LinkId, Pose, Robot};

use crate::calibrate::Calibration;
use crate::chain::{Chain, Convention, Placed};
use crate::level::Level;
use crate::parameter::{Letter, Parameter, ParameterGroup};

/// Largest allowed difference between a pose of the written description and the pose of the calibrated robot, m and rad.
const WRITTEN: f64 = 1e-9;
/// Number of random postures at which both poses are compared.
const COMPARED: usize = 5;
/// The links of a UR, named by their keys in the file of kinematics.
const UR_LINKS: [&str; 6] = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"];
/// The checksum in a file of kinematics for a UR. The driver compares it with the checksum of the robot's controller. This text
/// equals no such checksum, because the calibrated kinematics differ from those in the controller.
const UR_HASH: &str = "calib_rist";

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
    refuse_scales(found, level)?;
    if robot.format != Format::Urdf {
        return Err(Error::new(format_args!("{file}: origins are written into a URDF: convert it first")));
    }
    let chain = &found.problem.chain;
    let nominal = chain.placements(&vec![0.0; chain.parameters.len()]);
    let calibrated = chain.placements(&level.fit.unknowns.chain);
    let change = |((j, old), new): ((&LinkId, Placed), Placed)| {
        let link = robot.link(*j);
        // The poses of joint frames are needed. In the convention of link frames, each joint frame is placed relative to the
        // link frame.
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

/// Fails if the level has errors of scales, because no description has them.
fn refuse_scales(found: &Calibration, level: &Level) -> Result<(), Error> {
    let is_scale = |k: &&usize| found.problem.parameters[**k].group() == ParameterGroup::Gears;
    let scale =
        level.fit.active.iter().find(is_scale).map(|k| found.names.of(found.problem.parameters[*k]).to_string());
    let message =
        |name| format!("no description has a scale for {name}: the table of zeros has it; leave it out of [gears]");
    scale.map_or(Ok(()), |name| Err(Error::new(message(name))))
}

/// The YAML `text` with the calibrated table; zeros are terms of the joint variables. All other bytes stay. `read`: reads a text
/// like the description, but with [angles=as-given].
///
/// Fails if the table has no key for an error, or if the written text has other poses.
pub fn calibrated_yaml(
    text: &str,
    file: &str,
    read: &dyn Fn(&str) -> Result<Robot, Error>,
    robot: &Robot,
    found: &Calibration,
    level: &Level,
) -> Result<String, Error> {
    refuse_scales(found, level)?;
    if robot.format != Format::Complete || !text.contains("convention:") {
        return Err(Error::new(format_args!("{file}: a table is written into a YAML description: convert it first")));
    }
    let (chain, values) = (&found.problem.chain, &level.fit.unknowns.chain);
    if chain.convention() != Convention::Dh {
        return Err(Error::new(
            "a YAML has gamma, b, alpha, d, theta and r of each link: calibrate it with [names=dh]",
        ));
    }
    // A zero z of coordinate k adds c z to theta (or r) of each joint whose variable contains k with the factor c.
    let mut errors: Vec<(LinkId, GeometryErrors)> = robot.link_ids().map(|j| (j, [0.0; 7])).collect();
    for (parameter, x) in chain.parameters.iter().zip(values) {
        match *parameter {
            Parameter::Dh { link, letter } => errors[link].1[letter as usize] += x,
            Parameter::Zero { coordinate } => {
                for (j, errors) in &mut errors {
                    let joint = &robot.link(*j).joint;
                    let letter = if joint.kind == JointKind::Prismatic { Letter::R } else { Letter::Theta };
                    let of = joint.variable.terms.iter().filter(|(k, _)| k.0 == coordinate);
                    errors[letter as usize] += of.map(|(_, c)| c * x).sum::<f64>();
                }
            }
            _ => {}
        }
    }
    // Check before the text is returned: it is read again, and its poses must equal the calibrated poses at random positions.
    let written = write_geometry_into_yaml(text, file, robot, &errors)?;
    let other =
        |why: String| Error::new(format_args!("nothing is written: the description with the calibrated table {why}"));
    let again = read(&written).map_err(|e| other(format!("is refused: {e}")))?;
    let tip = again.link_ids().find(|j| again.link(*j).name == found.tip);
    let again = Chain::new(&again, tip.ok_or_else(|| other("has no measured link".into()))?, Convention::Dh)?;
    let (nothing, none) = (vec![0.0; chain.coordinates.len()], vec![0.0; again.parameters.len()]);
    let mut random = Random::new(1);
    for _ in 0..COMPARED {
        let q: Vec<f64> = nothing.iter().map(|_| random.between(-1.0, 1.0)).collect();
        let (a, b) = (again.pose(&q, &nothing, &none), chain.pose(&q, &nothing, values));
        let (length, angle) = ((a.position - b.position).norm(), (a.rotation - b.rotation).norm());
        if length.max(angle) > WRITTEN {
            let why =
                format!("has poses that differ by {length:.1e} m and {angle:.1e}: read it with [angles=as-given]");
            return Err(other(why));
        }
    }
    Ok(written)
}

/// The file of kinematics of a UR robot, in the form that the package ur_description reads. `calibrated`: URDF of the robot
/// with calibrated origins. For each joint, the file has the position (m) and roll, pitch and yaw (rad) in the frame of the
/// link before the joint.
///
/// Fails if a link of a UR is missing in the robot.
pub fn ur_kinematics(calibrated: &str, file: &str, robot: &Robot) -> Result<String, Error> {
    let joint = |key: &str| {
        let link = robot.links.iter().find(|link| link.name.ends_with(&format!("{key}_link")));
        link.map(|link| link.joint.name.clone()).ok_or_else(|| {
            let message = format!("the kinematics of a UR need its URDF, with a link {key}_link: {file} has none");
            Error::new(message)
        })
    };
    let joints = UR_LINKS.into_iter().map(joint).collect::<Result<Vec<String>, Error>>()?;
    let mut text = String::from("kinematics:\n");
    for (key, numbers) in UR_LINKS.into_iter().zip(origins(calibrated, file, &joints)?) {
        text += &format!("  {key}:\n");
        for (axis, x) in crate::parameter::AXES.into_iter().zip(numbers) {
            text += &format!("    {axis}: {}\n", x + 0.0);
        }
    }
    Ok(text + &format!("  hash: {UR_HASH}\n"))
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::corrections::TableCorrections;
    use crate::laws::calibrated;
    use crate::measurement::MeasurementKind;
    use crate::request::Calibrated;
    use crate::simulated::{ARM, measured, problem, truth};

    /// Reads a description with its angles exactly as given (1.5708 is not replaced by pi/2).
    fn read(text: &str, file: &str) -> Result<Robot, Error> {
        let options = rist::ModelOptions { angles: rist::AngleSnapping::AsGiven, ..Default::default() };
        rist::parse_robot(text, Path::new(file), &options)
    }

    /// A calibration of 40 simulated poses of a robot with zeros and errors of the geometry.
    fn found(robot: &Robot, convention: Convention) -> Calibration {
        let mut random = Random::new(5);
        let problem = problem(robot, convention, MeasurementKind::Pose, 40, &mut random);
        let truth = truth(&problem, 0.02, 5e-4, &mut random);
        calibrated(
            robot,
            &measured(&problem, &truth, [1e-4; 2], &mut random),
            TableCorrections::default(),
            Calibrated::Geometry,
        )
    }

    /// The largest difference between the poses of a written robot and of a calibration, at random postures.
    fn difference(written: &Robot, found: &Calibration) -> f64 {
        let (chain, values) = (&found.problem.chain, &found.level().fit.unknowns.chain);
        let tip = written.link_ids().find(|j| written.link(*j).name == found.tip).unwrap();
        let mut random = Random::new(8);
        let one = |_| {
            let q: Vec<f64> = (0..6).map(|_| random.between(-3.0, 3.0)).collect();
            let mut pose = Placed::of(&written.link_poses(&q)[tip.0]);
            if chain.convention() == Convention::Frames {
                pose = pose.then(&Placed::of(&written.link(tip).file_frame));
            }
            let wanted = chain.pose(&q, &[0.0; 6], values);
            (pose.position - wanted.position).norm() + (pose.rotation - wanted.rotation).norm()
        };
        (0..20).map(one).fold(0.0, f64::max)
    }

    /// The robot of a written table has the calibrated poses, also if the table is in degrees and millimetres. The error beta
    /// of the parallel axes is written as an additional fixed link, because the table has no column for beta.
    #[test]
    fn a_written_table_has_the_calibrated_poses() {
        let in_degrees =
            ARM.replace("pi/2", "90").replace("name: arm", "name: arm\nangles: deg\nlengths: mm # drawing");
        let in_degrees =
            in_degrees.replace("0.15", "150").replace("0.6", "600").replace("0.1,", "100,").replace("60050", "650");
        for text in [ARM, &in_degrees] {
            let robot = read(text, "arm.yaml").unwrap();
            let found = found(&robot, Convention::Dh);
            let beta = |k: usize| matches!(found.problem.parameters[k], Parameter::Dh { letter: Letter::Beta, .. });
            assert!(found.level().fit.active.iter().any(|k| beta(*k)));
            let again = |text: &str| read(text, "arm.yaml");
            let written = calibrated_yaml(text, "arm.yaml", &again, &robot, &found, found.level()).unwrap();
            assert!(written.contains("{link: beta3, antecedent: 2, joint: fixed,"), "{written}");
            // The limit allows for the rounding of thirty numbers that are written with seventeen digits.
            assert!(difference(&read(&written, "arm.yaml").unwrap(), &found) < 1e-12, "{written}");
            // If the written angles were replaced by exact ones at reading, the robot would be another one. This is refused
            // with a message.
            let rounded = |text: &str| rist::parse_robot(text, Path::new("arm.yaml"), &rist::ModelOptions::default());
            let wrong = |_: &str| rounded(text);
            let refused = calibrated_yaml(text, "arm.yaml", &wrong, &robot, &found, found.level()).unwrap_err();
            assert!(refused.to_string().contains("nothing is written"), "{refused}");
        }
        let robot = read(ARM, "arm.yaml").unwrap();
        let craig = ARM.replace("khalil-kleinfinger", "craig").replace(" d:", " a:").replace(" r:", " d:");
        let found = found(&robot, Convention::Dh);
        let again = |text: &str| read(text, "arm.yaml");
        let refused = calibrated_yaml(&craig, "arm.yaml", &again, &robot, &found, found.level()).unwrap_err();
        assert!(refused.to_string().contains("no key for the error of beta3"), "{refused}");
    }

    /// The kinematics of a UR, put into its URDF as origins, have the calibrated poses.
    #[test]
    fn the_kinematics_of_a_ur_have_the_calibrated_poses() {
        let half = std::f64::consts::PI;
        let origins = [
            "0 0 0.18 0 0 0".into(),
            format!("0 0 0 {} 0 0", 0.5 * half),
            "-0.61 0 0 0 0 0".into(),
            "-0.57 0 0.17 0 0 0".into(),
            format!("0 -0.12 0 {} 0 0", 0.5 * half),
            format!("0 0.12 0 {} {half} {half}", 0.5 * half),
        ];
        let urdf = |origins: &[String]| {
            let mut text = String::from(
                "<robot name='ur'><link name='base_link'/><link name='base_link_inertia'/><joint name='b' \
                type='fixed'><parent link='base_link'/><child link='base_link_inertia'/><origin rpy='0 0 3.141592653589793'/></joint>",
            );
            let mut parent = "base_link_inertia".to_string();
            for (key, origin) in UR_LINKS.into_iter().zip(origins) {
                let numbers: Vec<&str> = origin.split(' ').collect();
                let (xyz, rpy) = (numbers[..3].join(" "), numbers[3..].join(" "));
                text += &format!(
                    "<link name='{key}_link'/><joint name='{key}_joint' type='revolute'><parent link='{parent}'/>\
                    <child link='{key}_link'/><axis xyz='0 0 1'/><origin xyz='{xyz}' rpy='{rpy}'/>\
                    <limit lower='-3' upper='3' effort='1' velocity='1'/></joint>"
                );
                parent = format!("{key}_link");
            }
            text + "</robot>"
        };
        let given = urdf(&origins);
        let robot = read(&given, "ur.urdf").unwrap();
        for convention in [Convention::Frames, Convention::Dh] {
            let found = found(&robot, convention);
            let written = calibrated_urdf(&given, "ur.urdf", &robot, &found, found.level()).unwrap();
            let text = ur_kinematics(&written, "ur.urdf", &robot).unwrap();
            let numbers = |key: &str| -> String {
                let own = text.split(&format!("  {key}:\n")).nth(1).unwrap().lines().take(6);
                let pairs: Vec<(&str, &str)> = own.map(|line| line.trim().split_once(": ").unwrap()).collect();
                assert_eq!(pairs.iter().map(|p| p.0).collect::<Vec<_>>(), ["x", "y", "z", "roll", "pitch", "yaw"]);
                pairs.iter().map(|p| p.1).collect::<Vec<_>>().join(" ")
            };
            assert!(text.starts_with("kinematics:\n") && text.ends_with("  hash: calib_rist\n"), "{text}");
            let again = read(&urdf(&UR_LINKS.map(numbers)), "ur.urdf").unwrap();
            // The limit allows for the rounding of thirty-six numbers that are written with seventeen digits.
            assert!(difference(&again, &found) < 1e-12, "{text}");
        }
        let refused = ur_kinematics(&given, "arm.urdf", &read(ARM, "arm.yaml").unwrap()).unwrap_err().to_string();
        assert!(refused.contains("with a link shoulder_link: arm.urdf has none"), "{refused}");
    }
}
