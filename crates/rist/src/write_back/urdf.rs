//! Writes identified inertials into the URDF of a robot; all other bytes (comments, order, spacing) stay as they are.
//!
//! The identified parameters of a moving link include all links fixed to it (ten parameters about the origin of the link
//! frame). In the URDF, the moving link gets this sum minus the inertials of the fixed links. If the difference is physically
//! impossible, the moving link gets the whole sum, and the inertials of the fixed links are removed. A URDF inertial is about
//! the centre of mass, here with axes along the link frame (rpy 0): I_c = I - m (c'c 1 - c c'). c: centre of mass; m: mass; 1:
//! identity matrix.

use gate::shown;
use linear_model::pseudo_inertia::{Centroidal, Ten, centroidal};
use logs::Error;
use nalgebra::Rotation3;
use robot::format::roll_pitch_yaw;
use robot::{LinkId, Pose, Robot};
use roxmltree::{Document, Node};

use crate::write_back::body::{self, JointDynamics};
use crate::write_back::text_edit::{Edits, tagged};

/// A URDF or an MJCF with identified inertials, and notes for the user.
#[derive(Clone, Debug)]
pub struct WrittenBack {
    /// The text of the description with the identified parameters.
    pub text: String,
    /// Sentences for the user, for example which link got the inertia of others, or which options of a MuJoCo file override the
    /// new inertials.
    pub notes: Vec<String>,
}

/// Writes `bodies` and `dynamics` into the URDF `text`, from which `robot` was read. `bodies`: ten parameters per link, in its
/// frame and about its origin; `dynamics`: one entry per joint.
///
/// Fails if a body is not physically consistent (a simulator would refuse the file), if the text does not describe this robot,
/// or if a link or joint is missing in it.
pub fn write_back(
    text: &str,
    file: &str,
    robot: &Robot,
    bodies: &[(LinkId, Ten)],
    dynamics: &[JointDynamics],
) -> Result<WrittenBack, Error> {
    let document = Document::parse(text).map_err(|e| Error::at(file, e.pos().row as usize, e.to_string()))?;
    let root = document.root_element();
    let mut edits = Edits::of(text);
    let mut notes = Vec::new();
    for (id, ten) in bodies {
        let link =
            robot.links.get(id.0).ok_or_else(|| Error::at(file, 0, format!("the robot has no link {}", id.0)))?;
        body::check(link, ten).map_err(|message| Error::at(file, 0, message))?;
        // The inertial parameters of the link without the links fixed to it, in the frame that the URDF gives this link.
        let (own, lumped) = body::own(link, ten);
        for name in &lumped {
            empty(&element(root, "link", name, file)?, &mut edits);
        }
        notes.extend(body::carries(link, &lumped));
        let in_file = robot::transform_inertial(&own, &link.file_frame.inverse());
        let body = centroidal(&in_file).ok_or_else(|| Error::at(file, 0, format!("link {}: no mass", link.name)))?;
        set_inertial(&element(root, "link", &link.name, file)?, &body, &mut edits);
    }
    for joint in dynamics {
        let attributes = [("damping", joint.damping.to_string()), ("friction", joint.friction.to_string())];
        edits.set_child(&element(root, "joint", &joint.joint, file)?, "dynamics", &attributes);
    }
    Ok(WrittenBack { text: edits.apply(), notes })
}

/// Writes moved joint frames into the URDF `text`: each `<origin>` is followed by the pose `changes` of its joint. All other bytes
/// stay.
///
/// Fails if the text is no URDF, if a joint is missing in it, or if an origin is not made of numbers.
pub fn write_origins(text: &str, file: &str, changes: &[(String, Pose)]) -> Result<String, Error> {
    let document = Document::parse(text).map_err(|e| Error::at(file, e.pos().row as usize, e.to_string()))?;
    let root = document.root_element();
    if !root.has_tag_name("robot") {
        let found = root.tag_name().name();
        let message =
            format!("origins are written into a URDF, whose root is <robot>, found <{found}>: convert it first");
        return Err(Error::at(file, 0, message));
    }
    let mut edits = Edits::of(text);
    for (name, change) in changes.iter().filter(|(_, change)| *change != Pose::IDENTITY) {
        let joint = element(root, "joint", name, file)?;
        let [x, y, z, roll, pitch, yaw] = origin(&joint, name, file)?;
        let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
        let rotation = std::array::from_fn(|i| std::array::from_fn(|k| rotation[(i, k)]));
        let moved = Pose { rotation, position: [x, y, z] }.compose(change);
        let numbers = |x: [f64; 3]| x.map(|x| (x + 0.0).to_string()).join(" ");
        let attributes = [("xyz", numbers(moved.position)), ("rpy", numbers(roll_pitch_yaw(&moved.rotation)))];
        edits.set_child(&joint, "origin", &attributes);
    }
    Ok(edits.apply())
}

/// The origins of these joints of the URDF `text`: x, y, z, m, and roll, pitch, yaw, rad.
///
/// Fails like [`write_origins`].
pub fn origins(text: &str, file: &str, joints: &[String]) -> Result<Vec<[f64; 6]>, Error> {
    let document = Document::parse(text).map_err(|e| Error::at(file, e.pos().row as usize, e.to_string()))?;
    let of = |name: &String| origin(&element(document.root_element(), "joint", name, file)?, name, file);
    joints.iter().map(of).collect()
}

/// The origin of a joint: x, y, z, roll, pitch, yaw.
fn origin(joint: &Node, name: &str, file: &str) -> Result<[f64; 6], Error> {
    let origin = joint.children().find(|n| n.has_tag_name("origin"));
    let three = |attribute: &str| -> Result<[f64; 3], Error> {
        let Some(text) = origin.and_then(|origin| origin.attribute(attribute)) else { return Ok([0.0; 3]) };
        let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        let numbers = numbers.ok().and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
        let message =
            || format!("joint {name}: the {attribute} of its origin is no three numbers: expand the xacro first");
        numbers.ok_or_else(|| Error::at(file, 0, message()))
    };
    let ([x, y, z], [roll, pitch, yaw]) = (three("xyz")?, three("rpy")?);
    Ok([x, y, z, roll, pitch, yaw])
}

/// The attributes of `<inertia>`.
pub(super) fn six(&[xx, xy, xz, yy, yz, zz]: &[f64; 6]) -> [(&'static str, String); 6] {
    let inertia = [("ixx", xx), ("ixy", xy), ("ixz", xz), ("iyy", yy), ("iyz", yz), ("izz", zz)];
    inertia.map(|(k, v)| (k, v.to_string()))
}

/// The child element of `<robot>` with this tag and name; elements in a transmission are not searched.
pub(super) fn element<'a, 'd>(root: Node<'a, 'd>, tag: &str, name: &str, file: &str) -> Result<Node<'a, 'd>, Error> {
    // The robot's names are stored in printable form, so names of the file are converted before they are compared.
    let is_it = |n: &Node| n.attribute("name").is_some_and(|found| shown::line(found) == name);
    let found = root.children().find(|n| n.has_tag_name(tag) && is_it(n));
    found.ok_or_else(|| Error::at(file, 0, format!("there is no <{tag} name=\"{name}\"> in the file")))
}

fn set_inertial(link: &Node, body: &Centroidal, edits: &mut Edits) {
    let [x, y, z] = body.centre;
    let origin = [("xyz", format!("{x} {y} {z}")), ("rpy", "0 0 0".into())];
    let mass = [("value", body.mass.to_string())];
    let inertia = six(&body.inertia);
    let children: [(&str, &[(&str, String)]); 3] = [("origin", &origin), ("mass", &mass), ("inertia", &inertia)];
    match link.children().find(|n| n.has_tag_name("inertial")) {
        Some(inertial) => children.iter().for_each(|(tag, attributes)| edits.set_child(&inertial, tag, attributes)),
        None => {
            let all: String = children.iter().map(|(tag, attributes)| tagged(tag, attributes)).collect();
            edits.insert(link, &format!("<inertial>{all}</inertial>"));
        }
    }
}

/// Removes the inertial of a fixed link. Without an inertial, the link has no mass.
fn empty(link: &Node, edits: &mut Edits) {
    if let Some(inertial) = link.children().find(|n| n.has_tag_name("inertial")) {
        edits.replace(inertial.range(), "");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot::format::read_urdf;

    const URDF: &str = r#"<?xml version="1.0"?>
<!-- an arm -->
<robot name="arm">
  <link name="base"/>
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
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.3" rpy="0.2 0.1 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
  </joint>
  <joint name="weld" type="fixed"><parent link="upper"/><child link="tool"/><origin xyz="0.4 0 0"/></joint>
  <joint name="wrist" type="continuous"><parent link="tool"/><child link="hand"/><axis xyz="1 0 0"/>
    <limit effort="10" velocity="2"/></joint>
</robot>
"#;

    fn total(robot: &Robot, id: usize) -> Ten {
        let mut sum = [0.0; 10];
        for part in &robot.links[id].parts {
            sum.iter_mut().zip(part.parameters()).for_each(|(s, p)| *s += p);
        }
        sum
    }

    fn near(found: Ten, expected: Ten) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?} {expected:?}");
    }

    fn link(robot: &Robot, name: &str) -> LinkId {
        robot.link_ids().find(|&id| robot.link(id).name == name).unwrap()
    }

    #[test]
    fn what_is_written_is_read_back() {
        let robot = read_urdf(URDF, "arm.urdf").unwrap();
        let (upper, hand) = (link(&robot, "upper"), link(&robot, "hand"));
        let mut heavier = total(&robot, upper.0);
        heavier.iter_mut().for_each(|x| *x *= 1.5);
        let small = [0.002, 0.0001, 0.0, 0.002, 0.0, 0.002, 0.01, 0.005, -0.01, 0.7];
        let friction = JointDynamics { joint: "turn".into(), damping: 0.3, friction: 1.25, armature: 0.0 };
        let bodies = [(upper, heavier), (hand, small)];
        let written = write_back(URDF, "arm.urdf", &robot, &bodies, &[friction]).unwrap();
        assert!(written.notes.is_empty());
        let again = read_urdf(&written.text, "arm.urdf").unwrap();
        near(total(&again, upper.0), heavier);
        near(total(&again, hand.0), small);
        for kept in ["<!-- keep me -->", "<!-- from CAD -->", "<link   name=\"upper\">   ", "<!-- an arm -->"] {
            assert!(written.text.contains(kept), "{}", written.text);
        }
        assert!(written.text.contains("<dynamics damping=\"0.3\" friction=\"1.25\"/>"), "{}", written.text);
        assert!(written.text.contains("rpy=\"0 0 0\""));
    }

    #[test]
    fn nothing_to_write_changes_no_byte() {
        let robot = read_urdf(URDF, "arm.urdf").unwrap();
        assert_eq!(write_back(URDF, "arm.urdf", &robot, &[], &[]).unwrap().text, URDF);
    }

    #[test]
    fn a_light_body_takes_its_lumped_links_over() {
        let robot = read_urdf(URDF, "arm.urdf").unwrap();
        let upper = link(&robot, "upper");
        let light = [0.002, 0.0, 0.0, 0.002, 0.0, 0.002, 0.01, 0.0, 0.0, 0.3];
        let written = write_back(URDF, "arm.urdf", &robot, &[(upper, light)], &[]).unwrap();
        assert!(written.notes[0].contains("tool"), "{:?}", written.notes);
        let again = read_urdf(&written.text, "arm.urdf").unwrap();
        near(total(&again, upper.0), light);
    }

    #[test]
    fn names_with_hidden_characters_are_found() {
        let text = URDF.replace("\"upper\"", "\"up&#x202e;per&#10;\"").replace("\"turn\"", "\"tu\u{9b}rn\"");
        let options = robot::format::ReadOptions::default();
        let robot = robot::format::parse_with(&text, std::path::Path::new("arm.urdf"), options).unwrap();
        let upper = link(&robot, "up\\u{202e}per\\n");
        let mut heavier = total(&robot, upper.0);
        heavier.iter_mut().for_each(|x| *x *= 1.5);
        let friction = JointDynamics { joint: "tu\\u{9b}rn".into(), damping: 0.3, friction: 1.25, armature: 0.0 };
        let written = write_back(&text, "arm.urdf", &robot, &[(upper, heavier)], &[friction]).unwrap().text;
        for kept in ["<link   name=\"up&#x202e;per&#10;\">", "damping=\"0.3\""] {
            assert!(written.contains(kept), "{written}");
        }
        let again = robot::format::parse_with(&written, std::path::Path::new("arm.urdf"), options).unwrap();
        near(total(&again, upper.0), heavier);
    }

    #[test]
    fn refusals() {
        let robot = read_urdf(URDF, "arm.urdf").unwrap();
        let upper = link(&robot, "upper");
        let message = write_back(URDF, "arm.urdf", &robot, &[(upper, [0.0; 10])], &[]).unwrap_err().to_string();
        assert!(message.contains("link upper: the identified parameters are no body"), "{message}");
        let other = "<robot name=\"other\"/>";
        let body = [0.1, 0.0, 0.0, 0.1, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0];
        let message = write_back(other, "arm.urdf", &robot, &[(upper, body)], &[]).unwrap_err().to_string();
        assert!(message.contains("there is no <link name="), "{message}");
        let message = write_back("<robot", "arm.urdf", &robot, &[], &[]).unwrap_err().to_string();
        assert!(message.starts_with("arm.urdf:1:"), "{message}");
    }
}
