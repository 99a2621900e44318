//! Logs of any robot, from the independent recursion: every joint on sines of its own.

use std::path::Path;

use robot::Robot;

use crate::random::{Random, State};
use crate::recursion;

/// Seconds and rows a second of a log.
const DURATION: f64 = 10.0;
const RATE: f64 = 500.0;

/// q, dq, ddq of coordinates that swing by `amplitude[k]`, at t in s.
fn motion(amplitude: &[f64], t: f64) -> State {
    let sum = |f: &dyn Fn(f64, f64) -> f64| {
        let sines = |k: usize| [(0.7, 0.9 + 0.31 * k as f64), (0.3, 2.7 + 0.43 * k as f64)];
        let of = |(k, a): (usize, &f64)| sines(k).iter().map(|&(share, w)| f(a * share, w)).sum();
        amplitude.iter().enumerate().map(of).collect()
    };
    State {
        q: sum(&|a, w| a * (w * t).sin()),
        dq: sum(&|a, w| a * w * (w * t).cos()),
        ddq: sum(&|a, w| -a * w * w * (w * t).sin()),
    }
}

/// Writes a log of the robot with the standard parameters `x`, torques with white noise of `noise` N m (N).
pub fn write(path: &Path, robot: &Robot, x: &[f64], amplitude: &[f64], noise: f64) {
    write_measured(path, robot, x, amplitude, noise, 0.0);
}

/// The same with white noise of `encoder` rad (m) on the positions.
pub fn write_measured(path: &Path, robot: &Robot, x: &[f64], amplitude: &[f64], noise: f64, encoder: f64) {
    let names = |quantity: &str| robot.coordinates.iter().map(|c| format!("{quantity}_{}", c.name)).collect::<Vec<_>>();
    let header = [vec!["t".into()], names("q"), names("dq"), names("tau")].concat().join(",");
    let mut random = Random(77);
    // Twelve uniform numbers have the variance of four: half of their sum is a normal number.
    let mut normal = || 0.5 * (0..12).map(|_| random.unit()).sum::<f64>();
    let row = |i: i32| {
        let t = f64::from(i) / RATE;
        let state = motion(amplitude, t);
        let tau: Vec<f64> = recursion::torque(robot, &state, x).iter().map(|tau| tau + noise * normal()).collect();
        let seen = |q: &f64| if encoder > 0.0 { q + encoder * normal() } else { *q };
        let q: Vec<f64> = state.q.iter().map(seen).collect();
        let cells = [&[t], &q[..], &state.dq, &tau].concat();
        cells.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = (0..(DURATION * RATE) as i32).map(row).collect();
    std::fs::write(path, format!("{header}\n{}\n", rows.join("\n"))).unwrap_or_else(|e| panic!("{e}"));
}
