//! Makes a robot with a floating base: adds six joints and massless links between the ground and the base.
//!
//! The base is carried by three prismatic joints along x, y, z of the ground and three revolute joints for yaw, pitch and
//! roll (Rz(yaw) Ry(pitch) Rx(roll)). The base is then a link with ten inertial parameters. The joint velocities are the
//! derivatives of these six coordinates, not the twist of the base. At a pitch of +-pi/2 the configuration is singular,
//! because yaw and roll turn about the same axis.

use crate::robot::{Coordinate, Drive, Joint, JointKind, Limits, Link, LinkId, ModifiedDh, Robot};
use crate::value::Affine;
use crate::value::{CoordinateId, Value};

/// Names of the six base coordinates, which precede the coordinates of the robot.
const BASE_COORDINATE_NAMES: [&str; 6] = ["base_x", "base_y", "base_z", "base_yaw", "base_pitch", "base_roll"];

impl Robot {
    /// This robot with a floating base: it has six additional coordinates at the front, and the base becomes a link.
    pub fn floating(&self) -> Robot {
        let mut robot = self.clone();
        let mut links = root_links();
        let shift = links.len();
        let base = LinkId(shift - 1);
        let moved = |antecedent: Option<LinkId>| Some(antecedent.map_or(base, |i| LinkId(i.0 + shift)));
        let renumber =
            |variable: &mut Affine| variable.terms.iter_mut().for_each(|t| t.0.0 += BASE_COORDINATE_NAMES.len());
        for link in &mut robot.links {
            link.antecedent = moved(link.antecedent);
            renumber(&mut link.joint.variable);
        }
        for frame in robot.loops.iter_mut().flat_map(|one| [&mut one.cut, &mut one.twin]) {
            frame.antecedent = moved(frame.antecedent);
            renumber(&mut frame.variable);
        }
        links[base.0].inertial = robot.base.inertial.take();
        links[base.0].parts = std::mem::take(&mut robot.base.parts);
        links[base.0].collisions = std::mem::take(&mut robot.base.collisions);
        links.append(&mut robot.links);
        robot.links = links;
        robot.massless = BASE_COORDINATE_NAMES.len();
        let base_coordinates =
            BASE_COORDINATE_NAMES.map(|name| Coordinate { name: name.into(), limits: Limits::default() });
        robot.coordinates.splice(0..0, base_coordinates);
        robot
    }
}

/// The seven links that are added between ground and base: six links moved by the six joints, and the base, fixed to the sixth
/// link.
fn root_links() -> Vec<Link> {
    use JointKind::{Fixed, Prismatic, Revolute};
    let half_pi = || Value::Div(Box::new(Value::Pi), Box::new(Value::Number(2.0)));
    let minus = |v: Value| Value::Neg(Box::new(v));
    let turned = |gamma: Value, alpha: Value, theta: Value| ModifiedDh { gamma, alpha, theta, ..ModifiedDh::ZERO };
    // Each frame has z along its joint axis: first x, y, z of the ground, then the axes of yaw, pitch and roll.
    let forward = || turned(half_pi(), half_pi(), Value::ZERO);
    let root = [
        (forward(), Prismatic),
        (forward(), Prismatic),
        (forward(), Prismatic),
        (ModifiedDh::ZERO, Revolute),
        (turned(Value::ZERO, minus(half_pi()), Value::ZERO), Revolute),
        (forward(), Revolute),
        // The last frame is fixed. It turns the axes of the roll frame back to the axes of the base.
        (turned(minus(half_pi()), half_pi(), half_pi()), Fixed),
    ];
    let link = |(j, (geometry, kind)): (usize, (ModifiedDh, JointKind))| {
        let name = BASE_COORDINATE_NAMES.get(j).copied().unwrap_or("base").to_string();
        let (drive, variable) = match kind {
            Fixed => (Drive::Locked, Affine::constant(Value::ZERO)),
            _ => (Drive::Actuated, Affine::coordinate(CoordinateId(j))),
        };
        let joint = Joint::bare(name.clone(), kind, drive, variable);
        Link::bare(name, j.checked_sub(1).map(LinkId), geometry, joint)
    };
    root.into_iter().enumerate().map(link).collect()
}

#[cfg(test)]
mod tests {

    #[test]
    fn the_base_stands_where_its_coordinates_say() {
        let text =
            "convention: khalil-kleinfinger\nname: one\nlinks: [{link: 1, antecedent: base, d: 0.5, theta: q1}]\n";
        let fixed = crate::format::read_yaml(text, "one.yaml").unwrap();
        let floating = fixed.floating();
        let (yaw, pitch, roll) = (0.3f64, -0.4f64, 0.7f64);
        let poses = floating.link_poses(&[1.0, 2.0, 3.0, yaw, pitch, roll, 0.2]);
        let base = poses[6];
        assert_eq!(base.position.map(|x| (x * 1e12).round() / 1e12), [1.0, 2.0, 3.0]);
        // Expected values: the first column and the last row of Rz(yaw) Ry(pitch) Rx(roll).
        let expected = [yaw.cos() * pitch.cos(), yaw.sin() * pitch.cos(), -pitch.sin()];
        for r in 0..3 {
            assert!((base.rotation[r][0] - expected[r]).abs() < 1e-15);
        }
        assert!((base.rotation[2][1] - pitch.cos() * roll.sin()).abs() < 1e-15);
        assert!((base.rotation[2][2] - pitch.cos() * roll.cos()).abs() < 1e-15);
        let link = base.compose(&fixed.link_poses(&[0.2])[0]);
        for r in 0..3 {
            assert!((link.position[r] - poses[7].position[r]).abs() < 1e-14);
        }
    }
}
