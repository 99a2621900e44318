//! The ranks of robots with closed loops, described by their cut frames alone.
//!
//! Facts: SR400 39 inertial parameters, 42 with the rotors of its six motors, 43 with rotors on all
//! eight joints; a parallelogram four-bar 3; the RACE reconstruction 18.

use std::path::{Path, PathBuf};

use modeling::{BaseParameters, Derivation};
use robot::{Drive, Robot, RotorInertia, format};

fn par(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/robot/testdata/par").join(name)
}

fn read(path: &Path) -> Robot {
    format::read(path).unwrap_or_else(|e| panic!("{e}"))
}

fn base(robot: &Robot) -> BaseParameters {
    let mut derivation = Derivation::new(robot).unwrap_or_else(|e| panic!("{}: {e}", robot.name));
    let regressor = derivation.regressor();
    derivation.base_parameters(&regressor).unwrap_or_else(|e| panic!("{}: {e}", robot.name))
}

/// The robot with rotors where `has` says.
fn with_rotors(robot: &Robot, has: impl Fn(Drive) -> bool) -> Robot {
    let mut robot = robot.clone();
    for link in &mut robot.links {
        link.joint.rotor_inertia = if has(link.joint.drive) { RotorInertia::Unknown } else { RotorInertia::Absent };
    }
    robot
}

#[test]
fn sr400() {
    let robot = read(&par("sr400.par"));
    assert_eq!(base(&with_rotors(&robot, |_| false)).len(), 39);
    assert_eq!(base(&with_rotors(&robot, |d| d == Drive::Actuated)).len(), 42);
    assert_eq!(base(&with_rotors(&robot, |_| true)).len(), 43);
}

#[test]
fn a_parallelogram_has_three() {
    let robot = read(&par("parallelogram4bar.par"));
    assert_eq!(base(&robot).len(), 3);
    assert_eq!(base(&with_rotors(&robot, |_| false)).len(), 3);
}

/// Through .par, where nothing is said of the passive joints, as through YAML, where everything is.
#[test]
fn race_has_eighteen_either_way() {
    let yaml = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/race.yaml"));
    let (yaml, par) = (base(&yaml), base(&read(&par("race.par"))));
    let names = |b: &BaseParameters| b.base.iter().map(|b| b.name.clone()).collect::<Vec<_>>();
    assert_eq!(par.len(), 18);
    assert_eq!(names(&yaml), names(&par));
    assert_eq!(yaml.rules().base, par.rules().base);
}
