//! Random numbers for a situation, from the seeded generator of the tests.
//!
//! A seed determines a situation completely.

use crate::random::Random;

pub struct Draw(Random);

impl Draw {
    /// A generator for one purpose in one situation. Each purpose has its own sequence, so if one needs more numbers, the numbers
    /// of the others do not change.
    pub fn of(seed: u64, purpose: u64) -> Draw {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ purpose.wrapping_mul(0xd1b5_4a32_d192_ed03));
        random.unit();
        Draw(random)
    }

    /// A uniform random number in [low, high).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.unit() + 1.0) / 2.0
    }

    /// A random number in [low, high) whose logarithm is uniform. Both limits must be positive.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform(0.0, 1.0) < probability
    }

    pub fn below(&mut self, n: usize) -> usize {
        self.0.below(n)
    }

    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// A number that is approximately standard normal: half of the sum of twelve uniform numbers in [-1, 1), because this sum has
    /// the variance 4.
    pub fn normal(&mut self) -> f64 {
        0.5 * (0..12).map(|_| self.0.unit()).sum::<f64>()
    }
}
