//! Sets angles and lengths in the frames of a URDF to one common value if they differ only by rounding.
//!
//! A file gives axes and angles with six or seven digits. The frames computed from them inherit the rounding. For example, the
//! angles of the three fingers of a hand agree only to 1e-7 rad, and axes that should intersect have a distance of 1e-8 m. Each
//! such difference leads to additional base parameters that no motion excites. So an angle is set to an earlier angle of the
//! robot if they agree within [`ROUND_ANGLE_TOLERANCE_RAD`], up to the sign. A length is set to an earlier length if they agree
//! within [`LENGTH_AGREEMENT_M`]. A length below this tolerance is set to zero.

use crate::angle_snap::ROUND_ANGLE_TOLERANCE_RAD;
use crate::robot::{Note, Robot};
use crate::value::Value;

/// Two lengths count as equal if they differ by at most this value, m. An angle that is rounded to seven decimals causes at
/// most half of this error over 1 m.
const LENGTH_AGREEMENT_M: f64 = 1e-7;
/// A change of at most this value, rad or m, only removes a rounding error of this program, so the change gets no note.
const UNNOTED_DIFFERENCE: f64 = 1e-9;

/// Sets angles, and lengths, that nearly agree to one common value, and adds a note to the robot for each change.
pub(crate) fn make_one(robot: &mut Robot) {
    let (mut angles, mut lengths) = (Vec::new(), Vec::new());
    let mut notes = Vec::new();
    for link in &mut robot.links {
        let geometry = &mut link.geometry;
        let given = [
            ("gamma", &mut geometry.gamma, true),
            ("b", &mut geometry.b, false),
            ("alpha", &mut geometry.alpha, true),
            ("d", &mut geometry.d, false),
            ("theta", &mut geometry.theta, true),
            ("r", &mut geometry.r, false),
        ];
        for (key, value, is_angle) in given {
            // Only plain numbers are changed. Multiples of pi and expressions are exact.
            let &mut Value::Number(x) = value else { continue };
            let (known, tolerance) =
                if is_angle { (&mut angles, ROUND_ANGLE_TOLERANCE_RAD) } else { (&mut lengths, LENGTH_AGREEMENT_M) };
            let meant = match known.iter().find(|y: &&f64| (x.abs() - **y).abs() <= tolerance) {
                _ if !is_angle && x.abs() <= LENGTH_AGREEMENT_M => 0.0,
                Some(y) => y.copysign(x),
                None => {
                    known.push(x.abs());
                    continue;
                }
            };
            if (meant - x).abs() > UNNOTED_DIFFERENCE {
                let text = format!("{key} = {x} of its frame is taken for {meant}");
                notes.push(Note { subject: link.joint.name.clone(), text });
            }
            *value = Value::Number(meant);
        }
    }
    robot.snapped.extend(notes);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::format::read_yaml;

    fn geometry(of: &str) -> (Vec<f64>, usize) {
        let text = format!("convention: khalil-kleinfinger\nname: a\nlinks:\n{of}");
        let mut robot = read_yaml(&text, "a.yaml").unwrap();
        make_one(&mut robot);
        let numbers = robot.links.iter().flat_map(|l| [l.geometry.alpha.number(&[]), l.geometry.d.number(&[])]);
        (numbers.collect(), robot.snapped.len())
    }

    #[test]
    fn numbers_that_agree_are_one() {
        let (numbers, notes) = geometry(
            "  - {link: 1, antecedent: base, alpha: 0.3, d: 0.2, theta: q1}
  - {link: 2, antecedent: 1, alpha: -0.3000004, d: 0.20000002, theta: q2}
  - {link: 3, antecedent: 2, alpha: 0.30001, d: -0.0000000065, theta: q3}
",
        );
        assert_eq!(numbers, [0.3, 0.2, -0.3, 0.2, 0.30001, 0.0]);
        assert_eq!(notes, 3);
    }

    #[test]
    fn lengths_are_not_angles_and_right_angles_stay() {
        let (numbers, notes) = geometry(
            "  - {link: 1, antecedent: base, alpha: 0.3, d: 0.3000004, theta: q1}
  - {link: 2, antecedent: 1, alpha: pi/2, d: 0.31415926, theta: q2}
",
        );
        assert_eq!(numbers, [0.3, 0.3000004, PI / 2.0, 0.31415926]);
        assert_eq!(notes, 0);
    }
}
