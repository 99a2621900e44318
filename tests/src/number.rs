//! Numbers with derivatives (hyper-dual numbers): a + b e1 + c e2 + d e1 e2 with e1^2 = e2^2 = 0.
//!
//! f(x + u e1 + v e2) = f(x) + f'(x) u e1 + f'(x) v e2 + f''(x) u v e1 e2 for every function made of the operations in this file.
//! So first and second derivatives are exact up to rounding, without a step size [Fike, Alonso 2011].

use std::ops::{Add, Mul, Neg, Sub};

/// A number with its derivatives in two directions, and its mixed second derivative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Number {
    pub value: f64,
    pub d1: f64,
    pub d2: f64,
    pub d12: f64,
}

impl Number {
    pub const ZERO: Number = Number::constant(0.0);

    pub const fn constant(value: f64) -> Number {
        Number { value, d1: 0.0, d2: 0.0, d12: 0.0 }
    }

    /// A function f of this number, with its derivatives. `f`, `first`, `second`: f, f' and f'' at the value of this number.
    fn image(self, f: f64, first: f64, second: f64) -> Number {
        Number {
            value: f,
            d1: first * self.d1,
            d2: first * self.d2,
            d12: first * self.d12 + second * self.d1 * self.d2,
        }
    }

    pub fn sin(self) -> Number {
        let (s, c) = self.value.sin_cos();
        self.image(s, c, -s)
    }

    pub fn cos(self) -> Number {
        let (s, c) = self.value.sin_cos();
        self.image(c, -s, -c)
    }
}

impl Add for Number {
    type Output = Number;
    fn add(self, o: Number) -> Number {
        Number { value: self.value + o.value, d1: self.d1 + o.d1, d2: self.d2 + o.d2, d12: self.d12 + o.d12 }
    }
}

impl Neg for Number {
    type Output = Number;
    fn neg(self) -> Number {
        Number { value: -self.value, d1: -self.d1, d2: -self.d2, d12: -self.d12 }
    }
}

impl Sub for Number {
    type Output = Number;
    fn sub(self, o: Number) -> Number {
        self + -o
    }
}

impl Mul for Number {
    type Output = Number;
    fn mul(self, o: Number) -> Number {
        Number {
            value: self.value * o.value,
            d1: self.value * o.d1 + self.d1 * o.value,
            d2: self.value * o.d2 + self.d2 * o.value,
            d12: self.value * o.d12 + self.d1 * o.d2 + self.d2 * o.d1 + self.d12 * o.value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_and_a_sine_carry_their_derivatives() {
        let x = Number { value: 0.7, d1: 1.0, d2: 1.0, d12: 0.0 };
        // Expected derivatives of x^2 sin x: first 2x s + x^2 c, second 2 s + 4 x c - x^2 s. s, c: sin x, cos x.
        let y = x * x * x.sin();
        let (s, c) = 0.7f64.sin_cos();
        assert!((y.d1 - (1.4 * s + 0.49 * c)).abs() < 1e-15);
        assert!((y.d12 - (2.0 * s + 2.8 * c - 0.49 * s)).abs() < 1e-15);
        assert!((x.cos() * x.cos() + x.sin() * x.sin()).d12.abs() < 1e-15);
    }
}
