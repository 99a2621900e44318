//! Random states and parameters, from a seed.

use ::random::SplitMix;

use robot::{Inertial, Robot, StandardParameter};

pub struct Random(pub u64);

/// q, dq, ddq.
pub struct State {
    pub q: Vec<f64>,
    pub dq: Vec<f64>,
    pub ddq: Vec<f64>,
}

impl State {
    /// q, dq, ddq one after the other, as functions take them.
    pub fn inputs(&self) -> Vec<f64> {
        [&self.q[..], &self.dq, &self.ddq].concat()
    }
}

impl Random {
    /// One number of [-1, 1).
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

    /// Positions of a whole turn, and rates that give inertia, Coriolis and gravity torques of similar size.
    pub fn state(&mut self, robot: &Robot) -> State {
        let n = robot.n_coordinates();
        State { q: self.vector(n, std::f64::consts::PI), dq: self.vector(n, 2.0), ddq: self.vector(n, 4.0) }
    }

    /// Arbitrary standard parameters. They need not be physical, as the torque is linear in them.
    pub fn parameters(&mut self, robot: &Robot) -> Vec<f64> {
        self.vector(StandardParameter::all(robot).len(), 1.0)
    }

    /// Standard parameters of bodies that exist: each link a dozen point masses, each rotor positive.
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
