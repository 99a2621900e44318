//! Tests of the number of base parameters of robots with closed loops, which are described by their cut frames.
//!
//! Expected numbers: 39 for the SR400 without rotors, 42 with the rotors of its six motors, 43 with rotors on all eight joints; 3
//! for a parallelogram four-bar; 18 for the reconstruction of the RACE.

use modeling::BaseParameters;
use robot::{Drive, Robot, RotorInertia, format};
use tests::base_parameters as base;

fn par(name: &str) -> Robot {
    format::read(&tests::workspace().join("crates/robot/testdata/par").join(name)).unwrap_or_else(|e| panic!("{e}"))
}

/// The robot with a rotor inertia at each joint whose drive satisfies `has`, and without rotor inertia at the other joints.
fn with_rotors(robot: &Robot, has: impl Fn(Drive) -> bool) -> Robot {
    let mut robot = robot.clone();
    for link in &mut robot.links {
        link.joint.rotor_inertia = if has(link.joint.drive) { RotorInertia::Unknown } else { RotorInertia::Absent };
    }
    robot
}

#[test]
fn sr400() {
    let robot = par("sr400.par");
    assert_eq!(base(&with_rotors(&robot, |_| false)).len(), 39);
    assert_eq!(base(&with_rotors(&robot, |d| d == Drive::Actuated)).len(), 42);
    assert_eq!(base(&with_rotors(&robot, |_| true)).len(), 43);
}

#[test]
fn a_parallelogram_has_three() {
    let robot = par("parallelogram4bar.par");
    assert_eq!(base(&robot).len(), 3);
    assert_eq!(base(&with_rotors(&robot, |_| false)).len(), 3);
}

/// The .par file does not state the passive joints, the YAML file does. Both give the same 18 base parameters.
#[test]
fn race_has_eighteen_either_way() {
    let (yaml, par) = (base(&tests::model("race.yaml")), base(&par("race.par")));
    let names = |b: &BaseParameters| b.base.iter().map(|b| b.name.clone()).collect::<Vec<_>>();
    assert_eq!(par.len(), 18);
    assert_eq!(names(&yaml), names(&par));
    assert_eq!(yaml.rules().base, par.rules().base);
}
