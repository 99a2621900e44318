//! How far the observer's torque of a joint is from zero without contact, in standard deviations.
//!
//! ```text
//! ratio = sign(r) max(|r| - dry w, 0) / s,   s^2 = noise^2 + (low_speed w)^2 + y C y'
//! w = 1 / (1 + (dq / speed)^2), through the filter of the observer
//! ```
//! noise: standard deviation of the observer's torque at speed; low_speed: additional part at low speed, where friction is
//! least certain; dry: dry friction. At standstill, dry friction may have any value within +-dry, so a torque in this interval
//! is no evidence of a contact. An error of friction passes the filter of the observer; w passes the same filter, so the
//! interval also holds after a reversal. y: row of the regressor of the joint; C: covariance of the parameters. C is given by
//! its factor G with C = G G', so y C y' is the squared length of y G. Few columns of G suffice: the largest principal
//! components over the states of the fitted log.

use crate::real::Real;

/// Constants of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band<R> {
    /// Standard deviation of the observer's torque at speed, N m (N).
    pub noise: R,
    /// Additional standard deviation at standstill, N m (N).
    pub low_speed: R,
    /// Dry friction: largest static friction minus the friction of the model at standstill, N m (N).
    pub dry: R,
    /// Speed at which half of `low_speed` and `dry` remains, rad/s (m/s).
    pub speed: R,
}

impl<R: Real> Band<R> {
    /// w before the filter, 0 to 1; 1 at standstill. `velocity`: dq, rad/s (m/s).
    pub fn slowness(&self, velocity: R) -> R {
        let relative = velocity / self.speed;
        R::ONE / (R::ONE + relative * relative)
    }

    /// The standard deviation of the observer's torque without contact, N m (N). `slowness`: w; `of_parameters`: y C y'.
    pub fn deviation(&self, slowness: R, of_parameters: R) -> R {
        let low_speed = self.low_speed * slowness;
        (self.noise * self.noise + low_speed * low_speed + of_parameters).sqrt()
    }

    /// The interval +-dry w of dry friction, N m (N).
    pub fn dry_at(&self, slowness: R) -> R {
        self.dry * slowness
    }

    /// The observer's torque r beyond dry friction, in standard deviations.
    pub fn ratio(&self, torque: R, slowness: R, of_parameters: R) -> R {
        let beyond = (torque.abs() - self.dry_at(slowness)).max(R::ZERO) / self.deviation(slowness, of_parameters);
        if torque < R::ZERO { -beyond } else { beyond }
    }
}

/// Ratio of the noise of a joint to the noise in the fitted logs. A load increases this ratio, because the noise of the
/// velocity is multiplied by the inertia.
///
/// The changes of r from cycle to cycle are mainly noise. Their mean square over a memory is compared with the mean square in
/// the fitted logs. A contact changes r for a short time only, and each change counts as three standard deviations at most.
#[derive(Clone, Copy, Debug)]
pub struct NoiseScale<R> {
    /// Standard deviation of the changes in the fitted logs, N m (N).
    reference: R,
    memory: R,
    square: R,
    torque: R,
}

/// Square of the largest number of standard deviations for which a change counts.
const LARGEST_CHANGE_SQUARED: f64 = 9.0;

impl<R: Real> NoiseScale<R> {
    /// Starts at the noise of the fitted logs. `reference`: standard deviation of the change of r from cycle to cycle in these
    /// logs, N m (N); `memory`: s.
    pub fn new(reference: R, memory: R) -> NoiseScale<R> {
        NoiseScale { reference, memory, square: reference * reference, torque: R::ZERO }
    }

    /// Takes two values of a cycle: the torque r without the torque of the load (N m or N) and the time since the previous
    /// cycle (s). Returns the ratio of the noise to the noise of the fitted logs, at least 1.
    pub fn step(&mut self, torque: R, period: R) -> R {
        let change = torque - self.torque;
        self.torque = torque;
        let limit = R::of(LARGEST_CHANGE_SQUARED) * self.square;
        let square = if change * change > limit { limit } else { change * change };
        if square.is_finite() {
            self.square = self.square + period / (self.memory + period) * (square - self.square);
        }
        (self.square.sqrt() / self.reference).max(R::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn the_scale_follows_noise_and_not_a_push() {
        let mut random = Random::new(5);
        let mut scale = NoiseScale::new(0.1 * core::f64::consts::SQRT_2, 0.5);
        let mut at = |k: i32, noise: f64| {
            let push = if (3000..3500).contains(&k) { 20.0 } else { 0.0 };
            scale.step(push + noise * random.normal(), 0.001)
        };
        // The mean square of some hundred changes has a relative standard deviation of a tenth.
        assert!((0..3600).map(|k| at(k, 0.1)).fold(0.0, f64::max) < 1.2);
        let large = (3600..6600).map(|k| at(k, 0.3)).last().unwrap();
        assert!((large - 3.0).abs() < 0.5, "{large}");
    }

    #[test]
    fn dry_friction_is_no_evidence_at_standstill() {
        let band = Band { noise: 3.0, low_speed: 4.0, dry: 2.0, speed: 0.1 };
        assert_eq!(band.slowness(0.0), 1.0);
        assert_eq!(band.slowness(-0.1), 0.5);
        assert_eq!(band.ratio(-2.0, 1.0, 0.0), 0.0);
        assert_eq!(band.ratio(-12.0, 1.0, 0.0), -2.0);
        assert_eq!(band.deviation(0.5, 2.0), (9.0_f64 + 4.0 + 2.0).sqrt());
        assert_eq!(band.dry_at(0.5), 1.0);
        assert_eq!(band.ratio(6.0, 0.0, 0.0), 2.0_f64);
        assert!(band.ratio(f64::NAN, 1.0, 0.0).is_finite());
    }
}
