//! Robots in tests/data/loops, with their numbers of base parameters. Their passive joint variables are no affine functions of
//! the coordinates.
//!
//! The numbers are ranks of regressors from independent mechanics: the regressor of the open tree (by Pinocchio), reduced by the
//! Jacobian of the loops. Only the number of the slider-crank was computed by this project, numerically and exactly.

use std::path::PathBuf;

use robot::{Robot, Value, format};

use crate::random::Random;
use crate::workspace;

/// For each robot: file name without extension, number of base parameters, and whether the rank of the regressor is proven
/// exactly (in a finite field).
pub const LOOPS: [(&str, usize, bool); 15] = [
    ("four_bar", 8, true),
    ("crossed_four_bar", 8, true),
    ("slider_crank", 6, true),
    ("boom", 8, true),
    ("whitworth", 8, true),
    ("scissor", 5, true),
    ("watt", 13, true),
    ("stephenson", 13, true),
    ("peaucellier", 14, true),
    ("three_rpr", 19, true),
    ("spherical_five_bar", 18, true),
    ("four_bars_in_series", 24, true),
    ("gough_stewart", 160, true),
    ("sarrus", 5, false),
    ("bricard", 24, false),
];

/// A parallelogram whose opposite sides are equal only for these values of its four lengths. For general values it is a four-bar
/// with eight base parameters.
pub const BY_CHANCE: &str = "\
convention: khalil-kleinfinger
name: by_chance
rotor_inertia: none
gravity: [0, -9.81, 0]
symbols: {L0: 0.5, L1: 0.2, L2: 0.5, L3: 0.2}
coordinates: [q1]
links:
  - {link: 1, antecedent: base, theta: q1 + 1.0, limits: {position: [-0.5, 0.5], velocity: 2, effort: 50}}
  - {link: 2, antecedent: 1, joint: revolute, drive: passive, d: L1, start: -1.0}
  - {link: 3, antecedent: base, joint: revolute, drive: passive, d: L0, start: 1.0}
loops:
  - cut: {antecedent: 2, joint: revolute, d: L2, start: -1.0}
    twin: {antecedent: 3, d: L3}
";

/// Path of a robot with loops, for example `four_bar`.
pub fn loop_path(name: &str) -> PathBuf {
    workspace().join(format!("tests/data/loops/{name}.yaml"))
}

/// A robot with loops, for example `four_bar`.
pub fn with_loops(name: &str) -> Robot {
    format::read(&loop_path(name)).unwrap_or_else(|e| panic!("{e}"))
}

/// The robot with other values of its symbols. Each value changes by less than `share` of itself.
pub fn resized(robot: &Robot, share: f64, random: &mut Random) -> Robot {
    let mut robot = robot.clone();
    for symbol in &mut robot.symbols {
        if let Value::Number(x) = &mut symbol.value {
            *x *= 1.0 + share * random.unit();
        }
    }
    robot
}
