//! A robot with locked joints, for example a gripper that is not in the log, or a closed brake.
//!
//! A locked coordinate is removed. Each joint and loop frame that it moved gets a constant angle or length. The links behind
//! the joint are kept, with their parameters.

use gate::suggestion::did_you_mean;

use crate::angle_snap::{computed_angle, computed_length};
use crate::robot::{Drive, JointKind, ModifiedDh, Robot, RotorInertia};
use crate::value::{Affine, Value};

impl Robot {
    /// This robot with the coordinate `name` locked at `position`, rad (m).
    ///
    /// Fails if there is no coordinate of this name, if it is the only coordinate, or if a loop is solved numerically.
    pub fn locked(&self, name: &str, position: f64) -> Result<Robot, String> {
        let names = || self.coordinates.iter().map(|coordinate| coordinate.name.as_str());
        let Some(k) = names().position(|own| own == name) else {
            let meant = did_you_mean(name, names());
            let all = names().collect::<Vec<_>>().join(", ");
            return Err(format!("no joint `{name}` to lock{meant}; there are {all}"));
        };
        if self.coordinates.len() == 1 {
            return Err(format!("with `{name}` locked no joint of the robot moves"));
        }
        if !position.is_finite() {
            return Err(format!("`{name}` is locked at {position}: no position"));
        }
        if self.loops.iter().any(|one| self.is_implicit(one)) {
            return Err(format!("`{name}` cannot be locked: the robot has a loop that is solved numerically"));
        }
        let mut robot = self.clone();
        robot.coordinates.remove(k);
        // If only the locked coordinate moves a joint, the joint and its rotor stand still, so there is no rotor inertia.
        for link in &mut robot.links {
            let moved = !link.joint.variable.terms.is_empty();
            hold(&mut link.geometry, link.joint.kind, &mut link.joint.variable, k, position);
            if moved && link.joint.variable.terms.is_empty() {
                link.joint.drive = Drive::Locked;
                link.joint.rotor_inertia = RotorInertia::Absent;
            }
        }
        // The frames of loop cuts may move with the coordinate too.
        for frame in robot.loops.iter_mut().flat_map(|one| [&mut one.cut, &mut one.twin]) {
            hold(&mut frame.geometry, frame.kind, &mut frame.variable, k, position);
        }
        Ok(robot)
    }
}

/// Adds the constant contribution of the locked coordinate k to the geometry, removes k from the joint variable, and renumbers
/// the other coordinates.
fn hold(geometry: &mut ModifiedDh, kind: JointKind, variable: &mut Affine, k: usize, position: f64) {
    let part: f64 = variable.terms.iter().filter(|term| term.0.0 == k).map(|term| term.1 * position).sum();
    variable.terms.retain(|term| term.0.0 != k);
    variable.terms.iter_mut().filter(|term| term.0.0 > k).for_each(|term| term.0.0 -= 1);
    if part == 0.0 {
        return;
    }
    let shifted = |value: &Value, exact: fn(f64) -> Value| match value {
        // The value may contain symbols. Then the contribution is added as a new term of the expression.
        Value::Number(x) => exact(x + part),
        value => Value::Add(Box::new(value.clone()), Box::new(Value::Number(part))),
    };
    match kind {
        JointKind::Revolute => geometry.theta = shifted(&geometry.theta, computed_angle),
        JointKind::Prismatic => geometry.r = shifted(&geometry.r, computed_length),
        JointKind::Fixed => {}
    }
}

#[cfg(test)]
mod tests {
    use crate::Drive;
    use crate::format::{read_urdf, read_yaml};

    /// The links have the same poses as in the unlocked robot with the joint at this position. A joint that follows the locked
    /// joint becomes fixed too.
    #[test]
    fn a_locked_robot_is_the_robot_at_that_position() {
        let text = "convention: khalil-kleinfinger\nname: arm\nsymbols: {A: 0.2}\nlinks:\n\
                    - {link: 1, antecedent: base, theta: q1 + A}\n\
                    - {link: 2, antecedent: 1, alpha: pi/2, d: 0.3, theta: q2 + pi/2}\n\
                    - {link: 3, antecedent: 2, d: 0.4, theta: q3 - q2, drive: passive}\n\
                    - {link: 4, antecedent: 3, alpha: pi/2, joint: prismatic, r: q3}\n";
        let arm = read_yaml(text, "arm.yaml").unwrap();
        let held = arm.locked("q2", 0.7).unwrap();
        let names: Vec<&str> = held.coordinates.iter().map(|c| c.name.as_str()).collect();
        assert_eq!((names, held.links[1].joint.drive), (vec!["q1", "q3"], Drive::Locked));
        for (q1, q3) in [(0.3, -0.4), (-1.0, 0.2)] {
            for (a, b) in arm.link_poses(&[q1, 0.7, q3]).iter().zip(held.link_poses(&[q1, q3])) {
                for i in 0..3 {
                    assert!((a.position[i] - b.position[i]).abs() < 1e-14);
                    assert!((0..3).all(|k| (a.rotation[i][k] - b.rotation[i][k]).abs() < 1e-14));
                }
            }
        }
        assert!(arm.locked("q5", 0.0).unwrap_err().contains("no joint `q5` to lock (did you mean `q1`?)"));
        assert!(arm.locked("q1", f64::NAN).unwrap_err().contains("no position"));
        let last = held.locked("q1", 0.0).unwrap();
        assert!(last.locked("q3", 0.0).unwrap_err().contains("no joint of the robot moves"));
        assert_eq!(last.links[0].geometry, arm.links[0].geometry);
    }

    #[test]
    fn a_joint_that_mimics_a_locked_one_is_locked() {
        let joint = |name: &str, parent: &str, child: &str, more: &str| {
            format!(
                "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
                 <limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/>{more}</joint>"
            )
        };
        let links = ["b", "l1", "l2", "l3"].map(|name| format!("<link name=\"{name}\"/>")).concat();
        let (arm, left) = (joint("arm", "b", "l1", ""), joint("left", "l1", "l2", ""));
        let right = joint("right", "l1", "l3", "<mimic joint=\"left\" multiplier=\"-1\"/>");
        let text = format!("<robot name=\"r\">{links}{arm}{left}{right}</robot>");
        let held = read_urdf(&text, "r.urdf").unwrap().locked("left", 0.02).unwrap();
        assert_eq!((held.n_coordinates(), held.links[2].joint.drive), (1, Drive::Locked));
        assert!((held.links[2].geometry.theta.number(&[]) + 0.02).abs() < 1e-15);
    }
}
