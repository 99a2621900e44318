//! Writes repaired bodies into the description from which they were read. Only the numbers of these bodies change.
//!
//! A repair is the correction that a finding of `rist lint` proposes for the inertial parameters of a body.

use logs::Error;
use robot::format::{roll_pitch_yaw, write_repairs_into_yaml};
use robot::lint::RepairedBody;
use robot::{Robot, turned_inertia};
use roxmltree::Document;

use crate::write_back::mjcf_into::set_inertial;
use crate::write_back::mjcf_names;
use crate::write_back::text_edit::Edits;
use crate::write_back::urdf::{element, six};

/// The description `text` with repaired bodies. `robot` was read from this text.
///
/// Fails if the text is neither a URDF nor an MJCF nor a YAML, or if a body is missing in it.
pub(super) fn write_repairs(
    text: &str,
    file: &str,
    robot: &Robot,
    bodies: &[&RepairedBody],
) -> Result<String, crate::error::Error> {
    match Document::parse(text).map(|document| document.root_element().tag_name().name().to_string()).as_deref() {
        Ok("robot") => Ok(into_urdf(text, file, bodies)?),
        Ok("mujoco") => Ok(into_mjcf(text, file, bodies)?),
        Err(_) if text.contains("standard_parameters") => Ok(write_repairs_into_yaml(text, file, robot, bodies)?),
        _ => {
            let message = "repairs are written into a URDF, an MJCF or a YAML: convert it first";
            Err(Error::at(file, 0, message).into())
        }
    }
}

fn into_urdf(text: &str, file: &str, bodies: &[&RepairedBody]) -> Result<String, Error> {
    let document = parsed(text, file)?;
    let mut edits = Edits::of(text);
    for body in bodies {
        let link = element(document.root_element(), "link", &body.name, file)?;
        let missing = || Error::at(file, 0, format!("link {}: it has no <inertial> to write into", body.name));
        let inertial = link.children().find(|n| n.has_tag_name("inertial")).ok_or_else(missing)?;
        if body.is_moved {
            let [x, y, z] = body.pose.position;
            // Adding zero writes 0 for -0.
            let rpy = roll_pitch_yaw(&body.pose.rotation).map(|angle| (angle + 0.0).to_string()).join(" ");
            edits.set_child(&inertial, "origin", &[("xyz", format!("{x} {y} {z}")), ("rpy", rpy)]);
        }
        edits.set_child(&inertial, "mass", &[("value", body.mass.to_string())]);
        edits.set_child(&inertial, "inertia", &six(&body.inertia));
    }
    Ok(edits.apply())
}

/// If an `<inertial>` has principal moments (`diaginertia`) and the body is not moved, it keeps principal moments. Other
/// inertias are written in the axes of the body, because `fullinertia` has no orientation.
fn into_mjcf(text: &str, file: &str, bodies: &[&RepairedBody]) -> Result<String, Error> {
    let document = parsed(text, file)?;
    let mut edits = Edits::of(text);
    for body in bodies {
        let node = mjcf_names::element(&document, "body", &body.name, file)?;
        let inertial = node.children().find(|n| n.has_tag_name("inertial"));
        let [xx, xy, xz, yy, yz, zz] = body.inertia;
        let is_principal = [xy, xz, yz] == [0.0; 3] && !body.is_moved;
        if let Some(inertial) = inertial.filter(|n| is_principal && n.has_attribute("diaginertia")) {
            let numbers = [("mass", body.mass.to_string()), ("diaginertia", format!("{xx} {yy} {zz}"))];
            edits.set_attributes(&inertial, &numbers);
            continue;
        }
        let [xx, xy, xz, yy, yz, zz] = turned_inertia(&body.inertia, &body.pose.rotation);
        let ([x, y, z], mass) = (body.pose.position, body.mass);
        let six = format!("{xx} {yy} {zz} {xy} {xz} {yz}");
        set_inertial(
            &mut edits,
            &node,
            &format!("<inertial pos=\"{x} {y} {z}\" mass=\"{mass}\" fullinertia=\"{six}\"/>"),
        );
    }
    Ok(edits.apply())
}

fn parsed<'a>(text: &'a str, file: &str) -> Result<Document<'a>, Error> {
    Document::parse(text).map_err(|e| Error::at(file, e.pos().row as usize, e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot::Pose;
    use robot::format::read_urdf;

    const URDF: &str = r#"<?xml version="1.0"?>
<robot name="arm"><link name="base"/>
  <link   name="upper">   <!-- keep me -->
    <inertial>
      <!-- from CAD -->
      <mass value='2.0'/>
      <origin xyz="0.1 0 0" rpy="0 0.5 0"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.02"/>
    </inertial>
  </link>
  <link name="tool"><inertial><mass value="0.5"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <link name="hand"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="weld" type="fixed"><parent link="upper"/><child link="tool"/></joint>
  <joint name="wrist" type="continuous"><parent link="tool"/><child link="hand"/><axis xyz="1 0 0"/></joint>
</robot>
"#;

    #[test]
    fn a_repair_changes_the_numbers_of_its_body_alone() {
        let inertia = [0.03, 0.001, 0.0, 0.02, 0.0, 0.03];
        let turned = Pose { rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], position: [0.2, 0.0, 0.1] };
        let given = read_urdf(URDF, "arm.urdf").unwrap().links[0].parts[0].pose;
        let upper = RepairedBody { name: "upper".into(), mass: 2.5, pose: given, is_moved: false, inertia };
        let tool = RepairedBody { name: "tool".into(), mass: 0.5, pose: turned, is_moved: true, inertia };
        let written = into_urdf(URDF, "arm.urdf", &[&upper, &tool]).unwrap();
        let robot = read_urdf(&written, "arm.urdf").unwrap();
        let part = |name: &str| robot.links[0].parts.iter().find(|part| part.name == name).cloned().unwrap();
        assert_eq!((part("upper").mass, part("upper").inertia, part("upper").pose), (2.5, inertia, given));
        assert!(written.contains(r#"<origin xyz="0.2 0 0.1" rpy="0 0 1.5707963267948966"/>"#), "{written}");
        for kept in [
            "<!-- keep me -->",
            "<!-- from CAD -->",
            "<origin xyz=\"0.1 0 0\" rpy=\"0 0.5 0\"/>",
            "<mass value='2.5'/>",
        ] {
            assert!(written.contains(kept), "{written}");
        }
        let missing = RepairedBody { name: "hand".into(), mass: 1.0, pose: given, is_moved: false, inertia };
        let message = into_urdf(URDF, "arm.urdf", &[&missing]).unwrap_err().to_string();
        assert!(message.contains("link hand: it has no <inertial>"), "{message}");
    }

    #[test]
    fn an_mjcf_keeps_its_principal_axes_and_all_other_elements() {
        let text = r#"<mujoco><worldbody><body name="a"> <!-- keep --><joint name="j" axis="0 1 0"/>
  <inertial pos="0 0 0.1" quat="1 1 0 0" mass="3" diaginertia="1 2 2.5"/><geom size="0.1"/>
  <body name="b" pos="0.4 0 0"><joint name="k"/><geom size="0.1"/></body></body></worldbody></mujoco>"#;
        // The quaternion is a right angle about x.
        let pose = Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]], position: [0.0, 0.0, 0.1] };
        let body = |name: &str, inertia| RepairedBody { name: name.into(), mass: 0.3, pose, is_moved: false, inertia };
        let written = into_mjcf(text, "a.xml", &[&body("a", [0.1, 0.0, 0.0, 0.2, 0.0, 0.25])]).unwrap();
        assert_eq!(
            written,
            text.replace("mass=\"3\" diaginertia=\"1 2 2.5\"", "mass=\"0.3\" diaginertia=\"0.1 0.2 0.25\"")
        );
        let oblique = [&body("a", [0.1, 0.01, 0.02, 0.2, 0.03, 0.25]), &body("b", [0.1, 0.0, 0.0, 0.2, 0.0, 0.25])];
        let written = into_mjcf(text, "a.xml", &oblique).unwrap();
        for wanted in [
            "<inertial pos=\"0 0 0.1\" mass=\"0.3\" fullinertia=\"0.1 0.25 0.2 -0.02 0.01 -0.03\"/><geom size=\"0.1\"/>",
            "<body name=\"b\" pos=\"0.4 0 0\"><inertial pos=\"0 0 0.1\" mass=\"0.3\" fullinertia=\"0.1 0.25 0.2 0 0 0\"/>",
            "<!-- keep -->",
        ] {
            assert!(written.contains(wanted), "{wanted}: {written}");
        }
    }
}
