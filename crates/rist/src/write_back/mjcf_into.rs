//! Puts identified inertials, friction and rotor inertia into an existing MuJoCo model; every other byte stays.
//!
//! A body has the name of its link and a joint that of its coordinate, or what follows the first `_` of it (`link1` for
//! `panda_link1`). The frames of both files must be the same. Where a body hangs directly on the body of the link
//! before, its place is compared with that of the description at q = 0.

use linear_model::pseudo_inertia::Ten;
use logs::Error;
use robot::{Link, LinkId, Pose, Robot};
use roxmltree::{Document, Node};

use crate::write_back::body::{self, JointDynamics};
use crate::write_back::mjcf::{attributes, file_poses, inertial, quaternion};
use crate::write_back::text_edit::Edits;
use crate::write_back::urdf::WrittenBack;

/// Tolerance of positions, m, and of the components of quaternions. Models round to four digits.
const POSE_TOLERANCE: f64 = 1e-3;

/// The MJCF `text` with these bodies (ten parameters about the origin of the link frame) and joints.
///
/// Fails where the text is no XML, lacks a body or a joint, or places a body elsewhere than the description does.
pub fn mjcf_into(
    text: &str,
    file: &str,
    robot: &Robot,
    bodies: &[(LinkId, Ten)],
    joints: &[JointDynamics],
) -> Result<WrittenBack, Error> {
    let document = Document::parse(text).map_err(|e| Error::at(file, e.pos().row as usize, e.to_string()))?;
    let mut edits = Edits::of(text);
    let mut notes = Vec::new();
    let poses = file_poses(robot);
    // Each body gets its ten parameters; a body fixed to it keeps its inertial or loses it.
    for (id, ten) in bodies {
        let link = robot.link(*id);
        let node = element(&document, "body", &link.name, file)?;
        check_place(robot, link, *id, &poses, &node, file)?;
        let is_held = |name: &str| found(&document, "body", name).is_some();
        let (own, lumped) = body::own(link, ten, is_held);
        for name in &lumped {
            if let Some(inertial) = found(&document, "body", name).and_then(|body| child(&body, "inertial")) {
                edits.replace(inertial.range(), "");
            }
        }
        notes.extend(body::carries(link, &lumped));
        let written = inertial(link, &own)?;
        match child(&node, "inertial") {
            Some(old) => edits.replace(old.range(), &written),
            None => edits.insert(&node, &written),
        }
    }
    for joint in joints {
        edits.set_attributes(&element(&document, "joint", &joint.joint, file)?, &attributes(joint));
    }
    // An option of the model by which MuJoCo would not read what is written.
    let by_shapes = |n: &Node| n.has_tag_name("compiler") && n.attribute("inertiafromgeom") == Some("true");
    if document.descendants().any(|n| by_shapes(&n)) {
        notes.push("<compiler inertiafromgeom=\"true\"> makes MuJoCo ignore inertials: say \"auto\"".into());
    }
    Ok(WrittenBack { text: edits.apply(), notes })
}

fn child<'a, 'd>(node: &Node<'a, 'd>, tag: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|n| n.has_tag_name(tag))
}

/// The element of the world with this tag and name, or with what stands behind the name's first `_`.
fn found<'a, 'd>(document: &'a Document<'d>, tag: &str, name: &str) -> Option<Node<'a, 'd>> {
    let world = document.descendants().find(|n| n.has_tag_name("worldbody"))?;
    let of = |name: &str| world.descendants().find(|n| n.has_tag_name(tag) && n.attribute("name") == Some(name));
    of(name).or_else(|| of(name.split_once('_')?.1))
}

fn element<'a, 'd>(document: &'a Document<'d>, tag: &str, name: &str, file: &str) -> Result<Node<'a, 'd>, Error> {
    found(document, tag, name).ok_or_else(|| {
        let named = document.descendants().filter(|n| n.has_tag_name(tag)).filter_map(|n| n.attribute("name"));
        let names = named.collect::<Vec<_>>().join(", ");
        Error::at(file, 0, format!("there is no <{tag} name=\"{name}\">; there are {names}"))
    })
}

/// Refuses a body that stands elsewhere in its parent than the link does in its antecedent.
fn check_place(robot: &Robot, link: &Link, id: LinkId, poses: &[Pose], node: &Node, file: &str) -> Result<(), Error> {
    // Only a body that hangs on that of the link before has a place to compare.
    let Some(before) = link.antecedent else { return Ok(()) };
    let parent = node.parent().and_then(|parent| parent.attribute("name").map(str::to_string));
    let name = &robot.link(before).name;
    let is_before = |parent: &str| parent == name || name.split_once('_').is_some_and(|(_, tail)| tail == parent);
    if !parent.as_deref().is_some_and(is_before) {
        return Ok(());
    }
    // The place of the link in the link before at q = 0, against pos and quat; q and -q are one turn.
    let expected = poses[before.0].inverse().compose(&poses[id.0]);
    let numbers =
        |key: &str| -> Option<Vec<f64>> { node.attribute(key)?.split_whitespace().map(|x| x.parse().ok()).collect() };
    let near = |found: &[f64], expected: &[f64]| {
        found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < POSE_TOLERANCE)
    };
    let position = numbers("pos").unwrap_or_else(|| vec![0.0; 3]);
    let is_turned = numbers("quat").is_some_and(|found| {
        let size = found.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (found, expected): (Vec<f64>, _) = (found.iter().map(|x| x / size).collect(), quaternion(&expected));
        !near(&found, &expected) && !near(&found, &expected.map(|x| -x))
    });
    if near(&position, &expected.position) && !is_turned {
        return Ok(());
    }
    let message = format!(
        "the body of {} stands at {position:?} of {name}, in the description at {:?}, or is turned: the frames of the two \
         files are not the same, and inertials of one are wrong in the other",
        link.name, expected.position
    );
    Err(Error::at(file, 0, message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot::format::read_urdf;

    const URDF: &str = r#"<robot name="r"><link name="base"/>
  <link name="r_one"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="r_two"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="r_a" type="continuous"><parent link="base"/><child link="r_one"/><axis xyz="0 0 1"/></joint>
  <joint name="r_b" type="continuous"><parent link="r_one"/><child link="r_two"/><origin xyz="0.4 0 0.1"/><axis xyz="0 1 0"/></joint>
</robot>"#;

    const MJCF: &str = r#"<mujoco><default><joint damping="9"/></default><worldbody>
  <body name="one"> <!-- keep -->
    <inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/><joint name="a" armature="1"/>
    <body name="two" pos="0.4 0 0.1"><joint name="b" axis="0 1 0"/><geom size="0.1"/></body>
  </body></worldbody></mujoco>"#;

    fn written(mjcf: &str) -> Result<WrittenBack, Error> {
        let robot = read_urdf(URDF, "r.urdf").unwrap();
        let bodies: Vec<(LinkId, Ten)> = robot.link_ids().map(|id| (id, robot.link(id).inertial.unwrap())).collect();
        let joint = JointDynamics { joint: "r_a".into(), damping: 0.5, friction: 0.2, armature: 0.01 };
        mjcf_into(mjcf, "r.xml", &robot, &bodies, &[joint])
    }

    #[test]
    fn only_figures_change() {
        let text = written(MJCF).unwrap().text;
        for kept in ["<!-- keep -->", "<default><joint damping=\"9\"/></default>", "<geom size=\"0.1\"/>"] {
            assert!(text.contains(kept), "{text}");
        }
        assert!(text.contains("<joint damping=\"0.5\" frictionloss=\"0.2\" name=\"a\" armature=\"0.01\"/>"), "{text}");
        assert!(!text.contains("diaginertia"));
        let document = Document::parse(&text).unwrap();
        let inertials: Vec<Node> = document.descendants().filter(|n| n.has_tag_name("inertial")).collect();
        assert!(inertials.len() == 2 && inertials.iter().all(|n| n.attribute("mass") == Some("1")), "{text}");
    }

    #[test]
    fn other_frames_are_refused() {
        for moved in ["0.4 0 0.2", "0.4 0 0.1\" quat=\"0.7071 0 0 0.7071"] {
            let refused = written(&MJCF.replace("0.4 0 0.1", moved)).unwrap_err().to_string();
            assert!(refused.contains("the frames of the two files are not the same"), "{refused}");
        }
        assert!(written(&MJCF.replace("0.4 0 0.1", "0.4 0 0.1\" quat=\"-1 0 0 0")).is_ok());
        let refused = written(&MJCF.replace("\"two\"", "\"tow\"")).unwrap_err().to_string();
        assert!(refused.contains("there is no <body name=\"r_two\">; there are one, tow"), "{refused}");
        assert!(written("<mujoco").unwrap_err().to_string().starts_with("r.xml:1:"));
    }
}
