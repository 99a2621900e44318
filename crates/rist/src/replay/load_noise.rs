//! Measures the errors that the noise of the observer causes in an estimated load, from logs without a load.
//!
//! The parameters x of a load are estimated in windows of such a log, although there is no load, from the rows of one joint. R,
//! z: triangle and right-hand side of the QR decomposition of the weighted rows, so x = inv(R) z. The ratio f of the squared
//! errors to their expected value is
//!
//! ```text
//! f = mean z'z / freedom          freedom = 10 - tr(inv(P) inv(R) inv(R)')
//! ```
//! P: covariance of a prior for the ten parameters, from the largest load that is possible. For a parameter that a window does
//! not determine, the trace lowers the degrees of freedom by one. f is 1 for independent errors, and larger for correlated
//! errors. f is smaller than 1 if the noise of the velocity dominates: the external torque r contains the derivative of this
//! noise, and the derivative averages out. Therefore f differs from joint to joint: the noise of the velocity dominates where the
//! inertia is large. A row of a joint counts with sqrt(f) times its standard deviation.
//!
//! A prior is a standard deviation that is assumed before any measurement. A record is a part of a log without gaps.

use online::{Band, Payload};

use crate::replay::observers::Seen;

/// Length of a window, s: a usual time for which a load is carried. Slow errors average out within it, so f is smaller than for
/// short windows.
const WINDOW_S: f64 = 15.0;
/// Largest possible mass of a load, kg. This value hardly matters, because a window determines the mass to a tenth of this
/// value.
const POSSIBLE_MASS_KG: f64 = 10.0;
/// With fewer degrees of freedom than this, f is unknown. The correlation time of the torques then replaces it.
const LEAST_FREEDOM: f64 = 5.0;

/// Prior standard deviation of the distance between the mass of a load and the origin of its frame, m.
const LOAD_DISTANCE_M: f64 = 0.2;

/// Prior standard deviations of the ten parameters of a load with a mass of up to m, kg.
pub(crate) fn load_start(m: f64) -> [f64; 10] {
    let (first, second) = (m * LOAD_DISTANCE_M, m * LOAD_DISTANCE_M * LOAD_DISTANCE_M);
    [second, second, second, second, second, second, first, first, first, m]
}

/// Estimates of a load in windows of logs without a load, each from the torques of one joint.
pub(crate) struct LoadNoise {
    joints: Vec<JointWindows>,
    /// Age of the present window, s.
    age: f64,
    /// Time of all cycles, s, and their number.
    time: f64,
    cycles: f64,
}

/// The present window of a joint, and sums over its windows. `square`: z'z; `freedom`: degrees of freedom.
#[derive(Clone)]
struct JointWindows {
    window: Payload<f64, 0>,
    square: f64,
    freedom: f64,
}

impl LoadNoise {
    pub(crate) fn new(joints: usize) -> LoadNoise {
        let none = JointWindows { window: Payload::new(load_start(POSSIBLE_MASS_KG)), square: 0.0, freedom: 0.0 };
        LoadNoise { joints: vec![none; joints], age: 0.0, time: 0.0, cycles: 0.0 }
    }

    /// Takes a cycle of all joints. `period`: s.
    pub(crate) fn add(&mut self, period: f64, seen: &[Seen], bands: &[Band<f64>]) {
        for ((joint, seen), band) in self.joints.iter_mut().zip(seen).zip(bands) {
            if let Some(deviation) = deviation(band, seen.slowness) {
                joint.window.push(&seen.load, seen.torque, deviation, &[]);
            }
        }
        (self.age, self.time, self.cycles) = (self.age + period, self.time + period, self.cycles + 1.0);
        if self.age >= WINDOW_S {
            self.joints.iter_mut().for_each(JointWindows::count);
            self.end();
        }
    }

    /// Drops the present window, for example at the end of a record.
    pub(crate) fn end(&mut self) {
        self.joints.iter_mut().for_each(|joint| joint.window.reset());
        self.age = 0.0;
    }

    /// f times the period of these cycles, s, of each joint. For cycles with another period, f is this product divided by the other
    /// period. A joint with too few windows gets the value of all joints together, and a robot with too few gets `unknown`.
    pub(crate) fn times(&self, unknown: f64) -> Vec<f64> {
        let period = self.time / self.cycles;
        let time = |square: f64, freedom: f64| (freedom > LEAST_FREEDOM).then(|| square / freedom * period);
        let sum = |part: fn(&JointWindows) -> f64| self.joints.iter().map(part).sum();
        let of_robot = time(sum(|joint| joint.square), sum(|joint| joint.freedom)).unwrap_or(unknown);
        self.joints.iter().map(|joint| time(joint.square, joint.freedom).unwrap_or(of_robot)).collect()
    }
}

impl JointWindows {
    /// Adds the present window to the sums.
    fn count(&mut self) {
        let inverse = self.window.inverse_triangle();
        let rows = inverse.iter().zip(load_start(POSSIBLE_MASS_KG));
        let possible: f64 = rows.map(|(row, start)| row.iter().map(|x| x * x).sum::<f64>() / (start * start)).sum();
        self.square += self.window.explained_square();
        self.freedom += 10.0 - possible;
    }
}

/// The standard deviation of a joint's torque for the estimate of a load, N m (N); `None` if static friction may carry the load.
pub(crate) fn deviation(band: &Band<f64>, slowness: f64) -> Option<f64> {
    let deviation = band.deviation(slowness, 0.0);
    (band.dry_at(slowness) < deviation).then_some(deviation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    /// Independent errors have f = 1, differences of independent errors less, and sums over ten cycles some ten times more.
    #[test]
    fn the_factor_is_that_of_the_errors() {
        let band = Band { noise: 0.5, low_speed: 0.0, dry: 0.0, speed: 0.1 };
        let factor = |kind: usize| {
            let (mut random, mut noise) = (Random::new(4), LoadNoise::new(2));
            let (mut before, mut sum) = (0.0, 0.0);
            for k in 0..90_000 {
                let t = 0.01 * f64::from(k);
                let error = random.normal();
                sum = 0.9 * sum + error;
                // Three kinds of errors, each with a variance of 1: independent, differences of successive errors, and sums
                // over about ten cycles.
                let torque = 0.5 * [error, (error - before) / 2.0_f64.sqrt(), sum * (1.0_f64 - 0.81).sqrt()][kind];
                before = error;
                let load = std::array::from_fn(|c| ((0.3 + 0.4 * c as f64) * t + 0.7 * c as f64).sin());
                noise.add(0.01, &[Seen { torque, load, friction: [0.0; 2], slowness: 0.0 }], &[band]);
            }
            noise.times(0.0)[0] / 0.01
        };
        // With 60 windows and ten parameters, f has a relative standard deviation of sqrt(2/600) = 6 %. Four standard
        // deviations are allowed.
        assert!((factor(0) - 1.0).abs() < 0.24, "{}", factor(0));
        assert!(factor(1) < 0.05, "{}", factor(1));
        // The factor is (1 + 0.9) / (1 - 0.9) = 19 at low frequencies. The rows have up to 4 rad/s, so the factor is slightly
        // different.
        assert!((factor(2) / 19.0 - 1.0).abs() < 0.35, "{}", factor(2));
    }
}
