//! The operations of a tape, and how the interpreter performs them.
//!
//! Sums and products are computed by one operation, (+-a) b +- c. A sum is computed as a 1 + c and rounds like a + c; a product
//! is computed as a b + -0 and rounds like a b. So a long sequence of operations has no branch on the kind of operation. Such a
//! branch would cost time whenever the processor predicts it wrongly.

use crate::fusion::Operation;
use crate::graph::Expr;
use crate::sine::sin_cos;
use crate::slots::Slots;

/// The operation: slot `to` = (+-a) b +- c. a, b and c are slots.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sum {
    a: u32,
    b: u32,
    c: u32,
    pub to: u32,
    a_sign: Sign,
    c_sign: Sign,
}

/// A sign, as the bits to flip in a number: the sign bit, or none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sign(u64);

impl Sign {
    const PLUS: Sign = Sign(0);

    fn of(e: Expr) -> Sign {
        Sign(u64::from(e.is_negative()) << 63)
    }

    /// x with this sign. Two loops are used, because the compiler would turn a single loop into operations on single numbers.
    #[inline(always)]
    fn times<const B: usize>(self, x: &[f64; B]) -> [f64; B] {
        let (mut bits, mut signed) = ([0; B], [0.0; B]);
        for l in 0..B {
            bits[l] = x[l].to_bits() ^ self.0;
        }
        for l in 0..B {
            signed[l] = f64::from_bits(bits[l]);
        }
        signed
    }
}

/// An operation other than a sum or product. It is performed after the first `after` sums.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NonSumOperation {
    pub after: usize,
    pub code: Code,
    pub a: u32,
    pub b: u32,
    pub to: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Code {
    Div,
    Sqrt,
    /// Square root of the negative of slot `a`.
    SqrtOfNegative,
    /// Writes the sine of slot `a` to slot `to`, and its cosine to slot `b`.
    SinCos,
}

/// The slots of the constants 1 and -0. With these constants, sums and products have one form: a + c is computed as a 1 + c, and
/// a b as a b + -0.
pub(crate) struct Units {
    pub one: u32,
    pub minus_zero: u32,
}

/// An operation whose result has no slot assigned yet.
pub(crate) enum Scheduled {
    Sum(Sum),
    Other(NonSumOperation),
}

impl Units {
    /// Writes `operation` with the memory slots of its operands; `None` for [`Operation::None`].
    pub(crate) fn scheduled(&self, operation: Operation, slots: &Slots) -> Option<Scheduled> {
        let held = |e: Expr| slots.at(e);
        let sum = |a: u32, b: u32, c: u32, [a_sign, c_sign]: [Sign; 2]| {
            Scheduled::Sum(Sum { a, b, c, to: 0, a_sign, c_sign })
        };
        let other = |code: Code, a: Expr, b: Expr| {
            Scheduled::Other(NonSumOperation { after: 0, code, a: held(a), b: held(b), to: 0 })
        };
        Some(match operation {
            Operation::None => return None,
            Operation::Add(a, c) => sum(held(a), self.one, held(c), [Sign::PLUS, Sign::of(c)]),
            Operation::MulAdd(a, b, c) => sum(held(a), held(b), held(c), [Sign::of(a), Sign::of(c)]),
            Operation::Mul(a, b) => sum(held(a), held(b), self.minus_zero, [Sign::PLUS; 2]),
            Operation::Div(a, b) => other(Code::Div, a, b),
            Operation::Sqrt(a) if a.is_negative() => other(Code::SqrtOfNegative, a, a),
            Operation::Sqrt(a) => other(Code::Sqrt, a, a),
        })
    }
}

// The next two functions use loops and not `from_fn`, because the compiler does not use the wide vector instructions in a closure
// that the standard library calls.

#[inline(always)]
pub(crate) fn run_sums<const B: usize>(sums: &[Sum], slots: &mut [[f64; B]], mul_add: impl Fn(f64, f64, f64) -> f64) {
    for sum in sums {
        let (a, b, c) = (&slots[sum.a as usize], &slots[sum.b as usize], &slots[sum.c as usize]);
        let (a, c) = (sum.a_sign.times(a), sum.c_sign.times(c));
        let mut to = [0.0; B];
        for l in 0..B {
            to[l] = mul_add(a[l], b[l], c[l]);
        }
        slots[sum.to as usize] = to;
    }
}

#[inline(always)]
pub(crate) fn run_other<const B: usize>(
    other: &NonSumOperation,
    slots: &mut [[f64; B]],
    mul_add: impl Fn(f64, f64, f64) -> f64,
) {
    let (a, b) = (slots[other.a as usize], slots[other.b as usize]);
    let mut to = [0.0; B];
    macro_rules! in_lanes {
        ($l:ident, $value:expr) => {
            for $l in 0..B {
                to[$l] = $value
            }
        };
    }
    match other.code {
        Code::Div => in_lanes!(l, a[l] / b[l]),
        Code::Sqrt => in_lanes!(l, a[l].sqrt()),
        Code::SqrtOfNegative => in_lanes!(l, (-a[l]).sqrt()),
        Code::SinCos => {
            let mut cosine = [0.0; B];
            (0..B).for_each(|l| (to[l], cosine[l]) = sin_cos(a[l], &mul_add));
            slots[other.b as usize] = cosine;
        }
    }
    slots[other.to as usize] = to;
}
