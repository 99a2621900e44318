//! Axes that are parallel but for a hair: frames stay near the robot, and what is taken as parallel is said.

use robot::format::{AngleSnapping, ReadOptions, read_urdf_with};
use robot::{Error, Robot};

/// Three joints, the second tilted against the first, the third against the second.
fn tilted(axis: &str, rpy: &str, angles: AngleSnapping) -> Result<Robot, Error> {
    let inertial = "<inertial><origin xyz='0.1 0 0.05'/><mass value='1'/><inertia ixx='0.02' iyy='0.03' izz='0.025' \
                    ixy='0' ixz='0' iyz='0'/></inertial>";
    let mut text = String::from("<robot name='hair'><link name='l0'/>");
    for k in 1..=3 {
        let (axis, rpy) = if k == 2 { (axis, rpy) } else { ("0 0 1", "0 0 0") };
        text += &format!(
            "<link name='l{k}'>{inertial}</link><joint name='j{k}' type='continuous'><parent link='l{}'/><child \
             link='l{k}'/><origin xyz='0.3 0.1 0.2' rpy='{rpy}'/><axis xyz='{axis}'/></joint>",
            k - 1
        );
    }
    read_urdf_with(&(text + "</robot>"), "hair.urdf", ReadOptions { angles, ..ReadOptions::default() })
}

/// That the frames are those of the file to 1e-9 m and rad is checked by the reader.
#[test]
fn frames_stay_near_the_robot() {
    for tilt in [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 4e-5, 1e-4, 1e-3, 9e-3] {
        for (axis, rpy) in [(format!("{tilt:e} 0 1"), "0 0 0".to_string()), ("0 0 1".into(), format!("{tilt:e} 0 0"))] {
            for angles in [AngleSnapping::Meant, AngleSnapping::AsGiven] {
                let what = format!("{axis} {rpy} {angles:?}");
                let robot = tilted(&axis, &rpy, angles).unwrap_or_else(|e| panic!("{what}: {e}"));
                for pose in robot.link_poses(&[0.3, -0.4, 0.5]) {
                    assert!(pose.position.iter().all(|x| x.abs() < 3.0), "{what}: {:?}", pose.position);
                }
                // Its bodies are copies of one.
                let mut odd = robot::lint::lint(&robot);
                let is_note = |m: robot::lint::Mistake| m.severity() == robot::lint::Severity::Note;
                odd.retain(|finding| finding.mistake != robot::lint::Mistake::Copied && !is_note(finding.mistake));
                assert_eq!(odd, [], "{what}");
                // What is not taken as parallel is told as nearly so; one of both below a percent, from noise on.
                let told = robot.notes.iter().any(|n| n.text.contains("common normal"));
                assert!(tilt < 2e-9 || told || !robot.snapped.is_empty(), "{what}");
            }
        }
    }
}

#[test]
fn an_axis_rounded_to_five_digits_is_taken_as_parallel() {
    // (0.6, 0, 0.8) turned by the pitch that was meant, 0.643501..., written with five digits.
    let robot = tilted("-0.6 0 0.8", "0 0.64350 0", AngleSnapping::Meant).unwrap();
    assert!(robot.snapped.iter().any(|n| n.text.contains("taken as parallel")), "{:?}", robot.snapped);
    assert_eq!(robot.links[1].geometry.alpha, robot::Value::ZERO);
    let robot = tilted("-0.6 0 0.8", "0 0.6442 0", AngleSnapping::Meant).unwrap();
    assert!(robot.snapped.is_empty() && robot.links[1].geometry.alpha != robot::Value::ZERO);
}
