//! The joints of a model: type, axis, limits, friction and `mimic`.
//!
//! A joint connects its parent (a link or the world) and its child (the link that it moves). A joint with `mimic` follows
//! another joint, its leader.

use roxmltree::Node;

use super::element::{Mistake, child, children, is_true, name, note, numbers, text, wrong};
use super::frames::{Frames, MODEL};
use robot::format::{ReadOptions, RobotDescription};
use robot::vector::{Vector3, turned, turned_back};
use robot::{Friction, Limits, Pose};

/// A position limit of at least this size, rad or m, means that there is no limit: the format's default is 1e16.
const NO_LIMIT: f64 = 1e15;
/// Up to this version, an axis is given in the frame of the model.
const LAST_VERSION_OF_MODEL_AXES: (u32, u32) = (1, 4);

/// A joint of the file.
pub(super) struct SdfJoint<'a> {
    pub node: Node<'a, 'a>,
    /// The link, or the world, that carries the joint; `None` for the first link.
    pub parent: Option<&'a str>,
    /// The link that the joint moves; `None` for the first link.
    pub child: Option<&'a str>,
    pub kind: JointType,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum JointType {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    /// Another type. Joints of such a type can only be left out.
    Other,
}

/// The joints of a model, in the order of the file.
pub(super) fn joints<'a>(model: Node<'a, 'a>, frames: &Frames<'a>) -> Result<Vec<SdfJoint<'a>>, Mistake> {
    let mut joints = Vec::new();
    for node in children(model, "joint") {
        let end = |tag: &str| {
            let end = child(node, tag).map(text).filter(|text| !text.is_empty());
            end.ok_or_else(|| wrong(node, format!("joint `{}` has no <{tag}>", name(node))))
        };
        let kind = match node.attribute("type").unwrap_or("") {
            "fixed" => JointType::Fixed,
            "revolute" => JointType::Revolute,
            "continuous" => JointType::Continuous,
            "prismatic" => JointType::Prismatic,
            _ => JointType::Other,
        };
        joints.push(SdfJoint { node, parent: frames.link(end("parent")?)?, child: frames.link(end("child")?)?, kind });
    }
    Ok(joints)
}

impl<'a> SdfJoint<'a> {
    pub(super) fn name(&self) -> &'a str {
        name(self.node)
    }

    fn in_axis(&self, tag: &str) -> Option<Node<'a, 'a>> {
        child(child(self.node, "axis")?, tag)
    }

    fn number(&self, owner: &str, tag: &str) -> Result<Option<f64>, Mistake> {
        let node = self.in_axis(owner).and_then(|owner| child(owner, tag));
        // An infinite limit is written as `inf`.
        let given = node.filter(|node| !text(*node).trim_start_matches(['-', '+']).to_lowercase().starts_with("inf"));
        given
            .map(|node| {
                if text(node).parse().is_ok_and(|x: f64| x.abs() >= NO_LIMIT) {
                    Ok(None)
                } else {
                    numbers::<1>(node).map(|[x]| Some(x))
                }
            })
            .unwrap_or(Ok(None))
    }

    /// The axis in the frame of the joint. `pose`: pose of the joint in the frame of the model.
    pub(super) fn axis(&self, frames: &Frames, pose: &Pose) -> Result<Vector3, Mistake> {
        let Some(xyz) = self.in_axis("xyz") else { return Ok([0.0, 0.0, 1.0]) };
        let axis = numbers(xyz)?;
        let of_model = self.in_axis("use_parent_model_frame").map(|node| is_true(text(node)));
        let frame = match (xyz.attribute("expressed_in").filter(|name| !name.is_empty()), of_model) {
            (Some(frame), _) => frame,
            (None, Some(true)) => MODEL,
            (None, None) if version(self.node) <= LAST_VERSION_OF_MODEL_AXES => MODEL,
            _ => return Ok(axis),
        };
        let frame = if frame == MODEL { Pose::IDENTITY } else { frames.pose(frame)? };
        Ok(turned_back(&pose.rotation, turned(&frame.rotation, axis)))
    }

    /// Limits and friction. Springs get a note.
    pub(super) fn dynamics(&self, described: &mut RobotDescription) -> Result<(Limits, Friction), Mistake> {
        let [lower, upper] = [self.number("limit", "lower")?, self.number("limit", "upper")?];
        let position = match (lower, upper) {
            _ if self.kind == JointType::Continuous => None,
            (None, None) => None,
            (lower, upper) => Some((lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY))),
        };
        let magnitude = |x: Option<f64>| x.filter(|x| *x > 0.0);
        let limits = Limits {
            position,
            velocity: magnitude(self.number("limit", "velocity")?),
            effort: magnitude(self.number("limit", "effort")?),
            ..Limits::default()
        };
        if self.number("dynamics", "spring_stiffness")?.is_some_and(|k| k != 0.0) {
            note(described, self.name(), "has a spring, which is not read: its torque is none of the robot".into());
        }
        let friction = Friction {
            viscous: self.number("dynamics", "damping")?,
            coulomb: self.number("dynamics", "friction")?,
            offset: None,
        };
        Ok((limits, friction))
    }

    /// The joint that this joint follows (its leader), with factor and offset: q = multiplier (q_leader - reference) + offset.
    pub(super) fn mimics(
        &self,
        options: ReadOptions,
        described: &mut RobotDescription,
    ) -> Result<Option<(&'a str, f64, f64)>, Mistake> {
        let Some(mimic) = self.in_axis("mimic") else { return Ok(None) };
        if options.mimic == robot::format::Mimic::Independent {
            note(
                described,
                self.name(),
                "mimics another joint in the file; read as a coordinate of its own, as was asked".into(),
            );
            return Ok(None);
        }
        let number = |tag: &str, missing: f64| child(mimic, tag).map_or(Ok([missing]), numbers).map(|[x]| x);
        let leader = mimic.attribute("joint").unwrap_or("");
        let (multiplier, reference) = (number("multiplier", 1.0)?, number("reference", 0.0)?);
        Ok(Some((leader, multiplier, number("offset", 0.0)? - multiplier * reference)))
    }
}

/// The version of the format, as major and minor number; 1.12 if it is not given.
fn version(node: Node) -> (u32, u32) {
    let text = node.document().root_element().attribute("version").unwrap_or("1.12");
    let mut parts = text.split('.').map(|part| part.parse().unwrap_or(0));
    (parts.next().unwrap_or(1), parts.next().unwrap_or(0))
}
