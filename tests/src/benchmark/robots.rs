//! The simulated robots: R3G and R3B (three revolute axes, with and without gravity), the arm RACE, a PUMA 560, and a pendulum.
//!
//! A robot has a model of its dynamics with true parameters; drives and sensors are added in `arms`.

use linear_model::pseudo_inertia::Ten;
use robot::{LinkId, Part, Pose, Robot, Value};

use crate::tape_robot::TapeRobot;
use crate::workspace;

pub fn robot_of_tests(file: &str) -> Robot {
    robot::format::read(&workspace().join("tests/data/robots").join(file)).unwrap_or_else(|e| panic!("{e}"))
}

/// The arm with three revolute axes: R3G with gravity, or R3B (balanced) without gravity.
pub fn r3(gravity: bool) -> TapeRobot {
    let r3g = robot_of_tests("r3g.yaml");
    TapeRobot::new(if gravity { r3g } else { Robot { gravity: [Value::ZERO; 3], name: "r3b".into(), ..r3g } })
}

/// R3G with an additional load on its third link: `mass`, kg, at (0.35, 0.02, 0.03) m in the frame of the link, with a moment of
/// inertia of 1e-3 kg m^2 about each axis. Also returns the change of the base parameters.
pub fn with_load(r3: &TapeRobot, mass: f64) -> (TapeRobot, Vec<f64>) {
    let pose = Pose { position: [0.35, 0.02, 0.03], ..Pose::IDENTITY };
    let load = Part { name: "load".into(), pose, mass, inertia: [1e-3, 0.0, 0.0, 1e-3, 0.0, 1e-3] };
    let body: Ten = load.parameters();
    let loaded = r3.with_body(LinkId(2), &body);
    let added = loaded.truth.iter().zip(&r3.truth).map(|(a, b)| a - b).collect();
    (loaded, added)
}

/// A reconstruction of the arm R.A.C.E. of the CEA, axes 1 to 3: ten links, three loops in which joint variables are affine
/// functions of the coordinates, no gravity.
pub fn race() -> TapeRobot {
    TapeRobot::new(crate::model("race.yaml"))
}

/// A PUMA 560 with rotor inertias and a tool.
pub fn puma() -> TapeRobot {
    TapeRobot::new(robot_of_tests("puma560_with_tool.yaml"))
}

/// A pendulum: one link with gravity.
pub fn pendulum() -> TapeRobot {
    TapeRobot::new(robot_of_tests("pendulum.yaml"))
}
