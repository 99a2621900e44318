//! Nearly parallel joint axes. The origins of the link frames must stay near the robot, and axes that are made parallel must get
//! a note.

use robot::format::{AngleSnapping, ReadOptions, read_urdf_with};
use robot::{Error, Robot};

/// A robot with three joints and nearly parallel axes. `axis`, `rpy`: axis and orientation of the second joint.
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

/// The positions of all link frames stay below 3 m. The reader itself checks that the frames agree with the file to 1e-9.
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
                // The bodies of this robot are equal on purpose, so the finding `Copied` is expected and removed.
                let mut odd = robot::lint::lint(&robot);
                let is_note = |m: robot::lint::Mistake| m.severity() == robot::lint::Severity::Note;
                odd.retain(|finding| finding.mistake != robot::lint::Mistake::Copied && !is_note(finding.mistake));
                assert_eq!(odd, [], "{what}");
                // For a tilt between 2e-9 and 0.01 rad, a note must say that the axes were made parallel or are nearly parallel.
                let told = robot.notes.iter().any(|n| n.text.contains("common normal"));
                assert!(tilt < 2e-9 || told || !robot.snapped.is_empty(), "{what}");
            }
        }
    }
}

#[test]
fn an_axis_rounded_to_five_digits_is_taken_as_parallel() {
    // The axis (-0.6, 0, 0.8), rotated by the pitch 0.643501..., is parallel to z. Here the pitch is rounded to five digits.
    let robot = tilted("-0.6 0 0.8", "0 0.64350 0", AngleSnapping::Meant).unwrap();
    assert!(robot.snapped.iter().any(|n| n.text.contains("taken as parallel")), "{:?}", robot.snapped);
    assert_eq!(robot.links[1].geometry.alpha, robot::Value::ZERO);
    let robot = tilted("-0.6 0 0.8", "0 0.6442 0", AngleSnapping::Meant).unwrap();
    assert!(robot.snapped.is_empty() && robot.links[1].geometry.alpha != robot::Value::ZERO);
}
