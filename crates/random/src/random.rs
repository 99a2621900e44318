//! The generator xoshiro256++ seeded by SplitMix64, and normally distributed numbers by Marsaglia's polar method.
//!
//! [Blackman, Vigna 2021, "Scrambled linear pseudorandom number generators"].

use crate::split_mix::SplitMix;

/// A seeded stream of random numbers.
#[derive(Clone, Debug)]
pub struct Random {
    state: [u64; 4],
    spare: Option<f64>,
}

impl Random {
    /// A stream that starts from `seed`; equal seeds give equal numbers.
    pub fn new(seed: u64) -> Random {
        let mut seeds = SplitMix(seed);
        Random { state: [(); 4].map(|()| seeds.bits()), spare: None }
    }

    /// A stream for one index of an enumeration. Its numbers depend only on `seed` and `index`, so threads can draw them in any
    /// order.
    pub fn stream(seed: u64, index: u64) -> Random {
        let mixed = Random::new(seed ^ index.wrapping_mul(0xd134_2543_de82_ef95)).bits();
        Random::new(mixed)
    }

    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        let s = &mut self.state;
        let result = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let t = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= t;
        s[3] = s[3].rotate_left(45);
        result
    }

    /// A random number, uniformly distributed in [0, 1).
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// A random number, uniformly distributed in [low, high).
    #[inline]
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A random index, uniformly distributed among 0 .. count - 1; 0 if `count` is 0.
    #[inline]
    pub fn index(&mut self, count: usize) -> usize {
        // The upper half of the 128-bit product bits * count; its bias is below count / 2^64.
        ((u128::from(self.bits()) * count as u128) >> 64) as usize
    }

    /// A random number with normal distribution, mean 0 and variance 1.
    #[inline]
    pub fn normal(&mut self) -> f64 {
        if let Some(z) = self.spare.take() {
            return z;
        }
        loop {
            let (u, v) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let s = u * u + v * v;
            if s > 0.0 && s < 1.0 {
                let f = (-2.0 * s.ln() / s).sqrt();
                self.spare = Some(v * f);
                return u * f;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_is_a_stream() {
        let take = |mut r: Random| [r.bits(), r.bits(), r.bits()];
        assert_eq!(take(Random::new(7)), take(Random::new(7)));
        assert_ne!(take(Random::new(7)), take(Random::new(8)));
        assert_ne!(take(Random::stream(7, 0)), take(Random::stream(7, 1)));
    }

    #[test]
    fn moments_of_the_normal() {
        let mut r = Random::new(3);
        let n = 200_000;
        let (mut m1, mut m2, mut m4) = (0.0, 0.0, 0.0);
        for _ in 0..n {
            let z = r.normal();
            m1 += z;
            m2 += z * z;
            m4 += z * z * z * z;
        }
        let n = f64::from(n);
        // Allowed: five standard errors of the moments, sqrt(1/n), sqrt(2/n), sqrt(96/n).
        assert!((m1 / n).abs() < 5.0 * (1.0 / n).sqrt());
        assert!((m2 / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
        assert!((m4 / n - 3.0).abs() < 5.0 * (96.0 / n).sqrt());
    }
}
