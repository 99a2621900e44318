//! Simulates the log of a machine, with or without a mistake.
//!
//! The machine is the true robot. Mistakes of the machine (a spring, a load, a contact) act on the torques here; mistakes in
//! the columns are added later (`wrong_columns`).

use std::f64::consts::TAU;

use super::arms::Arm;
use super::kinds::{Kind, Mistake};
use super::machine::Machine;
use super::wrong_columns::spoil;
use crate::joint_log::{JointLog, described};
use crate::random::State;
use crate::random_situations::draw::Draw;
use crate::random_situations::motion::Motion;
use crate::recursion;

/// Sampling rate, Hz.
const RATE: f64 = 250.0;

#[derive(Clone, Copy)]
pub struct Simulation<'a> {
    pub arm: &'a Arm,
    pub machine: &'a Machine,
    pub motion: &'a Motion,
    /// The mistake; `None`: there is none.
    pub mistake: Option<Mistake>,
}

impl Simulation<'_> {
    /// Simulates the log. `draw`: random generator for the sensor noise.
    pub fn log(&self, draw: &mut Draw) -> JointLog {
        let n = self.arm.n();
        let kind = self.mistake.map(|m| m.kind);
        let base = match kind {
            Some(Kind::Base(base)) => Some(base),
            _ => None,
        };
        let robot = self.arm.mounted(base);
        let nominal = described(&robot);
        let delay = if let Some(Kind::Late(ms)) = kind { 1e-3 * ms } else { 0.0 };
        let empty = vec![Vec::new(); n];
        let mut log = JointLog { t: Vec::new(), q: empty.clone(), dq: empty.clone(), tau: empty };
        for i in 0..(self.motion.duration * RATE).round() as u32 {
            let t = f64::from(i) / RATE;
            let (now, then) = (self.motion.at(t), self.motion.at(t - delay));
            let tau = match kind {
                Some(Kind::Computed) => recursion::torque(&robot, &now, &nominal),
                _ => self.machine.torque(&robot, &then, self.bodies(t - delay)),
            };
            log.t.push(t);
            for k in 0..n {
                log.q[k].push(now.q[k]);
                log.dq[k].push(now.dq[k]);
                log.tau[k].push(tau[k]);
            }
            if kind == Some(Kind::GravityOut) {
                let still = State { q: then.q, dq: vec![0.0; n], ddq: vec![0.0; n] };
                let holding = recursion::torque(&robot, &still, self.bodies(t));
                log.tau.iter_mut().zip(holding).for_each(|(tau, g)| tau[i as usize] -= g);
            }
        }
        self.forces(&mut log);
        if kind != Some(Kind::Computed) {
            self.measure(&mut log, draw);
        }
        if let Some(mistake) = &self.mistake {
            spoil(self.arm, mistake, &mut log);
        }
        let needs_speeds = matches!(kind, Some(Kind::SwappedVelocities | Kind::FilteredVelocities(_)));
        if !self.machine.sensors.speeds && !needs_speeds {
            log.dq.clear();
        }
        log
    }

    /// The stiffness of the spring if the mistake is a spring, N m/rad (N/m); otherwise `None`. The spring torque at the largest
    /// joint position is half of the rms torque.
    pub fn stiffness(&self, log: &JointLog) -> Option<f64> {
        let mistake = self.mistake.filter(|m| m.kind == Kind::Spring)?;
        let farthest = log.q[mistake.a].iter().fold(0.0, |m: f64, q| m.max(q.abs()));
        Some(0.5 * self.machine.size[mistake.a] / farthest)
    }

    /// The parameters of bodies and rotors at time t, s.
    fn bodies(&self, t: f64) -> &[f64] {
        match self.mistake.map(|m| m.kind) {
            Some(Kind::Payload) => &self.machine.loaded,
            Some(Kind::LoadPickedUp) if t > 0.5 * self.motion.duration => &self.machine.loaded,
            _ => &self.machine.parameters,
        }
    }

    /// Adds the joint torques that the mistake causes (spring, contact, ..) to the torques of bodies and friction.
    fn forces(&self, log: &mut JointLog) {
        let Some(Mistake { kind, a, more, .. }) = self.mistake else { return };
        if let Some(stiffness) = self.stiffness(log) {
            let JointLog { q, tau, .. } = log;
            tau[a].iter_mut().zip(&q[a]).for_each(|(tau, q)| *tau += stiffness * q);
        }
        if kind == Kind::Contact {
            let begin = (0.1 + 0.7 * more) * self.motion.duration;
            let during = log.t.iter().map(|t| *t >= begin && *t < begin + 1.0);
            let push = 0.3 * self.machine.size[a];
            log.tau[a].iter_mut().zip(during).filter(|(_, during)| *during).for_each(|(tau, _)| *tau += push);
        }
    }

    /// Adds the errors of the sensors to a log.
    fn measure(&self, log: &mut JointLog, draw: &mut Draw) {
        let Machine { sensors, size, offset, .. } = self.machine;
        for k in 0..self.arm.n() {
            let turn = if self.arm.slides(k) { 0.1 } else { TAU };
            let count = turn / 2f64.powi(sensors.bits);
            log.q[k].iter_mut().for_each(|q| *q = (*q / count).round() * count);
            let peak = log.dq[k].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            log.dq[k].iter_mut().for_each(|dq| *dq += 1e-3 * peak * draw.normal());
            log.tau[k].iter_mut().for_each(|tau| *tau += offset[k] + sensors.noise * size[k] * draw.normal());
        }
    }
}
