//! Writes identified inertials, friction and rotor inertia into an existing MuJoCo model; all other bytes stay as they are.
//!
//! A body has the name of its link and a joint the name of its coordinate, or the part of this name after the first `_`
//! (`link1` for `panda_link1`). The frames of both files must be the same. If a body is a child of the body of the antecedent
//! link, its pose is compared with the pose in the description at q = 0, unless the description is this model itself.
//!
//! The ten parameters of a link include the links fixed to it. So the link's body gets the sum, and the bodies of the fixed
//! links get zero mass (MuJoCo allows this for a body without a joint). Otherwise MuJoCo would compute the mass of these bodies
//! from their shapes. Inertials that the model already has are not read, because they may differ from the description.

use gate::shown;
use linear_model::pseudo_inertia::Ten;
use logs::Error;
use robot::{Link, LinkId, Part, Pose, Robot};
use roxmltree::{Document, Node};

use crate::write_back::body::{self, JointDynamics};
use crate::write_back::mjcf::{attributes, file_poses, inertial, quaternion};
use crate::write_back::mjcf_actuators::empty_actuators;
use crate::write_back::mjcf_names::{element, found};
use crate::write_back::mjcf_pose::AngleConvention;
use crate::write_back::text_edit::Edits;
use crate::write_back::urdf::WrittenBack;

/// Tolerance of positions, m, and of quaternion components: numbers in MuJoCo models are often rounded to four digits.
const POSE_TOLERANCE: f64 = 1e-3;

/// Zero inertial, for a body whose mass is included in another body.
const NO_INERTIA: &str = "<inertial pos=\"0 0 0\" mass=\"0\" diaginertia=\"0 0 0\"/>";

/// The MJCF `text` with identified values. `bodies`: ten parameters of each link about the origin of its frame; `joints`: one
/// per coordinate. `is_own`: whether the robot was read from this text.
///
/// Fails if the text is no XML, if a body or a joint is missing, if a body has another pose than in the description, or if a link
/// that is fixed in the description can move in the model.
pub fn mjcf_into(
    text: &str,
    file: &str,
    robot: &Robot,
    bodies: &[(LinkId, Ten)],
    joints: &[JointDynamics],
    is_own: bool,
) -> Result<WrittenBack, Error> {
    let document = Document::parse(text).map_err(|e| Error::at(file, e.pos().row as usize, e.to_string()))?;
    let mut edits = Edits::of(text);
    let mut notes = Vec::new();
    let poses = file_poses(robot);
    // The body of each link gets its ten inertial parameters. The bodies of the links fixed to it get zero mass.
    for (id, ten) in bodies {
        let link = robot.link(*id);
        let node = element(&document, "body", &link.name, file)?;
        if !is_own {
            check_place(robot, link, *id, &poses, &node, file)?;
        }
        let mut emptied = Vec::new();
        for Part { name, .. } in link.parts.iter().filter(|part| part.name != link.name) {
            let Some(part) = found(&document, "body", name).filter(|part| *part != node) else { continue };
            check_fixed(link, &node, &part, file)?;
            set_inertial(&mut edits, &part, NO_INERTIA);
            emptied.push((name.as_str(), part));
        }
        let names: Vec<&str> = emptied.iter().map(|(name, _)| *name).collect();
        notes.extend(body::carries(link, &names));
        notes.extend(other_bodies_sentence(link, &node, &emptied.iter().map(|(_, part)| *part).collect::<Vec<_>>()));
        set_inertial(&mut edits, &node, &inertial(link, ten)?);
    }
    for joint in joints {
        edits.set_attributes(&element(&document, "joint", &joint.joint, file)?, &attributes(joint));
    }
    notes.extend(empty_actuators(&document, joints, &mut edits));
    notes.extend(document.descendants().filter(|n| n.has_tag_name("compiler")).flat_map(|n| changes(&n)));
    Ok(WrittenBack { text: edits.apply(), notes })
}

pub(super) fn set_inertial(edits: &mut Edits, body: &Node, inertial: &str) {
    match child(body, "inertial") {
        Some(old) => edits.replace(old.range(), inertial),
        None => edits.insert(body, inertial),
    }
}

/// Sentences on compiler options of the model that make MuJoCo ignore or change the written inertials.
fn changes(compiler: &Node) -> Vec<String> {
    let of = |key: &str| {
        let value = compiler.attribute(key)?;
        let does = match (key, value) {
            ("inertiafromgeom", "true") => "ignore inertials: say \"auto\"",
            ("inertiafromgeom", _) | ("balanceinertia", "false") => return None,
            ("balanceinertia", _) => "change the inertia of some bodies: take it out",
            _ if value.trim().parse().is_ok_and(|x: f64| x <= 0.0) => return None,
            ("settotalmass", _) => "scale all inertials: take it out",
            _ => "raise small inertials, and those of bodies whose mass another body carries: take it out",
        };
        Some(format!("<compiler {key}=\"{value}\"> makes MuJoCo {does}"))
    };
    ["inertiafromgeom", "balanceinertia", "settotalmass", "boundmass", "boundinertia"]
        .into_iter()
        .filter_map(of)
        .collect()
}

fn child<'a, 'd>(node: &Node<'a, 'd>, tag: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|n| n.has_tag_name(tag))
}

/// Whether an element is a body without a joint. Such a body is fixed to its parent.
fn is_fixed_body(node: &Node) -> bool {
    node.has_tag_name("body") && !["joint", "freejoint"].into_iter().any(|tag| child(node, tag).is_some())
}

/// Fails if the body `part` can move relative to the link's body. The mass of `part` is set to zero, and MuJoCo needs a mass for
/// a body that moves.
fn check_fixed(link: &Link, body: &Node, part: &Node, file: &str) -> Result<(), Error> {
    let mut node = *part;
    while node != *body {
        let is_between = node.has_tag_name("frame") || is_fixed_body(&node);
        let (true, Some(parent)) = (is_between, node.parent()) else {
            let name = part.attribute("name").unwrap_or_default();
            return Err(Error::at(
                file,
                part.document().text_pos_at(part.range().start).row as usize,
                format!(
                    "the body {name} is not fixed to the body of {} as in the description: fix it there in one of the two \
                     files, or give it a joint in both",
                    link.name
                ),
            ));
        };
        node = parent;
    }
    Ok(())
}

/// A sentence on bodies with mass or shapes that are fixed to a link's body in the model, but not in the description.
fn other_bodies_sentence(link: &Link, body: &Node, emptied: &[Node]) -> Option<String> {
    let mut names = Vec::new();
    let mut next: Vec<Node> = body.children().collect();
    while let Some(node) = next.pop() {
        let is_body = is_fixed_body(&node);
        if is_body && !emptied.contains(&node) && ["inertial", "geom"].iter().any(|tag| child(&node, tag).is_some()) {
            names.push(node.attribute("name").unwrap_or("a body without a name"));
        }
        if is_body || node.has_tag_name("frame") {
            next.extend(node.children());
        }
    }
    names.sort_unstable();
    (!names.is_empty()).then(|| {
        format!(
            "{} also carries what the model alone fixes to it, whose inertia is not in the estimate unless it was there in \
             the logs: {}",
            link.name,
            names.join(", ")
        )
    })
}

/// Fails if the pose of a link's body relative to the body of the antecedent (the parent link) differs from the description.
fn check_place(robot: &Robot, link: &Link, id: LinkId, poses: &[Pose], node: &Node, file: &str) -> Result<(), Error> {
    let Some(before) = link.antecedent else { return Ok(()) };
    let name = &robot.link(before).name;
    let is_before = |node: &Node| {
        let found = node.attribute("name").filter(|_| node.has_tag_name("body")).map(shown::line);
        found.is_some_and(|found| found == *name || name.split_once('_').is_some_and(|(_, tail)| tail == found))
    };
    // The pose relative to the antecedent's body is the product of all poses in between: frames and fixed bodies.
    let (angles, mut place, mut above) = (AngleConvention::of(node.document()), Pose::IDENTITY, *node);
    loop {
        let Some(pose) = angles.pose(&above) else {
            let what = "its position or orientation cannot be read; say it as pos=\"X Y Z\" and quat=\"W X Y Z\"";
            let row = node.document().text_pos_at(above.range().start).row as usize;
            return Err(Error::at(
                file,
                row,
                format!("<{}> on the way to {}: {what}", above.tag_name().name(), link.name),
            ));
        };
        place = pose.compose(&place);
        match above.parent() {
            Some(parent) if is_before(&parent) => break,
            Some(parent) if parent.has_tag_name("frame") || is_fixed_body(&parent) => above = parent,
            // If a body is not inside the antecedent's body, there is no pose to compare.
            _ => return Ok(()),
        }
    }
    // The quaternions q and -q describe the same rotation.
    let expected = poses[before.0].inverse().compose(&poses[id.0]);
    let near =
        |found: &[f64], expected: &[f64]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < POSE_TOLERANCE);
    let (found, turned) = (quaternion(&place), quaternion(&expected));
    if near(&place.position, &expected.position) && (near(&found, &turned) || near(&found, &turned.map(|x| -x))) {
        return Ok(());
    }
    let shown = |pose: &Pose| {
        let list = |x: &[f64]| x.iter().map(|x| format!("{:.4}", x + 0.0)).collect::<Vec<_>>().join(" ");
        format!("pos {} and quat {}", list(&pose.position), list(&quaternion(pose)))
    };
    let message = format!(
        "the body of {} stands at {} of {name}, in the description at {}: the frames of the two files are not the same, \
         and inertials of one are wrong in the other; give both files the same frames",
        link.name,
        shown(&place),
        shown(&expected)
    );
    Err(Error::at(file, node.document().text_pos_at(node.range().start).row as usize, message))
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

    const HEAVY: Ten = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0];

    const MJCF: &str = r#"<mujoco><default><joint damping="9"/></default><worldbody>
  <body name="one"> <!-- keep -->
    <inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/><joint name="a" armature="1"/>
    <body name="two" pos="0.4 0 0.1"><joint name="b" axis="0 1 0"/><geom size="0.1"/></body>
  </body></worldbody></mujoco>"#;

    fn written(mjcf: &str) -> Result<WrittenBack, Error> {
        let robot = read_urdf(URDF, "r.urdf").unwrap();
        let bodies: Vec<(LinkId, Ten)> = robot.link_ids().map(|id| (id, robot.link(id).inertial.unwrap())).collect();
        let joint = JointDynamics { joint: "r_a".into(), damping: 0.5, friction: 0.2, armature: 0.01 };
        mjcf_into(mjcf, "r.xml", &robot, &bodies, &[joint], false)
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
    fn names_with_hidden_characters_are_found() {
        let hide = |text: &str| {
            let text = text.replace("two\"", "t&#x202e;wo&#10;\"").replace("r_a\"", "r_\u{9b}a\"");
            text.replace("name=\"a\"", "name=\"\u{9b}a\"")
        };
        let options = robot::format::ReadOptions::default();
        let robot = robot::format::parse_with(&hide(URDF), std::path::Path::new("r.urdf"), options).unwrap();
        let bodies: Vec<(LinkId, Ten)> = robot.link_ids().map(|id| (id, HEAVY)).collect();
        let joint = |name: &str| JointDynamics { joint: name.into(), damping: 0.5, friction: 0.2, armature: 0.01 };
        let joints = [joint("r_\\u{9b}a"), joint("r_b")];
        let into = |text: &str| mjcf_into(text, "r.xml", &robot, &bodies, &joints, false);
        let text = into(&hide(MJCF)).unwrap().text;
        assert!(text.contains("<body name=\"t&#x202e;wo&#10;\" pos=\"0.4 0 0.1\">"), "{text}");
        assert!(text.contains("frictionloss=\"0.2\" name=\"\u{9b}a\" armature=\"0.01\""), "{text}");
        let masses = text.matches("mass=\"2\"").count();
        assert!(masses == 2 && into(&text).unwrap().text == text, "{text}");

        // The name in the model lacks the hidden characters. The message must make the hidden characters visible.
        let refused = into(&hide(MJCF).replace("wo&#10;", "ow")).unwrap_err().to_string();
        assert!(refused.contains("there is no <body name=\"r_t\\u{202e}wo\\n\">"), "{refused}");
        let whole = crate::write_back::mjcf::mjcf(&robot, &bodies, &joints).unwrap();
        for text in [&refused, &whole] {
            assert!(!text.contains(|c| shown::is_hidden(c) && c != '\n'), "{text:?}");
        }
        assert!(into(&whole).is_ok(), "{whole}");
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

    #[test]
    fn orientations_are_compared() {
        let turned = URDF.replace("xyz=\"0.4 0 0.1\"", "xyz=\"0.4 0 0.1\" rpy=\"0 0 1.5707963267948966\"");
        let robot = read_urdf(&turned, "r.urdf").unwrap();
        let bodies: Vec<(LinkId, Ten)> = robot.link_ids().map(|id| (id, robot.link(id).inertial.unwrap())).collect();
        let of = |mjcf: &str, orientation: &str| {
            let text = mjcf.replace("0.4 0 0.1", &format!("0.4 0 0.1\" {orientation} gravcomp=\"0"));
            mjcf_into(&text, "r.xml", &robot, &bodies, &[], false).map_err(|e| e.to_string())
        };
        for right in ["quat=\"1 0 0 1\"", "euler=\"0 0 90\"", "axisangle=\"0 0 1 90\"", "xyaxes=\"0 1 0 -1 0 0\""] {
            assert!(of(MJCF, right).is_ok(), "{right}");
        }
        for wrong in
            ["", "euler=\"0 0 1.5708\"", "axisangle=\"0 0 1 -90\"", "xyaxes=\"1 0 0 0 1 0\"", "zaxis=\"0 0 1\""]
        {
            let refused = of(MJCF, wrong).unwrap_err();
            let is_said = refused.starts_with("r.xml:4") && refused.contains("frames of the two files");
            assert!(is_said, "{wrong}: {refused}");
        }
        let refused = of(MJCF, "quat=\"90\"").unwrap_err();
        assert!(refused.contains("<body> on the way to r_two") && refused.contains("quat=\"W X Y Z\""), "{refused}");
        // A `<frame>` between two bodies is part of the pose.
        let framed = MJCF.replace(
            "<body name=\"two\" pos=\"0.4 0 0.1\">",
            "<frame euler=\"0 0 90\" pos=\"0.4 0 0\"><body name=\"two\" pos=\"0 0 0.1\">",
        );
        let framed = framed.replace("<geom size=\"0.1\"/></body>", "<geom size=\"0.1\"/></body></frame>");
        assert!(of(&framed, "").is_ok());
        assert!(of(&framed.replace("0 0 90", "0 0 80"), "").is_err());
    }

    #[test]
    fn fixed_bodies_count_once() {
        let inertial = "<inertial><mass value=\"0.5\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>";
        let tool = format!(
            "<link name=\"r_tool\">{inertial}</link><joint name=\"weld\" type=\"fixed\"><parent link=\"r_two\"/>\
             <child link=\"r_tool\"/></joint></robot>"
        );
        let robot = read_urdf(&URDF.replace("</robot>", &tool), "r.urdf").unwrap();
        let bodies: Vec<(LinkId, Ten)> = robot.link_ids().map(|id| (id, HEAVY)).collect();
        let of = |bodies_of_model: &str| {
            let text = MJCF.replace("<geom size=\"0.1\"/>", bodies_of_model);
            mjcf_into(&text, "r.xml", &robot, &bodies, &[], false).map_err(|e| e.to_string())
        };
        for held in ["<geom size=\"0.1\"/>", "<inertial pos=\"0 0 0\" mass=\"7\" diaginertia=\"1 1 1\"/>", ""] {
            let written = of(&format!("<frame><body name=\"tool\">{held}</body></frame>")).unwrap();
            let document = Document::parse(&written.text).unwrap();
            let mass = |body: &str| {
                let node = found(&document, "body", body).unwrap();
                child(&node, "inertial").unwrap().attribute("mass").unwrap().to_string()
            };
            assert_eq!((mass("two"), mass("tool")), ("2".to_string(), "0".to_string()), "{}", written.text);
            assert_eq!(written.notes, ["r_two carries the inertia of the links fixed to it: r_tool"]);
        }
        // The body `tool` has a joint here. So the body can move and needs a mass, and the model is refused.
        let refused = of("<body name=\"tool\"><joint name=\"c\"/></body>").unwrap_err();
        assert!(refused.contains("the body tool is not fixed to the body of r_two"), "{refused}");
        // A body that exists only in the model keeps its content, and a note names this body.
        let written = of("<body name=\"grip\"><geom size=\"1\"/></body><body name=\"site\"/>").unwrap();
        assert!(written.text.contains("<body name=\"grip\"><geom"), "{}", written.text);
        assert!(written.notes[0].ends_with(": grip"), "{:?}", written.notes);
    }

    /// The model has joints at another point of their body, elements without names, and the armature of an actuator.
    #[test]
    fn the_model_itself_is_kept_whole() {
        let text = r#"<mujoco><worldbody><body><!-- one --><joint type="hinge" pos="0.1 0 0.2" ref="30" axis="0 1 0"/>
  <inertial pos="0 0 0.1" mass="3" diaginertia="1 1 1"/>
  <body name="two" pos="0.4 0 0.1"><joint name="j" axis="0 1 0"/><geom size="0.1"/></body></body></worldbody>
  <actuator><motor name="m" joint="j" gear="20" armature="0.0005"/></actuator>
  <keyframe><key qpos="1 2"/></keyframe></mujoco>"#;
        let read = |text: &str| {
            let options = robot::format::ReadOptions::default();
            robot::format::parse_with(text, std::path::Path::new("r.xml"), options).unwrap()
        };
        let robot = read(text);
        let mut bodies: Vec<(LinkId, Ten)> =
            robot.link_ids().map(|id| (id, robot.link(id).inertial.unwrap())).collect();
        bodies.iter_mut().flat_map(|(_, ten)| ten).for_each(|x| *x *= 1.5);
        let joint = |name: &str| JointDynamics { joint: name.into(), damping: 0.5, friction: 0.2, armature: 0.01 };
        let joints = [joint("body1_joint"), joint("j")];
        let written = mjcf_into(text, "r.xml", &robot, &bodies, &joints, true).unwrap();
        for kept in
            ["<!-- one -->", "ref=\"30\"", "gear=\"20\" armature=\"0\"", "<key qpos=\"1 2\"/>", "<geom size=\"0.1\"/>"]
        {
            assert!(written.text.contains(kept), "{kept}: {}", written.text);
        }
        let again = read(&written.text);
        for (link, (_, ten)) in again.links.iter().zip(&bodies) {
            // Tolerance: rounding of the transform to the centre of mass and back, of numbers below 10.
            assert!(link.inertial.unwrap().iter().zip(ten).all(|(a, b)| (a - b).abs() < 1e-13), "{}", written.text);
            assert_eq!(link.joint.rotor_inertia, robot::RotorInertia::Known(0.01));
            assert_eq!((link.joint.friction.viscous, link.joint.friction.coulomb), (Some(0.5), Some(0.2)));
        }
        assert!(written.notes[0].ends_with("and 0 in m"), "{:?}", written.notes);
        // Without such actuators, no note is written.
        let plain = text.replace(" armature=\"0.0005\"", "");
        let written = mjcf_into(&plain, "r.xml", &read(&plain), &bodies, &joints, true).unwrap();
        assert!(written.notes.is_empty() && written.text.contains("gear=\"20\"/>"), "{:?}", written.notes);
    }

    #[test]
    fn options_that_change_inertials_are_named() {
        let of = |option: &str| {
            written(&MJCF.replace("<default>", &format!("<compiler {option}/><default>"))).unwrap().notes
        };
        for option in ["inertiafromgeom=\"true\"", "balanceinertia=\"true\"", "settotalmass=\"3\"", "boundmass=\"0.1\""]
        {
            assert!(of(option).len() == 1 && of(option)[0].contains(option), "{:?}", of(option));
        }
        assert!(of("inertiafromgeom=\"auto\" boundmass=\"0\" settotalmass=\"-1\" balanceinertia=\"false\"").is_empty());
    }
}
