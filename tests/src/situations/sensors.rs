//! What a log holds of a machine: noise, clocks, quantised encoders, and mistakes.

use std::fmt;

use robot::Robot;

use crate::joint_log::JointLog;
use crate::random::{Random, State};
use crate::situations::machine::Machine;
use crate::situations::motion::Motion;
use crate::situations::{log_between, normal};

/// Rows per second.
const RATE: f64 = 200.0;

/// Sensors and their clock.
pub struct Sensors {
    /// Of torque, relative to its size.
    noise: f64,
    /// rad.
    encoder: f64,
    has_velocity: bool,
    /// s.
    delay: f64,
    /// Cut-off of the velocity, Hz; 0: none.
    velocity_cutoff: f64,
    jitter: f64,
    lost: f64,
    /// Largest torque, relative to its size; 0: none.
    saturation: f64,
    /// Step of the torque, relative to its size.
    torque_step: f64,
    pub fault: Fault,
}

/// A gross mistake.
#[derive(Clone, Copy, PartialEq)]
pub enum Fault {
    None,
    /// All torques times so many.
    Scale(f64),
    /// The torque of a joint times so many.
    JointScale(usize, f64),
    /// The zero of a joint off by so many rad.
    Zero(usize, f64),
    /// The base tilted by so many rad.
    Tilt(f64),
    TorqueSign(usize),
    Reversed(usize),
    Swapped(usize, usize),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Fault::None => write!(f, "no fault"),
            Fault::Scale(x) => write!(f, "FAULT all torques x {x:.2}"),
            Fault::JointScale(k, x) => write!(f, "FAULT torque {} x {x:.2}", k + 1),
            Fault::Zero(k, x) => write!(f, "FAULT zero {} off {:.1} deg", k + 1, x.to_degrees()),
            Fault::Tilt(x) => write!(f, "FAULT tilted {:.1} deg", x.to_degrees()),
            Fault::TorqueSign(k) => write!(f, "FAULT sign of torque {}", k + 1),
            Fault::Reversed(k) => write!(f, "FAULT joint {} reversed", k + 1),
            Fault::Swapped(k, l) => write!(f, "FAULT {} and {} swapped", k + 1, l + 1),
        }
    }
}

impl Fault {
    pub fn random(robot: &Robot, random: &mut Random) -> Fault {
        let n = robot.n_coordinates();
        let k = random.below(n);
        let sign = random.unit().signum();
        match random.below(7) {
            0 => Fault::Scale(if sign > 0.0 { log_between(random, 1.5, 3.0) } else { log_between(random, 0.3, 0.66) }),
            1 => Fault::JointScale(
                k,
                if sign > 0.0 { log_between(random, 1.1, 2.0) } else { log_between(random, 0.5, 0.9) },
            ),
            2 => Fault::Zero(k, sign * log_between(random, 0.05, 1.6)),
            3 => Fault::Tilt(sign * log_between(random, 0.05, 1.6)),
            4 => Fault::TorqueSign(k),
            5 => Fault::Reversed(k),
            _ => Fault::Swapped(k, (k + 1) % n),
        }
    }
}

impl Sensors {
    pub fn random(_: &Robot, random: &mut Random) -> Sensors {
        Sensors {
            noise: log_between(random, 0.001, 0.025),
            encoder: log_between(random, 2e-6, 2e-4),
            has_velocity: random.below(2) == 0,
            delay: 0.0,
            velocity_cutoff: 0.0,
            jitter: 0.0,
            lost: 0.0,
            saturation: 0.0,
            torque_step: 0.0,
            fault: Fault::None,
        }
    }

    /// One defect; returns it in words.
    pub fn defect(&mut self, which: usize, random: &mut Random) -> String {
        match which {
            0 => {
                self.delay = log_between(random, 0.0005, 0.02);
                format!("late {:.1} ms", 1e3 * self.delay)
            }
            1 => {
                (self.velocity_cutoff, self.has_velocity) = (log_between(random, 3.0, 40.0), true);
                format!("velocity behind {:.0} Hz", self.velocity_cutoff)
            }
            2 => {
                self.jitter = log_between(random, 5e-5, 6e-4);
                "jitter".into()
            }
            3 => {
                self.lost = log_between(random, 0.02, 0.3);
                "lost rows".into()
            }
            4 => {
                self.saturation = 0.9 + 0.6 * (1.0 + random.unit());
                "saturation".into()
            }
            5 => {
                self.torque_step = log_between(random, 0.005, 0.05);
                "coarse torque".into()
            }
            _ => {
                self.encoder = log_between(random, 3e-4, 2e-3);
                "coarse encoder".into()
            }
        }
    }

    /// The log of a motion; `faulty`: with the gross mistake.
    pub fn log(&self, machine: &Machine, motion: &Motion, faulty: bool, random: &mut Random) -> JointLog {
        let fault = if faulty { self.fault } else { Fault::None };
        let mut tilted = machine.clone();
        if let Fault::Tilt(by) = fault {
            let [x, y, z] = machine.robot.gravity_number();
            let turned = [x, y * by.cos() - z * by.sin(), z * by.cos() + y * by.sin()];
            tilted.robot.gravity = turned.map(robot::value::Value::Number);
        }
        let machine = &tilted;
        let n = machine.size.len();
        let none = || vec![Vec::new(); n];
        let mut log = JointLog { t: Vec::new(), q: none(), dq: none(), tau: none() };
        let (mut slow, mut behind) = (vec![0.0; n], motion.at(0.0).dq);
        for i in 0..(motion.duration * RATE) as usize {
            let t = i as f64 / RATE;
            let now: State = motion.at(t + self.jitter * normal(random));
            let then = motion.at(t - self.delay);
            slow.iter_mut().for_each(|s| *s += -*s / (0.5 * RATE) + (2.0 / (0.5 * RATE)).sqrt() * normal(random));
            let torques = machine.torques(&then, t / motion.duration, &slow);
            let gain = 1.0 - (-std::f64::consts::TAU * self.velocity_cutoff / RATE).exp();
            for k in 0..n {
                behind[k] += if self.velocity_cutoff > 0.0 { gain } else { 1.0 } * (now.dq[k] - behind[k]);
            }
            if 0.5 * (1.0 + random.unit()) < self.lost {
                continue;
            }
            log.t.push(t);
            for k in 0..n {
                let size = machine.size[k];
                let mut torque = torques[k] + self.noise * size * normal(random);
                if self.saturation > 0.0 {
                    torque = torque.clamp(-self.saturation * size, self.saturation * size);
                }
                if self.torque_step > 0.0 {
                    torque = (torque / (self.torque_step * size)).round() * self.torque_step * size;
                }
                log.tau[k].push(torque);
                log.q[k].push((now.q[k] / self.encoder).round() * self.encoder);
                log.dq[k].push(behind[k] + 1e-3 * normal(random));
            }
        }
        let times = |series: &mut Vec<f64>, x: f64| series.iter_mut().for_each(|v| *v *= x);
        match fault {
            Fault::None | Fault::Tilt(_) => {}
            Fault::Scale(x) => log.tau.iter_mut().for_each(|tau| times(tau, x)),
            Fault::JointScale(k, x) => times(&mut log.tau[k], x),
            Fault::Zero(k, by) => log.q[k].iter_mut().for_each(|q| *q += by),
            Fault::TorqueSign(k) => times(&mut log.tau[k], -1.0),
            Fault::Reversed(k) => {
                [&mut log.q[k], &mut log.dq[k], &mut log.tau[k]].into_iter().for_each(|x| times(x, -1.0))
            }
            Fault::Swapped(k, l) => [&mut log.q, &mut log.dq, &mut log.tau].into_iter().for_each(|x| x.swap(k, l)),
        }
        if !self.has_velocity {
            log.dq.clear();
        }
        log
    }
}
