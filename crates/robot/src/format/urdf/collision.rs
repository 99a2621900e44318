//! Reads the `<collision>` and `<visual>` elements of a URDF.
//!
//! A shape that cannot be read is kept as `Unread`, with its line. This is not an error, because most uses of a robot need no
//! shapes.

use roxmltree::Node;

use crate::angle_snap;
use crate::collision::{Collision, CollisionShape};
use crate::format::expression::LARGEST_NUMBER;
use crate::format::shown::shown;
use crate::format::xml::child;
use crate::inertial::Pose;
use crate::value::Value;

/// The shapes of a `<link>` in elements with this tag, in the frame of this link.
pub(super) fn shapes(link: Node, tag: &str) -> Vec<Collision> {
    let name = link.attribute("name").unwrap_or("");
    let own = link.children().filter(|n| n.has_tag_name(tag));
    let read = |node: Node| {
        let (pose, shape) = placed(node).unwrap_or_else(|what| {
            let line = node.document().text_pos_at(node.range().start).row;
            (Pose::IDENTITY, CollisionShape::Unread { reason: format!("line {line}: {what}") })
        });
        Collision { link: name.to_string(), pose, shape }
    };
    own.map(read).collect()
}

fn placed(collision: Node) -> Result<(Pose, CollisionShape), String> {
    let pose = match child(collision, "origin") {
        None => Pose::IDENTITY,
        Some(origin) => {
            let [xyz, rpy] = [numbers(origin, "xyz", Some([0.0; 3]))?, numbers(origin, "rpy", Some([0.0; 3]))?];
            Pose { rotation: angle_snap::rotation(&rpy.map(Value::Number)), position: xyz }
        }
    };
    let geometry = child(collision, "geometry").ok_or("<collision> has no <geometry>")?;
    let shape = geometry.children().find(Node::is_element).ok_or("<geometry> is empty")?;
    let length = |attribute: &str| numbers(shape, attribute, None).and_then(|[x]| positive(shape, attribute, x));
    let shape = match shape.tag_name().name() {
        "box" => CollisionShape::Box { size: positive_all(shape, "size", numbers(shape, "size", None)?)? },
        "cylinder" => CollisionShape::Cylinder { radius: length("radius")?, length: length("length")? },
        "capsule" => CollisionShape::Capsule { radius: length("radius")?, length: length("length")? },
        "sphere" => CollisionShape::Sphere { radius: length("radius")? },
        "mesh" => {
            let file = shape.attribute("filename").map(str::trim).filter(|file| !file.is_empty());
            let file = file.ok_or("<mesh> has no `filename`")?;
            CollisionShape::Mesh { file: file.to_string(), scale: numbers(shape, "scale", Some([1.0; 3]))? }
        }
        other => {
            let expected = "expected is box, cylinder, capsule, sphere or mesh";
            return Err(format!("<{}> is no shape that is read; {expected}", shown(other)));
        }
    };
    Ok((pose, shape))
}

/// Reads an attribute with N finite numbers. `default`: value if the attribute is missing; `None`: the attribute is required.
fn numbers<const N: usize>(node: Node, attribute: &str, default: Option<[f64; N]>) -> Result<[f64; N], String> {
    let tag = node.tag_name().name();
    let Some(text) = node.attribute(attribute) else {
        return default.ok_or_else(|| format!("<{}> has no `{attribute}`", shown(tag)));
    };
    let found: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let count = text.split_whitespace().count();
    match <[f64; N]>::try_from(found) {
        Ok(found) if count == N && found.iter().all(|x: &f64| x.abs() <= LARGEST_NUMBER) => Ok(found),
        _ => Err(format!("`{attribute}` of <{}> is `{}`; expected are {N} finite numbers", shown(tag), shown(text))),
    }
}

fn positive(node: Node, attribute: &str, x: f64) -> Result<f64, String> {
    positive_all(node, attribute, [x]).map(|[x]| x)
}

fn positive_all<const N: usize>(node: Node, attribute: &str, x: [f64; N]) -> Result<[f64; N], String> {
    match x.iter().find(|x| **x < 0.0) {
        None => Ok(x),
        Some(x) => Err(format!("`{attribute}` of <{}> is {x}; no length is negative", node.tag_name().name())),
    }
}

#[cfg(test)]
mod tests {
    use crate::collision::CollisionShape;
    use crate::format::read_urdf;

    /// The pose of a shape is relative to the frame of the link that carries it. A shape with an error is kept with its line.
    #[test]
    fn shapes_stand_in_the_frame_of_the_link() {
        let text = r#"<robot name="one">
  <link name="base"><collision><geometry><box size="1 2 3"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <link name="arm">
    <collision><origin xyz="0.5 0 0"/><geometry><cylinder radius="0.1" length="0.4"/></geometry></collision>
    <collision><geometry><sphere radius="wide"/></geometry></collision>
    <collision><geometry><mesh filename="package://arm/tool.stl" scale="0.001 0.001 0.001"/></geometry></collision>
  </link>
  <joint name="mount" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0 0.25 0"/></joint>
  <link name="tool"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
</robot>"#;
        let robot = read_urdf(text, "one.urdf").unwrap();
        assert_eq!(robot.base.collisions[0].shape, CollisionShape::Box { size: [1.0, 2.0, 3.0] });
        let own = &robot.links[0].collisions;
        let names: Vec<&str> = own.iter().map(|c| c.link.as_str()).collect();
        assert_eq!(names, ["arm", "arm", "arm", "tool"]);
        let CollisionShape::Unread { reason } = &own[1].shape else { panic!("{own:?}") };
        assert_eq!(reason, "line 7: `radius` of <sphere> is `wide`; expected are 1 finite numbers");
        // The frame of the link has its z on the joint axis. For the base, the pose of a shape equals the pose in the file.
        let pose = robot.link_poses(&[0.0])[0];
        for (shape, place) in [(&own[0], [0.5, 0.0, 0.0]), (&own[3], [0.0, 0.25, 0.0])] {
            let position = pose.compose(&shape.pose).position;
            // Allowance for the rounding of a chain of three frames.
            assert!(position.iter().zip(place).all(|(a, b)| (a - b).abs() < 1e-12), "{position:?}");
        }
    }
}
