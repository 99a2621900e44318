//! Writes identified inertials back into the URDF of the robot; every other byte stays.
//!
//! The identified body is a moving link with everything fixed to it, ten parameters about the origin
//! of the link frame. The URDF link that the joint carries gets what remains without the lumped links.
//! Where the remainder is not a body, that link gets everything and the inertials of the lumped links
//! are emptied. A URDF inertial is about the centre of mass, here with axes along the link frame
//! (rpy 0): I_c = I - m (c'c 1 - c c').
//!
//! Only attributes are replaced, inside the text: comments, order and spacing survive.

use std::ops::Range;

use logs::Error;
use robot::{LinkId, Part, Robot};
use roxmltree::{Document, Node};

use crate::model::pseudo_inertia::{Centroidal, Ten, centroidal, smallest_eigenvalue};

/// A URDF with new inertials, and notes for the user on what was done.
#[derive(Clone, Debug)]
pub struct WrittenBack {
    /// The description with the identified parameters.
    pub text: String,
    /// Sentences on what the format has no place for.
    pub notes: Vec<String>,
}

/// Friction of a joint to be written as `<dynamics>`.
#[derive(Clone, Debug, PartialEq)]
pub struct JointDynamics {
    /// The joint's name in the file.
    pub joint: String,
    /// Viscous friction, N m s/rad.
    pub damping: f64,
    /// Coulomb friction, N m.
    pub friction: f64,
}

/// Puts `bodies` (ten parameters in and about the link frame of the robot) and `dynamics` into the
/// URDF `text` that `robot` was read from.
///
/// Fails when a body is not physically consistent (a simulator would refuse the file), when the text
/// is not the robot's, or when a link or joint is not in it.
pub fn write_back(
    text: &str,
    file: &str,
    robot: &Robot,
    bodies: &[(LinkId, Ten)],
    dynamics: &[JointDynamics],
) -> Result<WrittenBack, Error> {
    let document = Document::parse(text).map_err(|e| Error::at(file, e.pos().row as usize, e.to_string()))?;
    let root = document.root_element();
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    let mut notes = Vec::new();
    for (id, ten) in bodies {
        let link =
            robot.links.get(id.0).ok_or_else(|| Error::at(file, 0, format!("the robot has no link {}", id.0)))?;
        if smallest_eigenvalue(ten) <= 0.0 {
            let message = format!(
                "link {}: the identified parameters are no body (pseudo-inertia not positive definite); estimate with consistency first",
                link.name
            );
            return Err(Error::at(file, 0, message));
        }
        let lumped: Vec<&Part> = link.parts.iter().filter(|p| p.name != link.name).collect();
        let mut rest = *ten;
        for part in &lumped {
            let theirs = part.parameters();
            rest.iter_mut().zip(theirs).for_each(|(r, t)| *r -= t);
        }
        let own = if lumped.is_empty() || smallest_eigenvalue(&rest) > 0.0 {
            rest
        } else {
            for part in &lumped {
                empty(&element(root, "link", &part.name, file)?, &mut edits);
            }
            let names: Vec<&str> = lumped.iter().map(|p| p.name.as_str()).collect();
            notes.push(format!("{} carries the inertia of the links fixed to it: {}", link.name, names.join(", ")));
            *ten
        };
        let in_file = robot::transform_inertial(&own, &link.file_frame.inverse());
        let body = centroidal(&in_file).ok_or_else(|| Error::at(file, 0, format!("link {}: no mass", link.name)))?;
        set_inertial(text, &element(root, "link", &link.name, file)?, &body, &mut edits);
    }
    for joint in dynamics {
        set_dynamics(text, &element(root, "joint", &joint.joint, file)?, joint, &mut edits);
    }
    edits.sort_by_key(|e| std::cmp::Reverse((e.0.start, e.0.end)));
    let mut text = text.to_string();
    for (range, new) in edits {
        text.replace_range(range, &new);
    }
    Ok(WrittenBack { text, notes })
}

/// The element of this tag and name among the robot's own (not in a transmission).
fn element<'a, 'd>(root: Node<'a, 'd>, tag: &str, name: &str, file: &str) -> Result<Node<'a, 'd>, Error> {
    let found = root.children().find(|n| n.has_tag_name(tag) && n.attribute("name") == Some(name));
    found.ok_or_else(|| Error::at(file, 0, format!("there is no <{tag} name=\"{name}\"> in the file")))
}

fn set_inertial(text: &str, link: &Node, body: &Centroidal, edits: &mut Vec<(Range<usize>, String)>) {
    let [x, y, z] = body.centre;
    let [xx, xy, xz, yy, yz, zz] = body.inertia;
    let origin = [("xyz", format!("{x} {y} {z}")), ("rpy", "0 0 0".into())];
    let mass = [("value", body.mass.to_string())];
    let inertia = [("ixx", xx), ("ixy", xy), ("ixz", xz), ("iyy", yy), ("iyz", yz), ("izz", zz)];
    let inertia = inertia.map(|(k, v)| (k, v.to_string()));
    let children: [(&str, &[(&str, String)]); 3] = [("origin", &origin), ("mass", &mass), ("inertia", &inertia)];
    match link.children().find(|n| n.has_tag_name("inertial")) {
        Some(inertial) => {
            for (tag, attributes) in children {
                set_child(text, &inertial, tag, attributes, edits);
            }
        }
        None => {
            let all: String = children.iter().map(|(tag, attributes)| tagged(tag, attributes)).collect();
            insert(text, link, &format!("<inertial>{all}</inertial>"), edits);
        }
    }
}

fn set_dynamics(text: &str, joint: &Node, dynamics: &JointDynamics, edits: &mut Vec<(Range<usize>, String)>) {
    let attributes = [("damping", dynamics.damping.to_string()), ("friction", dynamics.friction.to_string())];
    set_child(text, joint, "dynamics", &attributes, edits);
}

/// Sets attributes of a child element; makes the element where there is none.
fn set_child(
    text: &str,
    parent: &Node,
    tag: &str,
    attributes: &[(&str, String)],
    edits: &mut Vec<(Range<usize>, String)>,
) {
    let Some(child) = parent.children().find(|n| n.has_tag_name(tag)) else {
        insert(text, parent, &tagged(tag, attributes), edits);
        return;
    };
    let mut missing = String::new();
    for (name, value) in attributes {
        match child.attribute_node(*name) {
            Some(attribute) => edits.push((attribute.range_value(), value.clone())),
            None => missing.push_str(&format!(" {name}=\"{value}\"")),
        }
    }
    if !missing.is_empty() {
        let at = child.range().start + 1 + tag.len();
        edits.push((at..at, missing));
    }
}

fn tagged(tag: &str, attributes: &[(&str, String)]) -> String {
    let attributes: String = attributes.iter().map(|(k, v)| format!(" {k}=\"{v}\"")).collect();
    format!("<{tag}{attributes}/>")
}

/// Puts text right after the opening tag of an element, opening it where it is empty.
fn insert(text: &str, node: &Node, content: &str, edits: &mut Vec<(Range<usize>, String)>) {
    let range = node.range();
    let tag = node.tag_name().name();
    // The end of the opening tag: the first `>` outside of quotes.
    let mut quote = None;
    let opening = text[range.clone()].char_indices().find(|&(_, c)| {
        match (quote, c) {
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if q == c => quote = None,
            (None, '>') => return true,
            _ => {}
        }
        false
    });
    let Some((end, _)) = opening else { return };
    let end = range.start + end;
    if text[..end].ends_with('/') {
        edits.push((end - 1..end + 1, format!(">{content}</{tag}>")));
    } else {
        edits.push((end + 1..end + 1, content.into()));
    }
}

/// Removes the inertial of a link: a fixed link without one has no inertia.
fn empty(link: &Node, edits: &mut Vec<(Range<usize>, String)>) {
    if let Some(inertial) = link.children().find(|n| n.has_tag_name("inertial")) {
        edits.push((inertial.range(), String::new()));
    }
}

/// Friction and rotor inertia in the formats that hold them.
///
/// One line a joint: MuJoCo's `damping`, `frictionloss`, `armature` (URDF and Gazebo's SDF have no
/// armature). Negative friction is written as zero: simulators refuse it.
pub fn mjcf_joints(joints: &[JointDynamics], armature: &[f64]) -> String {
    let line = |(joint, armature): (&JointDynamics, &f64)| {
        let (damping, friction) = (joint.damping.max(0.0), joint.friction.max(0.0));
        let armature = armature.max(0.0);
        format!(
            "<joint name=\"{}\" damping=\"{damping}\" frictionloss=\"{friction}\" armature=\"{armature}\"/>\n",
            joint.joint
        )
    };
    joints.iter().zip(armature).map(line).collect()
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
        let friction = JointDynamics { joint: "turn".into(), damping: 0.3, friction: 1.25 };
        let bodies = [(upper, heavier), (hand, small)];
        let written = write_back(URDF, "arm.urdf", &robot, &bodies, &[friction]).unwrap();
        assert!(written.notes.is_empty());
        let again = read_urdf(&written.text, "arm.urdf").unwrap();
        for (id, expected) in [(upper.0, heavier), (hand.0, small)] {
            for (a, b) in total(&again, id).into_iter().zip(expected) {
                assert!((a - b).abs() < 1e-14, "{a} {b}");
            }
        }
        for kept in ["<!-- keep me -->", "<!-- from CAD -->", "<link   name=\"upper\">   ", "<!-- an arm -->"] {
            assert!(written.text.contains(kept), "{}", written.text);
        }
        assert!(written.text.contains("<dynamics damping=\"0.3\" friction=\"1.25\"/>"), "{}", written.text);
        assert!(written.text.contains("rpy=\"0 0 0\""));
    }

    /// The bytes outside of the edited elements are those of the original.
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
        for (a, b) in total(&again, upper.0).into_iter().zip(light) {
            assert!((a - b).abs() < 1e-14, "{a} {b}");
        }
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

    #[test]
    fn a_line_for_mujoco() {
        let joint = JointDynamics { joint: "turn".into(), damping: 0.3, friction: -1.0 };
        let line = "<joint name=\"turn\" damping=\"0.3\" frictionloss=\"0\" armature=\"0.05\"/>\n";
        assert_eq!(mjcf_joints(&[joint], &[0.05]), line);
    }
}
