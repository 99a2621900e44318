//! Interval arithmetic: intervals that contain a number, with proven bounds of results.
//!
//! Each operation returns an interval that contains the result for all numbers of its operands [Moore, Kearfott, Cloud 2009].
//! After each operation the bounds are moved outward by one step of f64, because + - * / and sqrt round to nearest. Sine and
//! cosine of `libm` are assumed to have an error of at most twice the spacing of f64 near 1.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::{Add, Mul, Neg, Sub};

/// An interval: all numbers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The smallest number of the interval.
    pub low: f64,
    /// The largest number of the interval.
    pub high: f64,
}

/// Assumed error bound of sine and cosine of `libm`: twice the distance between neighbouring f64 near 1.
const SINE_ERROR: f64 = 2.0 * f64::EPSILON;

/// An interval counts as containing a peak of the sine if it is nearer to the peak than this value, in turns (of 2 pi rad). The
/// value is far above the rounding error of angle / 2 pi.
const PEAK_DISTANCE_TURNS: f64 = 1e-9;
/// For angles above this value (rad), the enclosure of the sine is [-1, 1], because the rounding error of angle / 2 pi comes
/// near [`PEAK_DISTANCE_TURNS`].
const MAX_ANGLE_RAD: f64 = 1e6;

impl Interval {
    /// The interval that contains only zero.
    pub const ZERO: Interval = Interval::point(0.0);

    /// The interval that contains only x.
    #[inline]
    pub const fn point(x: f64) -> Interval {
        Interval { low: x, high: x }
    }

    /// The interval from `low` to `high`.
    #[inline]
    pub const fn new(low: f64, high: f64) -> Interval {
        Interval { low, high }
    }

    /// The interval from -x to x, for x >= 0.
    #[inline]
    pub const fn around_zero(x: f64) -> Interval {
        Interval { low: -x, high: x }
    }

    /// The interval of all numbers, for a value that is unknown.
    pub const ALL: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// An interval that contains pi: from the f64 below to the f64 above the constant.
    pub fn pi() -> Interval {
        Interval { low: PI.next_down(), high: PI.next_up() }
    }

    /// A number inside the interval near its middle.
    #[inline]
    pub fn middle(self) -> f64 {
        (self.low + 0.5 * (self.high - self.low)).clamp(self.low, self.high)
    }

    /// The width `high` - `low`.
    #[inline]
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// The largest absolute value of the numbers in the interval.
    #[inline]
    pub fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// The smallest interval that contains both intervals.
    #[inline]
    pub fn hull(self, other: Interval) -> Interval {
        Interval { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The intersection of both intervals; `self` if they are disjoint. Two enclosures of one quantity are never disjoint,
    /// because they are rounded outward.
    #[inline]
    pub fn meet(self, other: Interval) -> Interval {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        if low <= high { Interval { low, high } } else { self }
    }

    /// An interval that contains the squares of all numbers in this interval. Its lower end is at least zero.
    #[inline]
    pub fn square(self) -> Interval {
        let product = self * self;
        Interval { low: product.low.max(0.0), high: product.high }
    }

    /// The interval of all quotients `self` / `divisor`; all numbers if the divisor contains zero.
    #[inline]
    pub fn over(self, divisor: Interval) -> Interval {
        if divisor.low <= 0.0 && divisor.high >= 0.0 {
            return Interval::ALL;
        }
        let quotients =
            [self.low / divisor.low, self.low / divisor.high, self.high / divisor.low, self.high / divisor.high];
        outward(quotients)
    }

    /// The interval of the square roots; all numbers if the interval contains a negative number.
    #[inline]
    pub fn sqrt(self) -> Interval {
        if self.low < 0.0 {
            return Interval::ALL;
        }
        Interval { low: self.low.sqrt().next_down().max(0.0), high: self.high.sqrt().next_up() }
    }

    /// An interval that contains the sines of all angles in this interval, rad.
    pub fn sin(self) -> Interval {
        self.sine_with_peaks_at(FRAC_PI_2, libm::sin)
    }

    /// An interval that contains the cosines of all angles in this interval, rad.
    pub fn cos(self) -> Interval {
        self.sine_with_peaks_at(0.0, libm::cos)
    }

    /// An interval that contains the values of `f` for all numbers in this interval. `f` is 1 at `peak` + 2 k pi, -1 half a
    /// turn later, and monotonic in between.
    fn sine_with_peaks_at(self, peak: f64, f: fn(f64) -> f64) -> Interval {
        let unit = Interval::around_zero(1.0);
        // For larger angles the rounding of angle / 2 pi would come near PEAK_DISTANCE_TURNS.
        if !(self.low.abs() <= MAX_ANGLE_RAD && self.high.abs() <= MAX_ANGLE_RAD) {
            return unit;
        }
        let holds = |peak: f64| {
            let (from, to) =
                ((self.low - peak) / TAU - PEAK_DISTANCE_TURNS, (self.high - peak) / TAU + PEAK_DISTANCE_TURNS);
            from.ceil() <= to
        };
        let (a, b) = (f(self.low), f(self.high));
        let low = if holds(peak + PI) { -1.0 } else { (a.min(b) - SINE_ERROR).max(-1.0) };
        let high = if holds(peak) { 1.0 } else { (a.max(b) + SINE_ERROR).min(1.0) };
        Interval { low, high }
    }
}

/// The smallest interval that contains these values, with both ends moved outward by one step of f64. If a value is NaN, the
/// result is the interval of all numbers.
#[inline]
fn outward(values: [f64; 4]) -> Interval {
    if values.iter().any(|x| x.is_nan()) {
        return Interval::ALL;
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Interval { low: low.next_down(), high: high.next_up() }
}

impl Add for Interval {
    type Output = Interval;
    #[inline]
    fn add(self, other: Interval) -> Interval {
        if other == Interval::ZERO {
            return self;
        }
        if self == Interval::ZERO {
            return other;
        }
        Interval { low: (self.low + other.low).next_down(), high: (self.high + other.high).next_up() }
    }
}

impl Sub for Interval {
    type Output = Interval;
    #[inline]
    fn sub(self, other: Interval) -> Interval {
        self + -other
    }
}

impl Neg for Interval {
    type Output = Interval;
    #[inline]
    fn neg(self) -> Interval {
        Interval { low: -self.high, high: -self.low }
    }
}

impl Mul for Interval {
    type Output = Interval;
    #[inline]
    fn mul(self, other: Interval) -> Interval {
        if self == Interval::ZERO || other == Interval::ZERO {
            return Interval::ZERO;
        }
        outward([self.low * other.low, self.low * other.high, self.high * other.low, self.high * other.high])
    }
}

impl Mul<f64> for Interval {
    type Output = Interval;
    #[inline]
    fn mul(self, factor: f64) -> Interval {
        self * Interval::point(factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn results_lie_within() {
        let mut random = Random::new(5);
        for _ in 0..2000 {
            let mut interval = || {
                let (a, b) = (4.0 * random.normal(), random.normal().abs());
                let within = a + b * random.uniform();
                (Interval::new(a, a + b), within.clamp(a, a + b))
            };
            let ((x, a), (y, b)) = (interval(), interval());
            let holds = |i: Interval, value: f64| assert!(i.low <= value && value <= i.high, "{i:?} {value}");
            holds(x + y, a + b);
            holds(x - y, a - b);
            holds(x * y, a * b);
            holds(x.over(y), a / b);
            holds(x.square(), a * a);
            holds(x.sin(), a.sin());
            holds(x.cos(), a.cos());
            holds(x.square().sqrt(), a.abs());
            holds(x.hull(y), b);
        }
    }

    /// The intervals are hardly wider than needed: a sum is wider by a rounding step only, and the sine of an interval with a
    /// peak ends exactly at 1.
    #[test]
    fn intervals_are_narrow() {
        let x = Interval::new(1.0, 2.0);
        assert!((x + x).width() < 2.0 + 1e-14);
        let across = Interval::new(1.5, 1.7).sin();
        assert_eq!(across.high, 1.0);
        assert!((across.low - 1.7f64.sin()).abs() < 1e-14);
        let rising = Interval::new(0.1, 0.2).sin();
        assert!(rising.high - 0.2f64.sin() < 1e-14 && 0.1f64.sin() - rising.low < 1e-14);
        assert_eq!(Interval::new(-0.5, 0.2).cos().high, 1.0);
        assert_eq!(Interval::new(-10.0, 10.0).cos(), Interval::around_zero(1.0));
        assert_eq!(Interval::ZERO * Interval::ALL, Interval::ZERO);
        assert_eq!(Interval::point(1.0).over(Interval::around_zero(1.0)), Interval::ALL);
    }
}
