//! Simulates logs of any robot. The torques are from an independent Newton-Euler recursion. Each joint moves by its own sines.
//!
//! Standard parameters: ten inertial parameters of each link, and rotor inertias. Nominal parameters are those of the
//! description.

use std::path::Path;

use logs::{Effort, Log, LogReport, LogSource};
use rist::Model;
use robot::{Robot, StandardParameter};

use crate::random::{Random, State};
use crate::recursion;

/// Duration of a log, s. `RATE`: sampling rate, Hz.
const DURATION: f64 = 10.0;
const RATE: f64 = 500.0;

/// The robot that a log is simulated for, with its friction, sensor noise and delay.
pub struct Machine<'a> {
    pub robot: &'a Robot,
    /// Values of the standard parameters.
    pub parameters: &'a [f64],
    /// Amplitude of the motion of each coordinate, rad (m).
    pub amplitude: &'a [f64],
    /// Viscous friction of each coordinate, N m s/rad (N s/m). `coulomb`: Coulomb friction, N m (N).
    pub viscous: &'a [f64],
    pub coulomb: &'a [f64],
    /// Standard deviation of white noise on the torques, N m (N). `encoder`: on positions, rad (m). `speed`: on velocities, rad/s
    /// (m/s).
    pub noise: f64,
    pub encoder: f64,
    pub speed: f64,
    /// Delay of the logged torques, s.
    pub delay: f64,
}

/// The signals of a log, one series per coordinate.
#[derive(Clone)]
pub struct JointLog {
    pub t: Vec<f64>,
    pub q: Vec<Vec<f64>>,
    pub dq: Vec<Vec<f64>>,
    pub tau: Vec<Vec<f64>>,
}

/// q, dq, ddq at time t, s. Coordinate k moves with the amplitude `amplitude[k]`.
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

impl<'a> Machine<'a> {
    /// A robot without friction, noise and delay.
    pub fn exact(robot: &'a Robot, parameters: &'a [f64], amplitude: &'a [f64]) -> Machine<'a> {
        let none = &[0.0; 16][..robot.n_coordinates()];
        let (viscous, coulomb) = (none, none);
        Machine { robot, parameters, amplitude, viscous, coulomb, noise: 0.0, encoder: 0.0, speed: 0.0, delay: 0.0 }
    }

    /// Simulates a log of ten seconds.
    pub fn log(&self) -> JointLog {
        let n = self.robot.n_coordinates();
        let mut random = Random(77);
        // The sum of twelve uniform numbers in [-1, 1) has the variance 4, so half of it is approximately standard normal.
        let mut normal = || 0.5 * (0..12).map(|_| random.unit()).sum::<f64>();
        let empty = vec![Vec::new(); n];
        let mut log = JointLog { t: Vec::new(), q: empty.clone(), dq: empty.clone(), tau: empty };
        for i in 0..(DURATION * RATE) as i32 {
            let t = f64::from(i) / RATE;
            let (now, then) = (motion(self.amplitude, t), motion(self.amplitude, t - self.delay));
            let tau = recursion::torque(self.robot, &then, self.parameters);
            log.t.push(t);
            for k in 0..n {
                let friction = self.viscous[k] * then.dq[k] + self.coulomb[k] * then.dq[k].signum();
                log.tau[k].push(tau[k] + friction + self.noise * normal());
            }
            for (of, exact, noise) in [(&mut log.q, &now.q, self.encoder), (&mut log.dq, &now.dq, self.speed)] {
                for (series, exact) in of.iter_mut().zip(exact) {
                    series.push(if noise > 0.0 { exact + noise * normal() } else { *exact });
                }
            }
        }
        log
    }
}

impl JointLog {
    /// Writes the log as CSV: t, then q, dq and tau of each coordinate. Without velocities, dq is omitted.
    pub fn write(&self, path: &Path, names: &[String]) {
        let header = |quantity: &str, series: &[Vec<f64>]| {
            names.iter().zip(series).map(|(name, _)| format!("{quantity}_{name}")).collect::<Vec<_>>()
        };
        let signals = [header("q", &self.q), header("dq", &self.dq), header("tau", &self.tau)].concat();
        let header = [vec!["t".into()], signals].concat().join(",");
        let series: Vec<&Vec<f64>> = std::iter::once(&self.t).chain(&self.q).chain(&self.dq).chain(&self.tau).collect();
        let row = |r: usize| series.iter().map(|x| format!("{:?}", x[r])).collect::<Vec<_>>().join(",");
        let rows: Vec<String> = (0..self.t.len()).map(row).collect();
        std::fs::write(path, format!("{header}\n{}\n", rows.join("\n"))).unwrap_or_else(|e| panic!("{e}"));
    }

    pub fn write_for(&self, model: &Model, path: &Path) {
        self.write(path, model.regressor().coordinates());
    }

    /// Writes the log to a file, and opens this file in the same way as the program.
    pub fn opened(&self, model: &Model, path: &Path) -> LogSource {
        self.write_for(model, path);
        model.open_log(path, &Default::default()).unwrap_or_else(|e| panic!("{e}")).0
    }

    /// The log with only every `rows`-th row.
    pub fn every(&self, rows: usize) -> JointLog {
        let thin = |x: &Vec<f64>| x.iter().step_by(rows).copied().collect::<Vec<f64>>();
        let [q, dq, tau] = [&self.q, &self.dq, &self.tau].map(|series| series.iter().map(thin).collect());
        JointLog { t: thin(&self.t), q, dq, tau }
    }
}

/// A log of the library with these positions, velocities and torques, with a constant sampling period.
pub fn even_log(coordinates: &[String], period: f64, [q, dq, effort]: [Vec<Vec<f64>>; 3]) -> Log {
    let rows = q[0].len();
    Log {
        name: "log".into(),
        coordinates: coordinates.to_vec(),
        t: (0..rows).map(|r| period * r as f64).collect(),
        q,
        dq: Some(dq),
        ddq: None,
        effort,
        effort_is: Effort::Torque,
        rows: (1..=rows).collect(),
        window: None,
        report: LogReport::uniform(rows, period),
    }
}

/// The model of the UR5 in models/, and a log of a UR5 with other parameters.
pub fn ur5() -> (Model, JointLog) {
    let model = Model::read(crate::model_path("ur5.urdf")).unwrap_or_else(|e| panic!("{e}"));
    let log = swinging(&model.robot, &unlike(&model.robot, 5), 1.2, 0.0);
    (model, log)
}

/// Writes a log of the robot with the standard parameters `x`. `noise`: standard deviation of the torques, N m (N).
pub fn write(path: &Path, robot: &Robot, x: &[f64], amplitude: &[f64], noise: f64) {
    write_measured(path, robot, x, amplitude, noise, 0.0);
}

/// Writes a log like [`write()`], with white noise on the positions. `encoder`: standard deviation of this noise, rad (m).
pub fn write_measured(path: &Path, robot: &Robot, x: &[f64], amplitude: &[f64], noise: f64, encoder: f64) {
    let machine = Machine { noise, encoder, ..Machine::exact(robot, x, amplitude) };
    let names: Vec<String> = robot.coordinates.iter().map(|c| c.name.clone()).collect();
    machine.log().write(path, &names);
}

/// The nominal standard parameters of a robot. Unknown ones are zero.
pub fn described(robot: &Robot) -> Vec<f64> {
    StandardParameter::all(robot).iter().map(|p| p.value(robot).unwrap_or(0.0)).collect()
}

/// Standard parameters that differ from the nominal ones by up to 15 % each.
pub fn unlike(robot: &Robot, seed: u64) -> Vec<f64> {
    let mut random = Random(seed);
    described(robot).iter().map(|x| x * (1.0 + 0.15 * random.unit())).collect()
}

/// The log of a robot with friction and noise. Each joint moves with `amplitude`, rad. The torques are logged with a delay of
/// `delay` s.
pub fn swinging(robot: &Robot, x: &[f64], amplitude: f64, delay: f64) -> JointLog {
    swinging_by(robot, x, &vec![amplitude; robot.n_coordinates()], delay)
}

/// A log like [`swinging`], with a separate amplitude for each joint, rad (m).
pub fn swinging_by(robot: &Robot, x: &[f64], amplitude: &[f64], delay: f64) -> JointLog {
    let n = robot.n_coordinates();
    let share = |k: usize| (1.0 - k as f64 / n as f64).powi(2) + 0.05;
    let viscous: Vec<f64> = (0..n).map(|k| 5.0 * share(k)).collect();
    let coulomb: Vec<f64> = (0..n).map(|k| 4.0 * share(k)).collect();
    let (viscous, coulomb) = (&viscous, &coulomb);
    Machine { viscous, coulomb, noise: 0.1, speed: 1e-3, delay, ..Machine::exact(robot, x, amplitude) }.log()
}
