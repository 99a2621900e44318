//! The frames of an SDF model: the frames of links and joints, and the elements `<frame>`. The file gives the pose of each
//! frame relative to another frame.
//!
//! T_f: pose of frame f in the frame of the model; gTf: pose of f in frame g, as the file gives it. Then T_f = T_g gTf.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::element::{Mistake, child, children, is_true, name, numbers, text, wrong};
use robot::Pose;
use robot::format::{AngleSnapping, RobotDescription};

/// The name of the frame of the model.
pub(super) const MODEL: &str = "__model__";
/// The name of the frame of the world.
pub(super) const WORLD: &str = "world";

/// A frame as the file gives it.
struct StatedFrame<'a> {
    pose: Pose,
    /// The frame that the pose is relative to.
    base: &'a str,
    /// Name of the frame that carries this frame. A link carries itself.
    carrier: &'a str,
    line: usize,
}

/// The frames of a model by name.
pub(super) struct Frames<'a> {
    stated: BTreeMap<&'a str, StatedFrame<'a>>,
}

impl<'a> Frames<'a> {
    /// Reads the frames of a model. Fails if a name stands twice, or if a pose cannot be read.
    pub(super) fn of(
        model: Node<'a, 'a>,
        described: &mut RobotDescription,
        angles: AngleSnapping,
    ) -> Result<Frames<'a>, Mistake> {
        let mut frames = Frames { stated: BTreeMap::new() };
        // The file gives the pose of the model frame in the world. So the inverse pose places the world in the frame of the
        // model.
        let (pose, _) = stated(model, described, angles)?;
        let line = |node: Node| node.document().text_pos_at(node.range().start).row as usize;
        let inverse = StatedFrame { pose: pose.inverse(), base: MODEL, carrier: WORLD, line: line(model) };
        frames.stated.insert(WORLD, inverse);
        for node in model.children().filter(Node::is_element) {
            let text_of = |tag: &str| child(node, tag).map(text).filter(|text| !text.is_empty());
            let (otherwise, carrier) = match node.tag_name().name() {
                "link" => (MODEL, name(node)),
                "joint" => {
                    let child = text_of("child").unwrap_or(MODEL);
                    (child, child)
                }
                "frame" => {
                    let carrier = node.attribute("attached_to").filter(|name| !name.is_empty()).unwrap_or(MODEL);
                    (carrier, carrier)
                }
                _ => continue,
            };
            if name(node).is_empty() {
                return Err(wrong(node, format!("a <{}> has no name", node.tag_name().name())));
            }
            let (pose, base) = stated(node, described, angles)?;
            let frame = StatedFrame { pose, base: base.unwrap_or(otherwise), carrier, line: line(node) };
            if let Some(first) = frames.stated.insert(name(node), frame) {
                return Err(wrong(
                    node,
                    format!("the name `{}` stands twice, first on line {}", name(node), first.line),
                ));
            }
        }
        Ok(frames)
    }

    fn get(&self, name: &str, from: Option<&StatedFrame>) -> Result<&StatedFrame<'a>, Mistake> {
        let line = from.map_or(0, |from| from.line);
        self.stated
            .get(name)
            .ok_or_else(|| Mistake { line, message: format!("there is no frame `{name}` in the model") })
    }

    /// The pose of a frame in the frame of the model. Fails if this frame does not exist, or a frame to which it is relative.
    pub(super) fn pose(&self, name: &str) -> Result<Pose, Mistake> {
        let (mut pose, mut at, mut from) = (Pose::IDENTITY, name, None);
        for _ in 0..=self.stated.len() {
            if at == MODEL {
                return Ok(pose);
            }
            let frame = self.get(at, from)?;
            pose = frame.pose.compose(&pose);
            (at, from) = (frame.base, Some(frame));
        }
        let line = from.map_or(0, |from| from.line);
        Err(Mistake { line, message: format!("the frame `{name}` is relative to itself") })
    }

    /// The link that carries a frame; for the frame of the world, the world. `None`: the frame is attached to the model, so the
    /// first link of the model carries it.
    pub(super) fn link(&self, name: &'a str) -> Result<Option<&'a str>, Mistake> {
        let (mut at, mut from) = (name, None);
        for _ in 0..=self.stated.len() {
            if at == MODEL {
                return Ok(None);
            }
            let frame = self.get(at, from)?;
            if frame.carrier == at {
                return Ok(Some(at));
            }
            (at, from) = (frame.carrier, Some(frame));
        }
        Err(Mistake {
            line: from.map_or(0, |from| from.line),
            message: format!("the frame `{name}` is attached to itself"),
        })
    }
}

/// The `<pose>` of an element, and the frame that it is relative to, if the file says so.
pub(super) fn stated<'a>(
    node: Node<'a, 'a>,
    described: &mut RobotDescription,
    angles: AngleSnapping,
) -> Result<(Pose, Option<&'a str>), Mistake> {
    let Some(pose) = child(node, "pose") else { return Ok((Pose::IDENTITY, None)) };
    // The attribute was called `frame` before version 1.7.
    let base = pose.attribute("relative_to").or(pose.attribute("frame")).filter(|name| !name.is_empty());
    if text(pose).is_empty() {
        return Ok((Pose::IDENTITY, base));
    }
    if pose.attribute("rotation_format") == Some("quat_xyzw") {
        let [x, y, z, qx, qy, qz, qw] = numbers(pose)?;
        return Ok((Pose { rotation: rotation(pose, [qx, qy, qz, qw])?, position: [x, y, z] }, base));
    }
    let [x, y, z, roll, pitch, yaw] = numbers(pose)?;
    let unit = if pose.attribute("degrees").is_some_and(is_true) { 1f64.to_radians() } else { 1.0 };
    let subject = if name(node).is_empty() { node.tag_name().name() } else { name(node) };
    Ok((described.pose(subject, [x, y, z], [roll, pitch, yaw].map(|angle| unit * angle), angles), base))
}

/// The rotation of a quaternion x y z w of any length above 0.
fn rotation(node: Node, quaternion: [f64; 4]) -> Result<[[f64; 3]; 3], Mistake> {
    let square: f64 = quaternion.iter().map(|c| c * c).sum();
    if square <= 0.0 || !square.is_normal() {
        return Err(wrong(node, "a quaternion of zeros has no orientation"));
    }
    let [x, y, z, w] = quaternion.map(|c| c / square.sqrt());
    Ok([
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ])
}

/// The names of all links of a model, in the order of the file.
pub(super) fn links<'a>(model: Node<'a, 'a>) -> Vec<&'a str> {
    children(model, "link").map(name).collect()
}
