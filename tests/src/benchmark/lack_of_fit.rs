//! Simulates logs of a UR5 with known true parameters. The robot differs from the fitted model in one effect.
//!
//! The robot repeats a motion with five harmonics of 0.1 Hz three times. The fitted model has viscous and Coulomb friction and an
//! offset; the true robot differs from it by an effect of [`Truth`]. Encoder noise is 2e-5 rad with steps of 1e-5 rad; velocity
//! noise is 2e-3 rad/s; torque noise is 0.02 N m and 0.5 % of the rms torque.
//!
//! If friction depends on more than the sign of the velocity, a joint sticks when it reverses. Then the robot is simulated in
//! closed loop, with the controller
//!
//! u = A_n (ddq_r + Kp (q_r - q) + Kd (dq_r - dq)) + h_n + friction at the reference velocity.
//!
//! u is constant for 1 ms. A_n, h_n: inertia matrix and bias torque of a robot whose links are wrong by 10 %; index r: reference.
//! The torque of a row is the mean of the torques before and after it. In all other cases the motion equals the reference, and
//! the torque is from inverse dynamics.

use std::f64::consts::{PI, TAU};

use experiments::simulate::dynamics::Dynamics;
use linear_model::friction::terms::sign;
use linear_model::regressor::Regressor;
use logs::Log;
use nalgebra::{Cholesky, Const, SMatrix, SVector};
use random::Random;
use robot::RotorInertia;

use crate::joint_log::even_log;
use crate::tape_robot::TapeRobot;

/// The effect that the true robot or its sensors have, and the fitted model does not contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// No effect: the model is exact except for white noise.
    WhiteNoise,
    /// Torque noise that is correlated over 0.3 s, with the same rms as the additional white noise.
    SlowNoise,
    /// Coulomb friction that does not jump at zero velocity: it changes its sign within 0.005 rad/s.
    Tanh,
    /// Coulomb friction without a jump, as `Tanh`, that is 30 % larger below 0.1 rad/s (Stribeck effect).
    Stribeck,
    /// Dahl friction: an elastic bristle in the contact that slides after a deflection of 2 mrad.
    Dahl,
    /// LuGre friction: an elastic bristle in the contact that slides after 1 mrad, with the Stribeck effect and with damping.
    LuGre,
    /// Torque ripple of 2 % of the rms torque, with 50 and more periods per turn.
    Ripple,
    /// Backlash of 1 mrad between the motor, which has the encoder, and the link.
    Backlash,
    /// The torques are logged with this delay, ms.
    Late(u32),
    /// The velocity is filtered by a first-order low-pass with this cut-off, Hz.
    LaggingVelocity(u32),
    /// Torque ripple of 2 % of the rms torque, with this number of periods per turn.
    RippleOf(u32),
    /// Flexible joints: the deflection behind the encoder is 10 mrad at the largest torque.
    Bends,
    /// Friction grows with the load, by a tenth of the load torque.
    LoadFriction,
    /// The measured torque of each joint contains 3 % of the torque of the next joint.
    CrossTalk,
    /// A flexible base with a stiffness of 2e4 N m/rad.
    Yields,
    /// A spring of 7.5 N m/rad at the second joint.
    Spring,
    /// Encoders with twelve bits.
    TwelveBits,
    /// The sampling times of the rows have an rms error of 0.2 ms.
    Jitter,
}

impl Truth {
    pub const ALL: [Truth; 23] = [
        Truth::WhiteNoise,
        Truth::SlowNoise,
        Truth::Tanh,
        Truth::Stribeck,
        Truth::Dahl,
        Truth::LuGre,
        Truth::Ripple,
        Truth::Backlash,
        Truth::Late(1),
        Truth::Late(4),
        Truth::Late(10),
        Truth::LaggingVelocity(30),
        Truth::LaggingVelocity(10),
        Truth::LaggingVelocity(3),
        Truth::RippleOf(1),
        Truth::RippleOf(7),
        Truth::Bends,
        Truth::LoadFriction,
        Truth::CrossTalk,
        Truth::Yields,
        Truth::Spring,
        Truth::TwelveBits,
        Truth::Jitter,
    ];

    /// Whether friction makes a joint stick when it reverses. Then the robot is simulated in closed loop.
    fn sticks(self) -> bool {
        matches!(self, Truth::Tanh | Truth::Stribeck | Truth::Dahl | Truth::LuGre)
    }
}

/// Viscous friction of each joint, N m/(rad/s). `COULOMB`: Coulomb friction, N m. `OFFSET`: torque offset, N m. `ROTOR`: rotor
/// inertia, kg m^2.
const VISCOUS: [f64; 6] = [9.1, 6.4, 8.3, 1.9, 1.2, 1.6];
const COULOMB: [f64; 6] = [5.2, 7.4, 6.6, 0.8, 1.3, 1.1];
const OFFSET: [f64; 6] = [0.3, -0.4, 0.1, 0.05, -0.08, 0.02];
const ROTOR: [f64; 6] = [1.2, 0.9, 0.7, 0.2, 0.15, 0.22];

/// Time between rows of the log, s. `HELD`: controller samples per row. `STEPS`: simulation steps per controller sample.
const PERIOD: f64 = 2e-3;
const HELD: usize = 2;
const STEPS: usize = 4;

/// Period of the motion, s. `REPEATED`: number of periods.
const MOTION: f64 = 10.0;
const REPEATED: usize = 3;

/// The true robot with rotor inertias, and the nominal robot with wrong links that the controller uses.
pub struct LackOfFit {
    pub robot: TapeRobot,
    nominal: TapeRobot,
}

impl Default for LackOfFit {
    /// The UR5 of models/ with rotor inertias.
    fn default() -> LackOfFit {
        let mut robot = crate::model("ur5.yaml");
        for (link, rotor) in robot.links.iter_mut().zip(ROTOR) {
            link.joint.rotor_inertia = RotorInertia::Known(rotor);
        }
        let robot = TapeRobot::new(robot);
        let nominal = robot.with_scaled_links(&[1.1, 0.9, 1.1, 0.9, 1.1, 0.9]);
        LackOfFit { robot, nominal }
    }
}

impl LackOfFit {
    /// The true parameters, in the order of the columns: base parameters, then viscous friction, Coulomb friction and offset of
    /// each joint.
    pub fn truth(&self) -> Vec<f64> {
        let friction = (0..6).flat_map(|k| [VISCOUS[k], COULOMB[k], OFFSET[k]]);
        self.robot.truth.iter().copied().chain(friction).collect()
    }

    /// The log of one draw, with the effect `truth`. Each draw has its own motion and noise.
    pub fn log(&self, truth: Truth, draw: u64) -> Log {
        let random = &mut Random::stream(1414, draw);
        let motion = FourierMotion::random(random);
        let mut clean = if truth.sticks() { self.closed_loop(&motion, truth) } else { self.prescribed(&motion, truth) };
        match truth {
            Truth::Ripple => add_ripple(&mut clean, random, |k| 50.0 + 7.0 * k as f64),
            Truth::RippleOf(times) => add_ripple(&mut clean, random, |_| f64::from(times)),
            Truth::Backlash => add_backlash(&mut clean),
            _ => clean.sense(truth, random),
        }
        measured(&clean, truth, self.robot.coordinates(), random)
    }

    /// The noise-free signals if the motion equals the reference, with Coulomb friction that jumps at zero velocity.
    fn prescribed(&self, motion: &FourierMotion, truth: Truth) -> Clean {
        let mut clean = Clean::new();
        let base = self.robot.truth.len();
        let mut y = vec![0.0; 6 * base];
        for i in 0..rows() {
            let [q, dq, ddq] = motion.at(i as f64 * PERIOD);
            // The logged torque is the mean over the time of a row. So the sign of the velocity is averaged over this time.
            const PARTS: usize = 16;
            let parts =
                (0..PARTS).map(|part| motion.at((i as f64 + (part as f64 + 0.5) / PARTS as f64 - 0.5) * PERIOD)[1]);
            let direction = parts.fold([0.0; 6], |sum, v| std::array::from_fn(|k| sum[k] + sign(v[k]) / PARTS as f64));
            Regressor::fill(&self.robot, &q, &dq, &ddq, &mut y);
            let torque = |k: usize| {
                let rigid: f64 = y[k * base..][..base].iter().zip(&self.robot.truth).map(|(y, x)| y * x).sum();
                let load = if truth == Truth::LoadFriction { 0.1 * rigid.abs() } else { 0.0 };
                let spring = if truth == Truth::Spring && k == 1 { 7.5 * q[k] } else { 0.0 };
                rigid + VISCOUS[k] * dq[k] + (COULOMB[k] + load) * direction[k] + OFFSET[k] + spring
            };
            clean.push(&q, &dq, &std::array::from_fn(torque));
        }
        clean
    }

    /// The noise-free signals in closed loop.
    fn closed_loop(&self, motion: &FourierMotion, truth: Truth) -> Clean {
        let (mut clean, mut bristle) = (Clean::new(), [0.0; 6]);
        let [mut q, mut dq, mut ddq] = motion.at(0.0);
        let mut before = None;
        let held = PERIOD / HELD as f64;
        let h = held / STEPS as f64;
        for i in 0..rows() * HELD {
            let [qr, dqr, ddqr] = motion.at(i as f64 * held);
            let asked: [f64; 6] = std::array::from_fn(|k| ddqr[k] + 400.0 * (qr[k] - q[k]) + 40.0 * (dqr[k] - dq[k]));
            let (a, bias) = dynamics(&self.nominal, &q, &dq);
            let friction = |k: usize| VISCOUS[k] * dqr[k] + COULOMB[k] * (dqr[k] / 0.05).tanh();
            let u: [f64; 6] =
                std::array::from_fn(|k| (0..6).map(|c| a[6 * k + c] * asked[c]).sum::<f64>() + bias[k] + friction(k));
            if i % HELD == 0 {
                let mean = before.map_or(u, |b: [f64; 6]| std::array::from_fn(|k| 0.5 * (b[k] + u[k])));
                clean.push(&q, &dq, &mean);
            }
            before = Some(u);
            // During a controller sample, inertia and bias torque are constant, with their values at the middle of the interval.
            // Only friction changes within the interval.
            let middle = |x: &[f64; 6], dx: &[f64; 6]| std::array::from_fn(|k| x[k] + 0.5 * held * dx[k]);
            let held = Held::new(&self.robot, &middle(&q, &dq), &middle(&dq, &ddq), u);
            let start = dq;
            for _ in 0..STEPS {
                // The midpoint rule. The bristle of the friction model is integrated exactly, with constant velocity during the
                // step.
                let first = held.acceleration(&dq, truth, &mut bristle, 0.5 * h);
                let half: [f64; 6] = std::array::from_fn(|k| dq[k] + 0.5 * h * first[k]);
                let second = held.acceleration(&half, truth, &mut bristle, 0.5 * h);
                for k in 0..6 {
                    q[k] += h * half[k];
                    dq[k] += h * second[k];
                }
            }
            ddq = std::array::from_fn(|k| (dq[k] - start[k]) / (STEPS as f64 * h));
        }
        clean
    }
}

/// The robot during a controller sample, in which the torque is constant.
struct Held {
    inertia: Cholesky<f64, Const<6>>,
    /// Controller torque minus bias torque, u - h, N m.
    net: [f64; 6],
}

impl Held {
    fn new(robot: &TapeRobot, q: &[f64; 6], dq: &[f64; 6], u: [f64; 6]) -> Held {
        let (a, bias) = dynamics(robot, q, dq);
        let inertia = SMatrix::<f64, 6, 6>::from_row_slice(&a).cholesky();
        let inertia = inertia.unwrap_or_else(|| panic!("the inertia matrix of a robot is positive definite"));
        Held { inertia, net: std::array::from_fn(|k| u[k] - bias[k] - OFFSET[k]) }
    }

    /// The acceleration A^-1 (u - h - friction). Also integrates the bristles (internal states of friction) over `step` s.
    fn acceleration(&self, dq: &[f64; 6], truth: Truth, bristle: &mut [f64; 6], step: f64) -> [f64; 6] {
        let net = SVector::from_fn(|k, _| self.net[k] - friction(truth, k, dq[k], &mut bristle[k], step));
        self.inertia.solve(&net).into()
    }
}

/// Friction torque of joint k without offset, N m. The bristle deflection z follows dz/dt = v - |v| z / z_max, solved exactly.
fn friction(truth: Truth, k: usize, v: f64, z: &mut f64, step: f64) -> f64 {
    let excess = 1.0 + 0.3 * (-(v / 0.1) * (v / 0.1)).exp();
    let mut slide = |most: f64| {
        let (there, gone) = (most * sign(v), (-v.abs() * step / most).exp());
        let rate = v - v.abs() * *z / most;
        *z = there + (*z - there) * if v == 0.0 { 0.0 } else { gone };
        rate
    };
    let dry = match truth {
        Truth::Stribeck => excess * (v / 0.005).tanh(),
        Truth::Dahl => {
            slide(2e-3);
            *z / 2e-3
        }
        Truth::LuGre => {
            let rate = slide(1e-3 * excess);
            (*z + 2e-3 * rate) / 1e-3
        }
        _ => (v / 0.005).tanh(),
    };
    VISCOUS[k] * v + COULOMB[k] * dry
}

fn dynamics(robot: &TapeRobot, q: &[f64; 6], dq: &[f64; 6]) -> ([f64; 36], [f64; 6]) {
    let (mut a, mut bias) = ([0.0; 36], [0.0; 6]);
    Dynamics::fill(robot, q, dq, &mut a, &mut bias);
    (a, bias)
}

fn rows() -> usize {
    (REPEATED as f64 * MOTION / PERIOD) as usize
}

/// Noise-free signals, one series per joint.
struct Clean {
    q: Vec<Vec<f64>>,
    dq: Vec<Vec<f64>>,
    tau: Vec<Vec<f64>>,
}

impl Clean {
    fn new() -> Clean {
        let none = vec![Vec::new(); 6];
        Clean { q: none.clone(), dq: none.clone(), tau: none }
    }

    fn push(&mut self, q: &[f64; 6], dq: &[f64; 6], tau: &[f64; 6]) {
        for k in 0..6 {
            self.q[k].push(q[k]);
            self.dq[k].push(dq[k]);
            self.tau[k].push(tau[k]);
        }
    }

    /// Changes the signals by the effects of sensors and of flexibility.
    fn sense(&mut self, truth: Truth, random: &mut Random) {
        match truth {
            Truth::Late(ms) => {
                // Time between rows is 2 ms. Between rows the torque is interpolated linearly.
                let late = f64::from(ms) * 1e-3 / PERIOD;
                self.tau.iter_mut().for_each(|tau| {
                    let at = |x: f64| tau[x as usize] + x.fract() * (tau[x as usize + 1] - tau[x as usize]);
                    *tau = (0..tau.len()).map(|i| at((i as f64 - late).max(0.0).min(tau.len() as f64 - 1.5))).collect();
                });
            }
            Truth::LaggingVelocity(hz) => {
                let share = 1.0 - (-TAU * f64::from(hz) * PERIOD).exp();
                for dq in &mut self.dq {
                    let mut slow = dq[0];
                    dq.iter_mut().for_each(|v| {
                        slow += share * (*v - slow);
                        *v = slow;
                    });
                }
            }
            Truth::Bends => (0..6).for_each(|k| {
                let most = self.tau[k].iter().fold(0.0, |most: f64, tau| most.max(tau.abs()));
                self.bend(k, 0.01 / most);
            }),
            // A flexible base: all links except the first one rotate with the base in the same way as with the second joint.
            Truth::Yields => self.bend(1, 1.0 / 2e4),
            Truth::CrossTalk => {
                let tau = self.tau.clone();
                for k in 0..5 {
                    self.tau[k].iter_mut().zip(&tau[k + 1]).for_each(|(tau, next)| *tau += 0.03 * next);
                }
            }
            Truth::Jitter => {
                for i in 0..rows() {
                    let off = 2e-4 * random.normal();
                    for k in 0..6 {
                        self.q[k][i] += off * self.dq[k][i];
                    }
                }
            }
            _ => {}
        }
    }

    /// Adds the deflection of a spring between encoder and link to the measured position of joint k. `yielding`: compliance,
    /// rad/(N m).
    fn bend(&mut self, k: usize, yielding: f64) {
        let ahead: Vec<f64> = self.tau[k].iter().map(|tau| yielding * tau).collect();
        for i in 0..ahead.len() {
            let (before, next) = (i.saturating_sub(1), (i + 1).min(ahead.len() - 1));
            self.q[k][i] += ahead[i];
            self.dq[k][i] += (ahead[next] - ahead[before]) / (PERIOD * (next - before) as f64);
        }
    }
}

fn root_mean_square(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
}

/// Adds torque ripple: a torque that is periodic in the rotor angle. `times(k)`: number of its periods per turn of joint k.
fn add_ripple(clean: &mut Clean, random: &mut Random, times: impl Fn(usize) -> f64) {
    for k in 0..6 {
        let (size, phase) = (0.02 * 2f64.sqrt() * root_mean_square(&clean.tau[k]), random.between(0.0, TAU));
        let angles = clean.q[k].clone();
        let times = times(k);
        clean.tau[k].iter_mut().zip(angles).for_each(|(tau, q)| *tau += size * (times * q + phase).sin());
    }
}

/// Adds backlash to the measured positions: the motor is ahead of the link by half the gap, on the side that transmits torque. It
/// crosses the gap in about 10 ms.
fn add_backlash(clean: &mut Clean) {
    for k in 0..6 {
        let share = 1.0 - (-PERIOD / 5e-3f64).exp();
        let (mut side, mut before) = (sign(clean.tau[k][0]), sign(clean.tau[k][0]));
        let (mut slow, mut gap) = (side, Vec::new());
        for tau in &clean.tau[k] {
            // The side is filtered by two low-passes in series, so that the velocity in the gap does not jump.
            slow += share * (sign(*tau) - slow);
            side += share * (slow - side);
            gap.push((5e-4 * side, 5e-4 * (side - before) / PERIOD));
            before = side;
        }
        for (i, (q, dq)) in gap.into_iter().enumerate() {
            clean.q[k][i] += q;
            clean.dq[k][i] += dq;
        }
    }
}

/// The log: the signals as the sensors measure them, with noise and rounding.
fn measured(clean: &Clean, truth: Truth, names: &[String], random: &mut Random) -> Log {
    let slow = truth == Truth::SlowNoise;
    let step = if truth == Truth::TwelveBits { TAU / 4096.0 } else { 1e-5 };
    let mut of = |x: &Vec<Vec<f64>>, noise: &dyn Fn(&[f64]) -> f64, slow: bool| -> Vec<Vec<f64>> {
        let series = |x: &Vec<f64>| {
            let (size, keep, mut state) = (noise(x), (-PERIOD / 0.3f64).exp(), 0.0);
            let one = |x: &f64| {
                state = keep * state + (1.0 - keep * keep).sqrt() * random.normal();
                x + size * (random.normal() + if slow { state } else { 0.0 })
            };
            x.iter().map(one).collect()
        };
        x.iter().map(series).collect()
    };
    let q = of(&clean.q, &|_| 2e-5, false);
    let q = q.into_iter().map(|q| q.into_iter().map(|q| (q / step).round() * step).collect()).collect();
    let dq = of(&clean.dq, &|_| 2e-3, false);
    let effort = of(&clean.tau, &|tau| 0.02 + 0.005 * root_mean_square(tau), slow);
    even_log(names, PERIOD, [q, dq, effort])
}

/// The motion q = c + sum of five harmonics. Each joint stays within 2.4 rad and 2 rad/s.
struct FourierMotion {
    sine: [[f64; 5]; 6],
    cosine: [[f64; 5]; 6],
}

impl FourierMotion {
    fn random(random: &mut Random) -> FourierMotion {
        let mut draw = || std::array::from_fn(|_| std::array::from_fn(|k| random.normal() / (k + 1) as f64));
        let mut motion = FourierMotion { sine: draw(), cosine: draw() };
        let instants: Vec<[[f64; 6]; 3]> = (0..500).map(|i| motion.at(MOTION * i as f64 / 500.0)).collect();
        for k in 0..6 {
            let largest = |of: usize| instants.iter().map(|x| x[of][k].abs()).fold(0.0, f64::max);
            let scale = (2.4 / largest(0)).min(2.0 / largest(1));
            motion.sine[k].iter_mut().chain(&mut motion.cosine[k]).for_each(|x| *x *= scale);
        }
        motion
    }

    /// The positions q, velocities dq and accelerations ddq at time t, s.
    fn at(&self, t: f64) -> [[f64; 6]; 3] {
        let mut state = [[0.0; 6]; 3];
        for harmonic in 0..5 {
            let w = 2.0 * PI / MOTION * (harmonic + 1) as f64;
            let (s, c) = (w * t).sin_cos();
            for k in 0..6 {
                let (a, b) = (self.sine[k][harmonic], self.cosine[k][harmonic]);
                state[0][k] += a * s + b * c;
                state[1][k] += w * (a * c - b * s);
                state[2][k] -= w * w * (a * s + b * c);
            }
        }
        state
    }
}
