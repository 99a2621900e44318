//! Jets: a function of time near an instant, as a Taylor polynomial of second order with proven bounds.
//!
//! x(t + h) = x_0 + x_1 h + x_2 h^2 with interval coefficients x_0 = x, x_1 = x', x_2 = x''/2 [Moore, Kearfott, Cloud
//! 2009]. For an interval I with middle c, a jet at c (narrow) and a jet that holds everywhere in I (wide), Taylor's theorem
//! gives
//!
//! x(I) within x_0(c) + x_1(c) (I - c) + x_2(I) (I - c)^2.

use std::ops::{Add, Mul, Neg, Sub};

use crate::interval::Interval;

/// The coefficients x, x', x''/2 of the Taylor polynomial of a function x(t), each as an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet(pub [Interval; 3]);

impl Jet {
    /// The jet of a constant that lies in the interval x.
    #[inline]
    pub const fn constant(x: Interval) -> Jet {
        Jet([x, Interval::ZERO, Interval::ZERO])
    }

    /// The jet of a value and its first two derivatives with respect to time.
    #[inline]
    pub fn of_derivatives(x: Interval, dx: Interval, ddx: Interval) -> Jet {
        Jet([x, dx, ddx * 0.5])
    }

    /// The jet of the quotient x / y. If y may be zero, the coefficients of the jet are the interval of all numbers.
    #[inline]
    pub fn over(self, y: Jet) -> Jet {
        let z0 = self.0[0].over(y.0[0]);
        let z1 = (self.0[1] - z0 * y.0[1]).over(y.0[0]);
        let z2 = (self.0[2] - z0 * y.0[2] - z1 * y.0[1]).over(y.0[0]);
        Jet([z0, z1, z2])
    }

    /// The jet of sqrt(x). If x may be zero or negative, the coefficients of the jet are the interval of all numbers.
    pub fn sqrt(self) -> Jet {
        let z0 = self.0[0].sqrt();
        let twice = z0 * 2.0;
        let z1 = self.0[1].over(twice);
        let z2 = (self.0[2] - z1.square()).over(twice);
        Jet([z0, z1, z2])
    }

    /// The jet of sin(x).
    pub fn sin(self) -> Jet {
        let (s, c) = (self.0[0].sin(), self.0[0].cos());
        Jet([s, c * self.0[1], c * self.0[2] - s * self.0[1].square() * 0.5])
    }

    /// The jet of cos(x).
    pub fn cos(self) -> Jet {
        let (s, c) = (self.0[0].sin(), self.0[0].cos());
        Jet([c, -(s * self.0[1]), -(s * self.0[2]) - c * self.0[1].square() * 0.5])
    }

    /// An interval that contains x over an interval I of time with middle c. `at_middle`: jet at c; `wide`: jet over I;
    /// `from_middle`: interval that contains I - c.
    pub fn over_interval(at_middle: Jet, wide: Jet, from_middle: Interval) -> Interval {
        let taylor = at_middle.0[0] + at_middle.0[1] * from_middle + wide.0[2] * from_middle.square();
        taylor.meet(wide.0[0])
    }
}

impl Add for Jet {
    type Output = Jet;
    #[inline]
    fn add(self, other: Jet) -> Jet {
        Jet(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl Sub for Jet {
    type Output = Jet;
    #[inline]
    fn sub(self, other: Jet) -> Jet {
        Jet(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl Neg for Jet {
    type Output = Jet;
    #[inline]
    fn neg(self) -> Jet {
        Jet(self.0.map(|x| -x))
    }
}

impl Mul for Jet {
    type Output = Jet;
    #[inline]
    fn mul(self, other: Jet) -> Jet {
        let ([a0, a1, a2], [b0, b1, b2]) = (self.0, other.0);
        Jet([a0 * b0, a0 * b1 + a1 * b0, a0 * b2 + a1 * b1 + a2 * b0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The enclosure of x = sin(t) (2 + t) / sqrt(3 + cos t) over an interval contains the samples of x in this interval. The
    /// enclosure is wider than the range of x by an amount that decreases with the square of the interval's width.
    #[test]
    fn what_a_function_does_lies_within() {
        let f = |t: f64| t.sin() * (2.0 + t) / (3.0 + t.cos()).sqrt();
        let jet = |t: Interval| {
            let t = Jet([t, Interval::point(1.0), Interval::ZERO]);
            let constant = |x: f64| Jet::constant(Interval::point(x));
            t.sin() * (constant(2.0) + t).over((constant(3.0) + t.cos()).sqrt())
        };
        let mut excess = vec![];
        for width in [0.2, 0.1, 0.05] {
            let mut worst = 0.0_f64;
            for k in 0..40 {
                let (a, b) = (0.1 * k as f64, 0.1 * k as f64 + width);
                let (wide, c) = (Interval::new(a, b), 0.5 * (a + b));
                let held = Jet::over_interval(jet(Interval::point(c)), jet(wide), wide - Interval::point(c));
                let samples = (0..=50).map(|i| f(a + (b - a) * f64::from(i) / 50.0));
                let (low, high) = samples.fold((f64::INFINITY, f64::NEG_INFINITY), |m, x| (m.0.min(x), m.1.max(x)));
                assert!(held.low <= low + 1e-15 && held.high >= high - 1e-15, "{held:?} {low} {high}");
                worst = worst.max(held.high - high).max(low - held.low);
            }
            excess.push(worst);
        }
        assert!(excess[1] < 0.4 * excess[0] && excess[2] < 0.4 * excess[1], "{excess:?}");
    }
}
