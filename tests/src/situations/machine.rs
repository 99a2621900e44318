//! The robot as it is: bodies that differ from the description, rotors, friction, and what the model has not.

use robot::{Inertial, Robot, StandardParameter};

use crate::random::{Random, State};
use crate::recursion;
use crate::situations::{log_between, normal};

/// A machine, with everything that acts on its joints.
#[derive(Clone)]
pub struct Machine {
    pub robot: Robot,
    /// Standard parameters of the machine.
    pub bodies: Vec<f64>,
    /// Rotor inertia that the description does not have, kg m^2 by coordinate.
    pub rotors: Vec<f64>,
    /// N m s/rad and N m by coordinate.
    viscous: Vec<f64>,
    coulomb: Vec<f64>,
    /// Friction of another law: share of Coulomb friction and its speed; share per torque; per direction.
    stribeck: (f64, f64),
    load: f64,
    asymmetry: f64,
    /// Share of the torque, and waves a turn.
    ripple: (f64, f64),
    /// N m/rad of the coordinate.
    spring: (usize, f64),
    cross_talk: f64,
    /// Share by which friction falls over the log.
    heating: f64,
    /// Share of the torque, changing over seconds.
    slow_noise: f64,
    /// Root mean square torque of each coordinate.
    pub size: Vec<f64>,
}

impl Machine {
    /// Bodies up to 15 % and some millimetres off the description, or exactly as described.
    pub fn random(robot: &Robot, is_urdf: bool, random: &mut Random) -> Machine {
        let all = StandardParameter::all(robot);
        let described: Vec<f64> = all.iter().map(|p| p.value(robot).unwrap_or(0.0)).collect();
        let is_exact = random.below(4) == 0;
        let mut bodies = described.clone();
        for c in (0..all.len()).filter(|_| !is_exact) {
            match all[c].inertial {
                Inertial::Xx => {
                    let body: [f64; 10] = std::array::from_fn(|i| described[c + i]);
                    bodies[c..c + 10].copy_from_slice(&other_body(&body, random));
                }
                Inertial::Ia => bodies[c] = described[c] * (1.0 + 0.15 * random.unit()),
                _ => {}
            }
        }
        let n = robot.n_coordinates();
        let mut size = vec![0.0; n];
        for _ in 0..60 {
            let state = random.state(robot);
            let torque = recursion::torque(robot, &state, &bodies);
            size.iter_mut().zip(torque).for_each(|(s, t)| *s += t * t / 60.0);
        }
        size.iter_mut().for_each(|s| *s = s.sqrt());
        let has_rotors = all.iter().any(|p| p.inertial == Inertial::Ia);
        // What a YAML file says of rotors is so; a URDF cannot say.
        let geared = is_urdf && !has_rotors && random.below(2) == 0;
        let mut each =
            |low: f64, high: f64| size.iter().map(|s| s * log_between(random, low, high)).collect::<Vec<f64>>();
        let (viscous, coulomb) = (each(0.02, 0.15), each(0.02, 0.2));
        let rotors = if geared { each(0.005, 0.05) } else { vec![0.0; n] };
        Machine {
            robot: robot.clone(),
            bodies,
            rotors,
            viscous,
            coulomb,
            stribeck: (0.0, 1.0),
            load: 0.0,
            asymmetry: 0.0,
            ripple: (0.0, 1.0),
            spring: (0, 0.0),
            cross_talk: 0.0,
            heating: 0.0,
            slow_noise: 0.0,
            size,
        }
    }

    /// One thing that the model does not have; returns it in words.
    pub fn defect(&mut self, which: usize, random: &mut Random) -> String {
        let n = self.size.len();
        match which {
            0 => {
                self.stribeck = (log_between(random, 0.1, 0.6), log_between(random, 0.02, 0.2));
                "Stribeck friction".into()
            }
            1 => {
                self.load = log_between(random, 0.01, 0.15);
                "friction that grows with the load".into()
            }
            2 => {
                self.asymmetry = log_between(random, 0.05, 0.4);
                "asymmetric friction".into()
            }
            3 => {
                self.ripple = (log_between(random, 0.003, 0.03), [1.0, 7.0, 50.0][random.below(3)]);
                "ripple".into()
            }
            4 => {
                let k = random.below(n);
                self.spring = (k, self.size[k] * log_between(random, 0.02, 0.5));
                "spring".into()
            }
            5 => {
                self.cross_talk = log_between(random, 0.005, 0.04);
                "cross talk".into()
            }
            6 => {
                self.heating = log_between(random, 0.05, 0.4);
                "heating".into()
            }
            _ => {
                self.slow_noise = log_between(random, 0.005, 0.03);
                "slow noise".into()
            }
        }
    }

    /// The torques of bodies, rotors and gravity, without friction.
    pub fn rigid(&self, state: &State) -> Vec<f64> {
        let torque = recursion::torque(&self.robot, state, &self.bodies);
        torque.iter().zip(&self.rotors).zip(&state.ddq).map(|((t, ia), a)| t + ia * a).collect()
    }

    /// The torques of the drives; `slow`: a slow random signal for each joint.
    pub fn torques(&self, state: &State, share_of_log: f64, slow: &[f64]) -> Vec<f64> {
        let rigid = self.rigid(state);
        let n = rigid.len();
        let one = |k: usize| {
            let (v, size) = (state.dq[k], self.size[k]);
            let direction = (v / (1e-3 * size.max(1.0))).tanh();
            let law = 1.0 + self.stribeck.0 * (-(v / self.stribeck.1).powi(2)).exp() + self.asymmetry * direction;
            let friction = self.viscous[k] * v + (self.coulomb[k] * law + self.load * rigid[k].abs()) * direction;
            let ripple = self.ripple.0 * size * (self.ripple.1 * state.q[k] + k as f64).sin();
            let spring = if self.spring.0 == k { self.spring.1 * state.q[k] } else { 0.0 };
            let warm = 1.0 - self.heating * share_of_log;
            rigid[k] + warm * friction + ripple + spring + self.slow_noise * size * slow[k]
        };
        let torques: Vec<f64> = (0..n).map(one).collect();
        (0..n).map(|k| torques[k] + self.cross_talk * torques[(k + 1) % n]).collect()
    }
}

/// A body that can exist: another mass and inertia, and its centre some millimetres away.
fn other_body(x: &[f64; 10], random: &mut Random) -> [f64; 10] {
    let mass = x[9];
    if mass <= 0.0 {
        return *x;
    }
    let factor = 1.0 + 0.15 * random.unit();
    let spin = factor * (1.0 + 0.1 * random.unit());
    let centre: Vec<f64> = (0..3).map(|i| x[6 + i] / mass).collect();
    let moved: Vec<f64> = centre.iter().map(|c| c + 0.005 * normal(random)).collect();
    let about = |c: &[f64], m: f64| -> [f64; 6] {
        let square: f64 = c.iter().map(|x| x * x).sum();
        let entry = |i: usize, j: usize| m * (if i == j { square } else { 0.0 } - c[i] * c[j]);
        [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)]
    };
    let (before, behind) = (about(&centre, mass), about(&moved, factor * mass));
    let mut other = [0.0; 10];
    for i in 0..6 {
        other[i] = spin * (x[i] - before[i]) + behind[i];
    }
    (0..3).for_each(|i| other[6 + i] = factor * mass * moved[i]);
    other[9] = factor * mass;
    other
}
