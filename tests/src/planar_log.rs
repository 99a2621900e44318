//! Simulates logs of an arm with two joints in a vertical plane. The torques are from an independent Newton-Euler recursion.
//!
//! The log is a list of text lines in CSV: time, then positions, velocities and torques.

use std::path::Path;

use robot::Robot;

use crate::random::{Random, State};
use crate::recursion;

/// q, dq, ddq of a smooth motion of both joints at time t, s.
fn motion(t: f64) -> State {
    let sines = [[(0.9, 1.7), (0.3, 4.1)], [(0.8, 2.3), (0.4, 3.1)]];
    let sum = |f: &dyn Fn(f64, f64) -> f64| sines.iter().map(|s| s.iter().map(|&(a, w)| f(a, w)).sum()).collect();
    State {
        q: sum(&|a, w| a * (w * t).sin()),
        dq: sum(&|a, w| a * w * (w * t).cos()),
        ddq: sum(&|a, w| -a * w * w * (w * t).sin()),
    }
}

pub const HEADER: &str = "t,q1,q2,dq1,dq2,tau1,tau2";

/// A log of 6 s at 1 kHz of an arm with two links, without noise and friction, as lines. `x`: standard parameters.
pub fn log(robot: &Robot, x: &[f64]) -> Vec<String> {
    log_of(robot, x, &|_, _, tau| tau)
}

/// A log as from [`log`], with other torques. `measured(j, dq, tau)`: the logged torque of joint j at the velocity dq, if tau is
/// the true torque.
pub fn log_of(robot: &Robot, x: &[f64], measured: &dyn Fn(usize, f64, f64) -> f64) -> Vec<String> {
    (0..6000)
        .map(|k| {
            let t = f64::from(k) * 1e-3;
            let state = motion(t);
            let tau = recursion::torque(robot, &state, x);
            let tau: Vec<f64> = (0..2).map(|j| measured(j, state.dq[j], tau[j])).collect();
            let cells = [&[t], &state.q[..], &state.dq, &tau].concat();
            cells.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(",")
        })
        .collect()
}

/// Writes a log of the arm in planar2r_vertical.yaml with viscous and Coulomb friction. Returns the path of a description of this
/// arm without inertial parameters.
pub fn write_rubbed(path: &Path, viscous: f64) -> String {
    let robot = crate::model("planar2r_vertical.yaml");
    let rubbed = |_: usize, dq: f64, tau: f64| tau + viscous * dq + 0.3 * dq.signum();
    let rows = log_of(&robot, &Random(41).physical_parameters(&robot), &rubbed);
    std::fs::write(path, format!("{HEADER}\n{}\n", rows.join("\n"))).unwrap_or_else(|e| panic!("{e}"));
    crate::test_robot_path("planar2r_vertical.yaml").display().to_string()
}

pub fn write_log(folder: &Path, rows: &[String]) {
    std::fs::write(folder.join("log.csv"), format!("{HEADER}\n{}\n", rows.join("\n"))).unwrap();
}
