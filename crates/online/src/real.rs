//! The numbers of the crate: f64 and f32, with the square root that `core` does not have.
//!
//! Each function of the crate is generic over this trait, so a controller can compute in single or double precision.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// A floating-point number.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The number 0.
    const ZERO: Self;
    /// The number 1.
    const ONE: Self;
    /// The nearest number to `x`.
    fn of(x: f64) -> Self;
    /// The square root, within one unit in the last place; NaN for a negative number.
    fn sqrt(self) -> Self;
    /// Whether the number is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Whether the number is larger than zero; false for NaN.
    fn is_positive(self) -> bool {
        self > Self::ZERO
    }
    /// The absolute value.
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }
    /// The larger of two numbers; `other` if `self` is NaN.
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

/// Half of the exponent bias, in the position of the exponent. This value plus half of the bit pattern of a number is the bit
/// pattern of the square root within 4 %.
const HALF_BIAS_F64: u64 = 0x1ff8_0000_0000_0000;
const HALF_BIAS_F32: u32 = 0x1fc0_0000;

macro_rules! real {
    ($number:ty, $half_bias:expr, $steps:expr) => {
        impl Real for $number {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;

            #[allow(clippy::cast_possible_truncation, reason = "the nearest number of the type is wanted")]
            #[inline]
            fn of(x: f64) -> Self {
                x as $number
            }

            /// Newton's iteration. Each step doubles the number of exact bits. It starts from a root within 4 %.
            #[inline]
            fn sqrt(self) -> Self {
                if !(self > 0.0 && self.is_finite()) {
                    return if self < 0.0 { <$number>::NAN } else { self };
                }
                let mut root = <$number>::from_bits((self.to_bits() >> 1) + $half_bias);
                for _ in 0..$steps {
                    root = 0.5 * (root + self / root);
                }
                root
            }

            #[inline]
            fn is_finite(self) -> bool {
                <$number>::is_finite(self)
            }
        }
    };
}

real!(f64, HALF_BIAS_F64, 4);
real!(f32, HALF_BIAS_F32, 3);

#[cfg(test)]
mod tests {
    use super::Real;

    #[test]
    fn roots_are_those_of_the_standard_library() {
        let mut x = 1e-300;
        while x < 1e300 {
            let (found, expected) = (Real::sqrt(x), f64::sqrt(x));
            // One unit in the last place: the rounding of the last step.
            assert!((found - expected).abs() <= expected * f64::EPSILON, "{x}");
            x *= 1.37;
        }
        let mut x = 1e-37_f32;
        while x < 1e38 {
            let (found, expected) = (Real::sqrt(x), f32::sqrt(x));
            assert!((found - expected).abs() <= expected * f32::EPSILON, "{x}");
            x *= 1.37;
        }
        assert_eq!(Real::sqrt(0.0), 0.0);
        assert!(Real::sqrt(-1.0_f64).is_nan() && Real::sqrt(f64::NAN).is_nan());
        assert_eq!(Real::sqrt(f64::INFINITY), f64::INFINITY);
    }

    extern crate std;
}
