//! Computes the motor torques of a machine (the true robot) for a motion, on a fine time grid.
//!
//! The links follow the motion exactly. The motor of a flexible joint is at theta = q + tau / K. Its speed and acceleration
//! follow from tau by central differences. The stiffness K follows from the frequency at which the link oscillates if the motor
//! is blocked.
//!
//! Friction may have bristles (Dahl's law) with the deflection z, at most z_s. The deflection is integrated exactly for the
//! constant speed v during a step h: z -> z_s sign(v) + (z - z_s sign(v)) exp(-|v| h / z_s).

use super::chain::Chain;
use super::defects::{Defect, Kind};
use super::motion::Motion;
use super::robots::{Friction, Machine};

/// Number of steps of the time grid per second.
pub const FINE: f64 = 1000.0;

/// All signals of a motion on the time grid, one series per joint.
pub struct Series {
    /// Positions q of the links and theta of the motors, rad (m), with their derivatives.
    pub q: Vec<Vec<f64>>,
    pub dq: Vec<Vec<f64>>,
    pub ddq: Vec<Vec<f64>>,
    pub theta: Vec<Vec<f64>>,
    pub dtheta: Vec<Vec<f64>>,
    /// Torques of the motors, N m (N).
    pub tau: Vec<Vec<f64>>,
    /// The part of `tau` for bodies and rotors: without friction, springs and ripple.
    pub rigid: Vec<Vec<f64>>,
}

impl Series {
    pub fn steps(&self) -> usize {
        self.q[0].len()
    }
}

/// The machine as it is mounted and loaded: with its tilted base if it has this defect, and with its load if `loaded`.
pub fn standing(machine: &Machine, defects: &[Defect], loaded: bool) -> Chain {
    let mut chain = machine.chain.clone();
    for defect in defects {
        match defect.kind {
            Kind::Tilt => chain.gravity = defect.tilted(chain.gravity),
            Kind::Payload if loaded => {
                let mass = defect.size * chain.joints.last().map_or(0.0, |j| j.body.mass);
                chain = chain.loaded(mass, [0.05 * defect.more, -0.03, 0.1]);
            }
            _ => {}
        }
    }
    chain
}

pub fn series(machine: &Machine, chain: &Chain, motion: &Motion, defects: &[Defect]) -> Series {
    let (n, h) = (chain.len(), 1.0 / FINE);
    let steps = (motion.duration / h).floor() as usize + 1;
    let empty = || vec![Vec::with_capacity(steps); n];
    let (mut q, mut dq, mut ddq, mut link) = (empty(), empty(), empty(), empty());
    for i in 0..steps {
        let now = motion.at(i as f64 * h);
        let tau = chain.torque(&now.q, &now.dq, &now.ddq);
        for k in 0..n {
            q[k].push(now.q[k]);
            dq[k].push(now.dq[k]);
            ddq[k].push(now.ddq[k]);
            link[k].push(tau[k]);
        }
    }
    let own = chain.own_inertia(&vec![0.3; n]);
    let (mut theta, mut dtheta, mut tau, mut rigid) = (q.clone(), dq.clone(), empty(), empty());
    for k in 0..n {
        let of = |kind: Kind| defects.iter().find(|d| d.kind == kind && d.joint == k);
        let rotor = chain.joints[k].rotor;
        rigid[k] = (0..steps).map(|i| link[k][i] + rotor * ddq[k][i]).collect();
        let mut carried = link[k].clone();
        if let Some(spring) = of(Kind::Spring) {
            let stiffness = spring.size * machine.size[k] / chain.joints[k].range;
            let rest = (spring.more - 0.5) * chain.joints[k].range;
            carried.iter_mut().zip(&q[k]).for_each(|(tau, q)| *tau += stiffness * (q - rest));
        }
        let mut ddtheta = ddq[k].clone();
        if let Some(flexible) = of(Kind::Flexible) {
            let stiffness = own[k].max(1e-4) * (std::f64::consts::TAU * flexible.size).powi(2);
            let bend: Vec<f64> = carried.iter().map(|tau| tau / stiffness).collect();
            let (rate, curve) = derivatives(&bend, h);
            for i in 0..steps {
                theta[k][i] += bend[i];
                dtheta[k][i] += rate[i];
                ddtheta[i] += curve[i];
            }
        }
        let friction = friction(machine, defects, k, &dtheta[k], &carried, h);
        let ripple = of(Kind::TorqueRipple);
        tau[k] = (0..steps)
            .map(|i| {
                let wave = ripple.map_or(0.0, |r| ripple_torque(r, machine.size[k], theta[k][i]));
                carried[i] + rotor * ddtheta[i] + friction[i] + wave
            })
            .collect();
    }
    Series { q, dq, ddq, theta, dtheta, tau, rigid }
}

/// The torque ripple at the motor position `theta`. It has 1 to 60 periods per turn (per metre).
fn ripple_torque(defect: &Defect, size: f64, theta: f64) -> f64 {
    let periods = (60f64.powf(defect.more)).round();
    defect.size * size * (periods * theta + 6.0 * defect.more).sin()
}

/// First and second derivatives by central differences. At both ends, the value of the neighbouring sample is used.
fn derivatives(x: &[f64], h: f64) -> (Vec<f64>, Vec<f64>) {
    let last = x.len() - 1;
    let inside = |i: usize| i.clamp(1, last - 1);
    let rate = |i: usize| (x[inside(i) + 1] - x[inside(i) - 1]) / (2.0 * h);
    let curve = |i: usize| (x[inside(i) + 1] - 2.0 * x[inside(i)] + x[inside(i) - 1]) / (h * h);
    ((0..=last).map(rate).collect(), (0..=last).map(curve).collect())
}

/// Friction torque of joint k for a series of speeds and load torques. `h`: time step, s.
fn friction(machine: &Machine, defects: &[Defect], k: usize, speed: &[f64], load: &[f64], h: f64) -> Vec<f64> {
    let Friction { viscous, coulomb, offset } = machine.friction[k];
    let joint = &machine.chain.joints[k];
    // A friction defect concerns all joints, because they have the same construction.
    let of = |kind: Kind| defects.iter().find(|d| d.kind == kind);
    let mut z = 0.0;
    let law = |i: usize| {
        let v = speed[i];
        let mut dry = coulomb;
        if let Some(stribeck) = of(Kind::Stribeck) {
            let width = (0.02 + 0.1 * stribeck.more) * joint.speed;
            dry *= 1.0 + stribeck.size * (-(v / width).powi(2)).exp();
        }
        if let Some(loaded) = of(Kind::LoadFriction) {
            dry += loaded.size * load[i].abs();
        }
        let mut wet = viscous * v;
        if let Some(side) = of(Kind::Asymmetric) {
            wet *= 1.0 + side.size * v.signum();
        }
        let direction = match of(Kind::Bristle) {
            Some(bristle) => {
                let full = bristle.size * joint.range;
                let end = full * v.signum();
                z = end + (z - end) * (-v.abs() * h / full).exp();
                z / full
            }
            None if v == 0.0 => 0.0,
            None => v.signum(),
        };
        wet + dry * direction + offset
    };
    (0..speed.len()).map(law).collect()
}
