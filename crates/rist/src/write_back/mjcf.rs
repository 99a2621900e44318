//! Writes a robot without loops as a new MuJoCo model (MJCF): bodies, joints, limits, friction, rotor inertia, gravity.
//!
//! ```text
//! iTj(q) = iTj(0) Rz(f q),    or iTj(0) Tz(f q) where the joint slides
//! ```
//! iTj: pose of link j in link i. A body is placed in its parent body by the pose of its link at q = 0, in the frames that the
//! file of the robot gives its links. Its joint rotates about z of the link frame, or slides along it, with the factor f = 1 or
//! -1 (-1: about -z). A joint that follows the coordinate of another joint is connected to it by an `<equality>`. Inertials are
//! about the centre of mass: I_c = I - m (c'c 1 - c c'), c: centre of mass, m: mass, 1: identity matrix.
//!
//! Shapes (geoms) are not written. [`crate::write_back::mjcf_into`] writes the values into a model that has shapes.

use std::fmt::Write as _;

use linear_model::pseudo_inertia::{Ten, centroidal};
use logs::Error;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use robot::value::CoordinateId;
use robot::{Drive, JointKind, Link, LinkId, Pose, Robot};

use crate::write_back::body::{self, JointDynamics};

/// Writes a robot as MJCF. `bodies`: ten inertial parameters of each link about the origin of its frame; `joints`: one entry per
/// coordinate.
///
/// Fails if the robot floats or has loops, if a joint moves with several coordinates, or if a body is not physically consistent.
pub fn mjcf(robot: &Robot, bodies: &[(LinkId, Ten)], joints: &[JointDynamics]) -> Result<String, Error> {
    if robot.massless > 0 || !robot.loops.is_empty() || !robot.passive.is_empty() {
        return Err(Error::new(
            "no MJCF is written of a robot that floats or has loops; [into=MODEL.xml] puts the figures into yours",
        ));
    }
    let [gx, gy, gz] = robot.gravity_number();
    let mut text = format!(
        "<mujoco model=\"{}\">\n  <compiler angle=\"radian\"/>\n  <option gravity=\"{gx} {gy} {gz}\"/>\n  <worldbody>\n",
        escaped(&robot.name)
    );
    let poses = file_poses(robot);
    let mut equalities = String::new();
    // Links whose `<body>` elements are not closed yet, each inside the previous one.
    let mut open: Vec<LinkId> = Vec::new();
    for id in nested(robot) {
        let link = robot.link(id);
        while open.last().copied() != link.antecedent {
            let Some(_) = open.pop() else { break };
            let _ = writeln!(text, "{}</body>", indent(open.len()));
        }
        let ahead = match link.antecedent {
            Some(i) => poses[i.0].inverse().compose(&poses[id.0]),
            None => poses[id.0],
        };
        let margin = indent(open.len());
        let _ = writeln!(text, "{margin}<body name=\"{}\" {}>", escaped(&link.name), placed(&ahead));
        if let Some((_, ten)) = bodies.iter().find(|(of, _)| *of == id) {
            let _ = writeln!(text, "{margin}  {}", inertial(link, ten)?);
        }
        if let Some(joint) = joint(robot, link, joints, &mut equalities)? {
            let _ = writeln!(text, "{margin}  {joint}");
        }
        open.push(id);
    }
    while open.pop().is_some() {
        let _ = writeln!(text, "{}</body>", indent(open.len()));
    }
    text += "  </worldbody>\n";
    if !equalities.is_empty() {
        let _ = write!(text, "  <equality>\n{equalities}  </equality>\n");
    }
    Ok(text + "</mujoco>\n")
}

/// For each link, the pose at q = 0 of the body that the file gives the link, in the base frame.
pub(super) fn file_poses(robot: &Robot) -> Vec<Pose> {
    let poses = robot.link_poses(&vec![0.0; robot.n_variables()]);
    poses.iter().zip(&robot.links).map(|(pose, link)| pose.compose(&body_frame(link))).collect()
}

/// The pose of the body frame of a link, relative to the link frame. The body frame is the frame of the `<body>` element in the
/// user's file. In an MJCF, the joint (and so the link frame) may be at another point than the origin of the body.
fn body_frame(link: &Link) -> Pose {
    link.frames.iter().find(|(name, _)| *name == link.name).map_or(link.file_frame, |(_, pose)| *pose)
}

/// The links in depth-first order, in which `<body>` elements are nested.
fn nested(robot: &Robot) -> Vec<LinkId> {
    let mut order = Vec::with_capacity(robot.links.len());
    let carried = |by: Option<LinkId>| robot.link_ids().rev().filter(move |id| robot.link(*id).antecedent == by);
    let mut next: Vec<LinkId> = carried(None).collect();
    while let Some(id) = next.pop() {
        order.push(id);
        next.extend(carried(Some(id)));
    }
    order
}

/// The `<inertial>` element of a body, in the frame that the file gives the body.
pub(super) fn inertial(link: &Link, ten: &Ten) -> Result<String, Error> {
    body::check(link, ten).map_err(Error::new)?;
    let in_file = robot::transform_inertial(ten, &body_frame(link).inverse());
    let body = centroidal(&in_file).ok_or_else(|| Error::new(format!("link {}: no mass", link.name)))?;
    let ([x, y, z], [xx, xy, xz, yy, yz, zz]) = (body.centre, body.inertia);
    let mass = body.mass;
    Ok(format!("<inertial pos=\"{x} {y} {z}\" mass=\"{mass}\" fullinertia=\"{xx} {yy} {zz} {xy} {xz} {yz}\"/>"))
}

/// Attributes for the position and orientation of a body.
fn placed(pose: &Pose) -> String {
    let [x, y, z] = pose.position;
    let [w, i, j, k] = quaternion(pose);
    format!("pos=\"{x} {y} {z}\" quat=\"{w} {i} {j} {k}\"")
}

/// The orientation of a pose as a quaternion, w first.
pub(super) fn quaternion(pose: &Pose) -> [f64; 4] {
    let rotation = Matrix3::from_fn(|r, c| pose.rotation[r][c]);
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    [q.w, q.i, q.j, q.k]
}

/// The `<joint>` element of a link; `None` if the link is fixed. If the joint follows the coordinate of another joint, an
/// `<equality>` that connects the two is appended to `equalities`.
fn joint(
    robot: &Robot,
    link: &Link,
    joints: &[JointDynamics],
    equalities: &mut String,
) -> Result<Option<String>, Error> {
    let (kind, drive) = (link.joint.kind, link.joint.drive);
    let (CoordinateId(k), factor) = match link.joint.variable.terms.as_slice() {
        [] => return Ok(None),
        _ if kind == JointKind::Fixed => return Ok(None),
        [(k, factor)] => (*k, *factor),
        _ => {
            let name = &link.joint.name;
            return Err(Error::new(format!(
                "the joint {name} moves with several coordinates: MJCF has no word for it"
            )));
        }
    };
    let coordinate = &robot.coordinates[k];
    let follows = drive != Drive::Actuated || factor.abs() != 1.0;
    // The joint's axis and position in the frame of the body.
    let to_body = body_frame(link).inverse();
    let sign = if follows { 1.0 } else { factor.signum() };
    let axis = [0, 1, 2].map(|r| sign * to_body.rotation[r][2]);
    let ([x, y, z], [ax, ay, az]) = (to_body.position.map(plain), axis.map(plain));
    let name = if follows { &link.joint.name } else { &coordinate.name };
    let word = if kind == JointKind::Prismatic { "slide" } else { "hinge" };
    let mut text =
        format!("<joint name=\"{}\" type=\"{word}\" pos=\"{x} {y} {z}\" axis=\"{ax} {ay} {az}\"", escaped(name));
    if follows {
        let (one, other) = (escaped(name), escaped(&coordinate.name));
        let _ = writeln!(equalities, "    <joint joint1=\"{one}\" joint2=\"{other}\" polycoef=\"0 {factor} 0 0 0\"/>");
    } else {
        if let Some((low, high)) = coordinate.limits.position.filter(|(low, high)| low < high) {
            let _ = write!(text, " range=\"{low} {high}\"");
        }
        if let Some(found) = joints.iter().find(|joint| joint.joint == coordinate.name) {
            attributes(found).iter().for_each(|(key, value)| text += &format!(" {key}=\"{value}\""));
        }
    }
    Ok(Some(text + "/>"))
}

/// MuJoCo attributes for friction and rotor inertia. Negative values become zero, because MuJoCo refuses negative values.
pub(super) fn attributes(joint: &JointDynamics) -> [(&'static str, String); 3] {
    [("damping", joint.damping), ("frictionloss", joint.friction), ("armature", joint.armature)]
        .map(|(key, value)| (key, value.max(0.0).to_string()))
}

/// The number `x`, with -0 replaced by 0.
fn plain(x: f64) -> f64 {
    x + 0.0
}

fn indent(depth: usize) -> String {
    "  ".repeat(depth + 2)
}

/// Escapes a name for the quotes of an attribute.
fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot::format::{read_urdf, read_yaml};
    use roxmltree::Document;

    const ARM: &str = "convention: khalil-kleinfinger\nname: a&b\nlinks:\n  \
        - {link: 1, antecedent: base, theta: q1, limits: {position: [-1, 2]}}\n  \
        - {link: 2, antecedent: 1, alpha: pi/2, d: 0.5, r: 0.1 - q2, joint: prismatic}\n  \
        - {link: 3, antecedent: 1, drive: passive, theta: -2*q1 + pi/2}\n";

    fn numbers(node: roxmltree::Node, key: &str) -> Vec<f64> {
        node.attribute(key).unwrap().split(' ').map(|x| x.parse().unwrap()).collect()
    }

    const BODY: Ten = [0.1, 0.0, 0.01, 0.12, 0.0, 0.11, 0.2, 0.0, 0.1, 2.0];

    #[test]
    fn bodies_and_joints() {
        let robot = read_yaml(ARM, "arm.yaml").unwrap();
        let bodies: Vec<(LinkId, Ten)> = robot.link_ids().map(|id| (id, BODY)).collect();
        let joint = JointDynamics { joint: "q1".into(), damping: 0.3, friction: -1.0, armature: 0.05 };
        let text = mjcf(&robot, &bodies, &[joint]).unwrap();
        let document = Document::parse(&text).unwrap();
        let find = |tag: &str, name: &str| {
            document.descendants().find(|n| n.has_tag_name(tag) && n.attribute("name") == Some(name)).unwrap()
        };
        let (first, second, third) = (find("body", "link 1"), find("body", "link 2"), find("body", "link 3"));
        assert!(second.parent() == Some(first) && third.parent() == Some(first));
        // The second link has the pose Rx(pi/2) Tx(0.5) Tz(0.1) in the first link, so its z axis is -y of the first link.
        // Tolerance: rounding of sine and cosine.
        for (found, expected) in numbers(second, "pos").iter().zip([0.5, -0.1, 0.0]) {
            assert!((found - expected).abs() < 1e-15);
        }
        let hinge = find("joint", "q1");
        let shown = ["range", "damping", "frictionloss", "armature"].map(|key| hinge.attribute(key).unwrap());
        assert_eq!(shown, ["-1 2", "0.3", "0", "0.05"]);
        let slide = find("joint", "q2");
        assert_eq!((slide.attribute("type"), numbers(slide, "axis")[2]), (Some("slide"), -1.0));
        assert!(text.contains("polycoef=\"0 -2 0 0 0\""), "{text}");
        assert_eq!(numbers(first.first_element_child().unwrap(), "mass"), [2.0]);
    }

    #[test]
    fn frames_are_the_files() {
        let urdf = r#"<robot name="r"><link name="base"/><link name="l"><inertial><origin xyz="0.1 0.2 0"/><mass value="2"/>
            <inertia ixx="0.1" ixy="0.01" ixz="0" iyy="0.12" iyz="0.02" izz="0.11"/></inertial></link>
            <joint name="j" type="revolute"><parent link="base"/><child link="l"/><origin xyz="0 0 0.3" rpy="0.2 0.1 0"/>
            <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
        let robot = read_urdf(urdf, "r.urdf").unwrap();
        let ten = robot.links[0].inertial.unwrap();
        let text = mjcf(&robot, &[(LinkId(0), ten)], &[]).unwrap();
        let document = Document::parse(&text).unwrap();
        for (tag, key, expected) in [
            ("inertial", "pos", &[0.1, 0.2, 0.0][..]),
            ("inertial", "fullinertia", &[0.1, 0.12, 0.11, 0.01, 0.0, 0.02]),
            ("joint", "axis", &[0.0, 1.0, 0.0]),
            ("body", "pos", &[0.0, 0.0, 0.3]),
        ] {
            let found = numbers(document.descendants().find(|n| n.has_tag_name(tag)).unwrap(), key);
            // Tolerance: rounding of a few products of sines and cosines.
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{tag} {key}: {found:?}");
        }
    }

    #[test]
    fn refusals() {
        let robot = read_yaml(ARM, "arm.yaml").unwrap();
        let refused = mjcf(&robot, &[(LinkId(0), [0.0; 10])], &[]).unwrap_err().to_string();
        assert!(refused.contains("are no body"), "{refused}");
    }
}
