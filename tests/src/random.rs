//! Random states and parameters, from a seed.
//!
//! Standard parameters: ten inertial parameters of each link, and rotor inertias.

use ::random::SplitMix;

use robot::{Inertial, Robot, StandardParameter};

pub struct Random(pub u64);

/// A state of a robot: q, dq, ddq.
pub struct State {
    pub q: Vec<f64>,
    pub dq: Vec<f64>,
    pub ddq: Vec<f64>,
}

impl State {
    /// q, dq, ddq in one list, as functions take them.
    pub fn inputs(&self) -> Vec<f64> {
        [&self.q[..], &self.dq, &self.ddq].concat()
    }
}

impl Random {
    /// A random number in [-1, 1).
    pub fn unit(&mut self) -> f64 {
        let mut generator = SplitMix(self.0);
        let drawn = generator.unit();
        self.0 = generator.0;
        drawn
    }

    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() + 1.0) / 2.0 * n as f64) as usize % n.max(1)
    }

    pub fn vector(&mut self, n: usize, scale: f64) -> Vec<f64> {
        (0..n).map(|_| scale * self.unit()).collect()
    }

    /// A random state. Positions are within a turn. Velocities and accelerations are such that inertia, Coriolis and gravity
    /// torques have similar magnitudes.
    pub fn state(&mut self, robot: &Robot) -> State {
        let n = robot.n_coordinates();
        State { q: self.vector(n, std::f64::consts::PI), dq: self.vector(n, 2.0), ddq: self.vector(n, 4.0) }
    }

    /// Arbitrary standard parameters. They may be physically impossible, because the torque is linear in them.
    pub fn parameters(&mut self, robot: &Robot) -> Vec<f64> {
        self.vector(StandardParameter::all(robot).len(), 1.0)
    }

    /// Physically possible standard parameters: each link has a dozen point masses, and each rotor inertia is positive.
    pub fn physical_parameters(&mut self, robot: &Robot) -> Vec<f64> {
        let mut x = Vec::new();
        let mut body = [0.0; 10];
        for parameter in StandardParameter::all(robot) {
            if parameter.inertial == Inertial::Xx {
                body = [0.0; 10];
                for _ in 0..12 {
                    let m = 0.3 + 0.2 * self.unit();
                    let [a, b, c] = [0.2 * self.unit(), 0.2 * self.unit(), 0.2 * self.unit()];
                    let of_mass = [b * b + c * c, -a * b, -a * c, a * a + c * c, -b * c, a * a + b * b, a, b, c, 1.0];
                    for i in 0..10 {
                        body[i] += m * of_mass[i];
                    }
                }
            }
            x.push(match parameter.inertial {
                Inertial::Ia => 0.1 + 0.05 * self.unit(),
                inertial => body[inertial as usize],
            });
        }
        x
    }
}
