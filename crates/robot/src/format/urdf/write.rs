//! A robot written as a URDF: link frames are Khalil's, so that every joint turns about its own z.
//!
//! The joint frame of a URDF at q = 0 is iTj of the table with the constant part of the joint
//! variable in it. Inertias go about the centre of mass, in the axes of the link frame. A URDF is a
//! tree with numbers: loops are cut, symbols become their values, and a joint that follows exactly
//! one other by a factor and an offset mimics it.

use std::fmt::Write;

use crate::inertial::{Matrix3, Part, Pose};
use crate::robot::{Drive, JointKind, Limits, Note, Robot, RotorInertia};
use crate::value::CoordinateId;

/// The text, and what it could not carry.
pub fn write_urdf(robot: &Robot) -> (String, Vec<Note>) {
    let mut notes = Vec::new();
    let mut text = String::new();
    // Writing to a String cannot fail.
    macro_rules! line {
        ($($part:tt)*) => {{ let _ = writeln!(text, $($part)*); }};
    }
    let mut note = |subject: &str, text: String| notes.push(Note { subject: subject.into(), text });
    line!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">", escaped(&robot.name));
    let names = unique(robot.links.iter().map(|l| l.name.clone()), "base");
    let joints = unique(
        robot.links.iter().map(|l| match (l.joint.drive, &l.joint.variable.terms[..]) {
            (Drive::Actuated, [(k, _)]) => robot.coordinate_name(*k).to_string(),
            _ => l.joint.name.clone(),
        }),
        "",
    );
    line!("  <link name=\"base\"/>");
    for (j, link) in robot.links.iter().enumerate() {
        let joint = &link.joint;
        line!("  <link name=\"{}\">", escaped(&names[j]));
        match link.inertial.map(|x| (x, Part::from_parameters(link.name.clone(), &x, Pose::IDENTITY.rotation))) {
            None => note(&link.name, "its parameters are unknown: no <inertial> is written".into()),
            Some((x, None)) => {
                if x.iter().any(|x| *x != 0.0) {
                    note(
                        &link.name,
                        "has inertia but no mass, which a URDF cannot say: no <inertial> is written".into(),
                    );
                }
            }
            Some((_, Some(part))) => {
                let [x, y, z] = part.pose.position;
                let [xx, xy, xz, yy, yz, zz] = part.inertia;
                line!(
                    "    <inertial>\n      <origin xyz=\"{x} {y} {z}\" rpy=\"0 0 0\"/>\n      <mass value=\"{}\"/>",
                    part.mass
                );
                line!(
                    "      <inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n    </inertial>"
                );
            }
        }
        line!("  </link>");
        let pose = link.geometry.pose(&robot.symbols, 0.0, 0.0);
        let moves = !joint.variable.terms.is_empty() && joint.kind != JointKind::Fixed;
        let limits = match (joint.drive, &joint.variable.terms[..]) {
            (Drive::Actuated, [(CoordinateId(k), _)]) => {
                robot.coordinates.get(*k).map(|c| c.limits).unwrap_or_default()
            }
            _ => Limits::default(),
        };
        let range = limits.position.filter(|p| p.0.is_finite() && p.1.is_finite());
        let kind = match joint.kind {
            _ if !moves => "fixed",
            JointKind::Prismatic => "prismatic",
            _ if range.is_some() => "revolute",
            _ => "continuous",
        };
        let [x, y, z] = pose.position;
        let [roll, pitch, yaw] = roll_pitch_yaw(&pose.rotation);
        line!("  <joint name=\"{}\" type=\"{kind}\">", escaped(&joints[j]));
        line!("    <origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>");
        let parent = link.antecedent.map_or("base", |i| names[i.0].as_str());
        line!("    <parent link=\"{}\"/>\n    <child link=\"{}\"/>", escaped(parent), escaped(&names[j]));
        if moves {
            // A coordinate that runs against its joint turns the axis.
            let against = joint.drive == Drive::Actuated && joint.variable.terms[0].1 < 0.0;
            line!("    <axis xyz=\"0 0 {}\"/>", if against { "-1" } else { "1" });
            let mut attributes = String::new();
            if let Some((low, high)) = range {
                attributes += &format!("lower=\"{low}\" upper=\"{high}\" ");
            } else if kind == "prismatic" {
                attributes += "lower=\"-1000\" upper=\"1000\" ";
                note(&joints[j], "slides without limits, which a URDF asks for: +-1000 m are written".into());
            }
            let number = |x: Option<f64>| x.unwrap_or(0.0);
            line!(
                "    <limit {attributes}effort=\"{}\" velocity=\"{}\"/>",
                number(limits.effort),
                number(limits.velocity)
            );
            if limits.acceleration.is_some() {
                note(&joints[j], "its limit of acceleration is not carried".into());
            }
        }
        let friction = joint.friction;
        if friction.viscous.is_some() || friction.coulomb.is_some() {
            let attribute = |key: &str, x: Option<f64>| x.map_or(String::new(), |x| format!(" {key}=\"{x}\""));
            let (damping, dry) = (attribute("damping", friction.viscous), attribute("friction", friction.coulomb));
            line!("    <dynamics{damping}{dry}/>");
        }
        if friction.offset.is_some() || joint.drive_gain.is_some() {
            note(&joints[j], "the offset of its friction and its drive gain are not carried".into());
        }
        if joint.rotor_inertia.is_modelled() {
            let value = match joint.rotor_inertia {
                RotorInertia::Known(x) => format!(" ({x} kg m^2)"),
                _ => String::new(),
            };
            note(&joints[j], format!("a URDF has no rotor inertia: IA{value} is not carried"));
        }
        if joint.drive == Drive::Passive && moves {
            match &joint.variable.terms[..] {
                [(k, c)] if robot.joint_of(*k).is_some() => {
                    let leader = robot.joint_of(*k).map_or("", |j| joints[j.0].as_str());
                    line!("    <mimic joint=\"{}\" multiplier=\"{c}\" offset=\"0\"/>", escaped(leader));
                }
                _ => note(&joints[j], "follows several coordinates, which a URDF cannot say: written as free".into()),
            }
        }
        line!("  </joint>");
    }
    line!("</robot>");
    for (l, _) in robot.loops.iter().enumerate() {
        note(&format!("loop {}", l + 1), "a URDF is a tree: the loop is written cut open".into());
    }
    if robot.gravity_number() != [0.0, 0.0, -9.81] {
        let [x, y, z] = robot.gravity_number();
        note("gravity", format!("a URDF has none: ({x}, {y}, {z}) m/s^2 is not carried"));
    }
    if !robot.symbols.is_empty() {
        let names: Vec<&str> = robot.symbols.iter().map(|s| s.name.as_str()).collect();
        note("symbols", format!("written as numbers: {}", names.join(", ")));
    }
    (text, notes)
}

/// R = Rz(yaw) Ry(pitch) Rx(roll).
fn roll_pitch_yaw(r: &Matrix3) -> [f64; 3] {
    let across = r[0][0].hypot(r[1][0]);
    let pitch = (-r[2][0]).atan2(across);
    if across > 1e-12 {
        [r[2][1].atan2(r[2][2]), pitch, r[1][0].atan2(r[0][0])]
    } else {
        // Roll and yaw turn about one line: all of it is yaw's.
        [0.0, pitch, (-r[0][1]).atan2(r[1][1])]
    }
}

fn unique(names: impl Iterator<Item = String>, taken: &str) -> Vec<String> {
    let mut all: Vec<String> = vec![taken.into()];
    for mut name in names {
        while all.contains(&name) {
            name.push('_');
        }
        all.push(name);
    }
    all.split_off(1)
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
