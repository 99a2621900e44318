//! Writes a tree of bodies as a URDF.
//!
//! Each link has a fixed placement and an axis, as in the chain.

use std::fmt::Write;

use super::chain::{Body, Chain, Matrix, Vector};

fn three(v: Vector) -> String {
    format!("{} {} {}", v[0], v[1], v[2])
}

/// Roll, pitch and yaw (rotations about the fixed axes x, y, z) of a rotation matrix, rad.
fn roll_pitch_yaw(r: &Matrix) -> Vector {
    let level = r[0][0].hypot(r[1][0]);
    let pitch = (-r[2][0]).atan2(level);
    if level < 1e-9 {
        return [0.0, pitch, (-r[0][1]).atan2(r[1][1])];
    }
    [r[2][1].atan2(r[2][2]), pitch, r[1][0].atan2(r[0][0])]
}

/// The URDF text. `bodies`: the bodies of the description; `None`: it has no inertial parameters.
pub fn urdf(name: &str, chain: &Chain, bodies: Option<&[Body]>) -> String {
    let mut text = format!("<robot name=\"{name}\">\n  <link name=\"base_link\"/>\n");
    for (k, joint) in chain.joints.iter().enumerate() {
        let link = k + 1;
        let parent = joint.parent.map_or("base_link".to_string(), |i| format!("link_{}", i + 1));
        let kind = if joint.slides { "prismatic" } else { "revolute" };
        let inertial = bodies.map_or(String::new(), |bodies| inertial(&bodies[k]));
        writeln!(
            text,
            "  <link name=\"link_{link}\">{inertial}</link>
  <joint name=\"joint_{link}\" type=\"{kind}\">
    <parent link=\"{parent}\"/><child link=\"link_{link}\"/>
    <origin xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"{}\"/>
    <limit lower=\"{}\" upper=\"{}\" velocity=\"{}\" effort=\"{}\"/>
  </joint>",
            three(joint.origin),
            three(roll_pitch_yaw(&joint.rotation)),
            three(joint.axis),
            -joint.range,
            joint.range,
            joint.speed,
            joint.effort,
        )
        .expect("a string takes what is written to it");
    }
    text + "</robot>\n"
}

fn inertial(body: &Body) -> String {
    let i = &body.inertia;
    format!(
        "<inertial><origin xyz=\"{}\" rpy=\"0 0 0\"/><mass value=\"{}\"/>\
         <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/></inertial>",
        three(body.centre),
        body.mass,
        i[0][0],
        i[0][1],
        i[0][2],
        i[1][1],
        i[1][2],
        i[2][2]
    )
}
