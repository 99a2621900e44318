//! Prescribed motions: sums of sines, and moves from place to place.

use robot::Robot;

use crate::random::{Random, State};
use crate::situations::log_between;

/// Motion of all joints over time.
pub struct Motion {
    pub name: &'static str,
    /// s.
    pub duration: f64,
    joints: Vec<Joint>,
}

enum Joint {
    /// Middle, and amplitude, rad/s and phase of each sine.
    Sines(f64, Vec<[f64; 3]>),
    /// Places, a move of so many seconds and a rest of as many between each two.
    Moves(Vec<f64>, f64, f64),
}

impl Motion {
    /// Of a kind: periodic, wandering, slow, small, partly still, from place to place.
    pub fn random(robot: &Robot, kind: usize, random: &mut Random) -> Motion {
        let n = robot.n_coordinates();
        let name = ["periodic", "wandering", "slow", "small", "partly still", "place to place"][kind];
        let duration = if random.below(4) == 0 { 12.0 } else { 30.0 };
        let base = std::f64::consts::TAU / if random.below(2) == 0 { 6.0 } else { 10.0 };
        let (move_s, rest_s) = (1.5 + 0.5 * random.unit(), 0.5);
        let speed = if kind == 2 { log_between(random, 0.05, 0.3) } else { 1.0 };
        let size = if kind == 3 { log_between(random, 0.03, 0.3) } else { 1.0 };
        let joints = (0..n)
            .map(|k| {
                let limits = robot.coordinates[k].limits.position.filter(|(low, high)| high - low < 100.0);
                let (low, high) = limits.unwrap_or((-2.0, 2.0));
                let (middle, reach) = (0.5 * (low + high), (0.5 * (high - low)).min(1.5));
                if kind == 4 && random.below(3) == 0 {
                    return Joint::Sines(middle + 0.3 * random.unit(), Vec::new());
                }
                if kind == 5 {
                    let count = (duration / (move_s + rest_s)) as usize + 2;
                    return Joint::Moves((0..count).map(|_| middle + reach * random.unit()).collect(), move_s, rest_s);
                }
                let count = 3 + random.below(3);
                let sines: Vec<[f64; 3]> = (1..=count)
                    .map(|h| {
                        let frequency = if kind == 0 { base * h as f64 } else { 0.4 + 1.3 * (1.0 + random.unit()) };
                        let amplitude = size * reach * 0.8 / count as f64;
                        [amplitude, speed * frequency, 3.1 * random.unit()]
                    })
                    .collect();
                Joint::Sines(middle + 0.2 * reach * random.unit(), sines)
            })
            .collect();
        Motion { name, duration, joints }
    }

    /// q, dq, ddq at t, s.
    pub fn at(&self, t: f64) -> State {
        let all: Vec<[f64; 3]> = self.joints.iter().map(|joint| joint.at(t)).collect();
        let pick = |i: usize| all.iter().map(|x| x[i]).collect();
        State { q: pick(0), dq: pick(1), ddq: pick(2) }
    }
}

impl Joint {
    fn at(&self, t: f64) -> [f64; 3] {
        match self {
            Joint::Sines(middle, sines) => sines.iter().fold([*middle, 0.0, 0.0], |[q, dq, ddq], [a, w, phase]| {
                let (sin, cos) = (w * t + phase).sin_cos();
                [q + a * sin, dq + a * w * cos, ddq - a * w * w * sin]
            }),
            Joint::Moves(places, move_s, rest_s) => {
                let step = move_s + rest_s;
                let k = ((t / step) as usize).min(places.len() - 2);
                let (from, way) = (places[k], places[k + 1] - places[k]);
                let u = ((t - k as f64 * step) / move_s).min(1.0);
                // The quintic that rests at both ends.
                let (u2, u3) = (u * u, u * u * u);
                let q = u3 * (10.0 - 15.0 * u + 6.0 * u2);
                let dq = (30.0 * u2 - 60.0 * u3 + 30.0 * u2 * u2) / move_s;
                let ddq = (60.0 * u - 180.0 * u2 + 120.0 * u3) / (move_s * move_s);
                [from + way * q, way * dq, way * ddq]
            }
        }
    }
}
