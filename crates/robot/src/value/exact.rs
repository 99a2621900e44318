//! A value of a description as an exact expression. It is converted to f64 only when a number is needed.
//!
//! Examples: `5*pi/6`, `D2`, `-D4/2` and `q3 - q2 - DEL`. Lengths and angles may contain symbols. A joint variable may
//! also contain coordinates.

use std::f64::consts::PI;

/// Index of a symbol in [`crate::Robot::symbols`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SymbolId(pub usize);

/// Index of a coordinate in [`crate::Robot::coordinates`]. With n coordinates, an index of n + p means passive coordinate p of
/// [`crate::Robot::passive`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CoordinateId(pub usize);

/// A named constant of the robot: a length in m or an angle in rad.
#[derive(Clone, Debug, PartialEq)]
pub struct Symbol {
    /// Name of the symbol in expressions.
    pub name: String,
    /// Value of the symbol. It contains no coordinates, but may contain symbols before it.
    pub value: Value,
    /// Whether the file gives no value, so that `value` is a substitute. The base parameters and their rules (linear
    /// combinations of standard parameters) are correct with the substitute, but numerical results have no meaning.
    pub generic: bool,
}

/// An exact expression of numbers, pi, symbols and coordinates.
///
/// A `Number` stands for the decimal that the user wrote: the shortest decimal that is read as this f64.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A decimal number.
    Number(f64),
    /// The number pi.
    Pi,
    /// A symbol: a named constant of the robot.
    Symbol(SymbolId),
    /// A coordinate. It occurs only in joint variables.
    Coordinate(CoordinateId),
    /// The negative value -a.
    Neg(Box<Value>),
    /// The sum a + b.
    Add(Box<Value>, Box<Value>),
    /// The difference a - b.
    Sub(Box<Value>, Box<Value>),
    /// The product a b.
    Mul(Box<Value>, Box<Value>),
    /// The quotient a / b.
    Div(Box<Value>, Box<Value>),
    /// The square root of a value.
    Sqrt(Box<Value>),
    /// The sine of an angle in rad.
    Sin(Box<Value>),
    /// The cosine of an angle in rad.
    Cos(Box<Value>),
    /// Arc tangent atan2(y, x), rad: y is the first value, x is the second.
    Atan2(Box<Value>, Box<Value>),
}

/// The meaning of a name in an expression: a symbol or a coordinate.
#[derive(Clone, Copy, Debug)]
pub enum Name {
    /// The name stands for a symbol.
    Symbol(SymbolId),
    /// The name stands for a coordinate.
    Coordinate(CoordinateId),
}

impl Default for Value {
    fn default() -> Value {
        Value::ZERO
    }
}

impl Value {
    /// The number 0.
    pub const ZERO: Value = Value::Number(0.0);

    /// The value as an angle (rad) if it exceeds a full turn; otherwise `None`. Also `None` if it contains a symbol, because a
    /// large symbol may be intended.
    pub(crate) fn beyond_a_turn(&self, symbols: &[Symbol]) -> Option<f64> {
        let angle = self.number(symbols);
        (angle.abs() > 2.0 * PI && !self.has_symbol()).then_some(angle)
    }

    /// The operands of an operation, one or two. A number and a name have none.
    pub(crate) fn operands(&self) -> impl Iterator<Item = &Value> {
        let (a, b) = match self {
            Value::Number(_) | Value::Pi | Value::Symbol(_) | Value::Coordinate(_) => (None, None),
            Value::Neg(a) | Value::Sqrt(a) | Value::Sin(a) | Value::Cos(a) => (Some(a), None),
            Value::Add(a, b) | Value::Sub(a, b) | Value::Mul(a, b) | Value::Div(a, b) | Value::Atan2(a, b) => {
                (Some(a), Some(b))
            }
        };
        a.into_iter().chain(b).map(Box::as_ref)
    }

    /// Whether the expression contains a symbol.
    pub fn has_symbol(&self) -> bool {
        matches!(self, Value::Symbol(_)) || self.operands().any(Value::has_symbol)
    }

    /// The numerical value of the expression. Coordinates count as zero.
    pub fn number(&self, symbols: &[Symbol]) -> f64 {
        let n = |v: &Value| v.number(symbols);
        match self {
            Value::Number(x) => *x,
            Value::Pi => PI,
            Value::Symbol(s) => symbols[s.0].value.number(symbols),
            Value::Coordinate(_) => 0.0,
            Value::Neg(a) => -n(a),
            Value::Add(a, b) => n(a) + n(b),
            Value::Sub(a, b) => n(a) - n(b),
            Value::Mul(a, b) => n(a) * n(b),
            Value::Div(a, b) => n(a) / n(b),
            Value::Sqrt(a) => n(a).sqrt(),
            Value::Sin(a) => n(a).sin(),
            Value::Cos(a) => n(a).cos(),
            Value::Atan2(a, b) => n(a).atan2(n(b)),
        }
    }

    /// Numerator and denominator if the value is a rational multiple of pi, `num/den * pi`, with small integers; otherwise
    /// `None`. Examples: `5*pi/6`, `-pi`, zero, and a symbol with such a value.
    pub fn as_multiple_of_pi(&self, symbols: &[Symbol]) -> Option<(i64, i64)> {
        let (a, b) = self.as_affine_in_pi(symbols)?;
        if b.0 == 0 { Some(a) } else { None }
    }

    /// The rational numbers a and b of a value `a pi + b`, each as (num, den); `None` if the value does not have this form.
    fn as_affine_in_pi(&self, symbols: &[Symbol]) -> Option<(Ratio, Ratio)> {
        let f = |v: &Value| v.as_affine_in_pi(symbols);
        match self {
            Value::Number(x) => Some(((0, 1), ratio(*x)?)),
            Value::Pi => Some(((1, 1), (0, 1))),
            Value::Symbol(s) => f(&symbols[s.0].value),
            Value::Neg(a) => f(a).map(|(p, b)| ((-p.0, p.1), (-b.0, b.1))),
            Value::Add(a, b) => {
                let ((p, b0), (q, b1)) = (f(a)?, f(b)?);
                Some((add(p, q)?, add(b0, b1)?))
            }
            Value::Sub(a, b) => f(&Value::Add(a.clone(), Box::new(Value::Neg(b.clone())))),
            Value::Mul(a, b) => {
                let ((p, b0), (q, b1)) = (f(a)?, f(b)?);
                match (p.0, q.0) {
                    (_, 0) => Some((mul(p, b1)?, mul(b0, b1)?)),
                    (0, _) => Some((mul(q, b0)?, mul(b0, b1)?)),
                    _ => None,
                }
            }
            Value::Div(a, b) => {
                let ((p, b0), (q, b1)) = (f(a)?, f(b)?);
                if q.0 != 0 || b1.0 == 0 {
                    return None;
                }
                let inverse = if b1.0 < 0 { (-b1.1, -b1.0) } else { (b1.1, b1.0) };
                Some((mul(p, inverse)?, mul(b0, inverse)?))
            }
            Value::Atan2(a, b) => {
                let ((p, y), (q, x)) = (f(a)?, f(b)?);
                // `eighths`: angle of the vector (x, y) in units of pi/4, if the vector lies along an axis or a diagonal of the
                // plane.
                let eighths = match (y.0.signum(), x.0.signum()) {
                    _ if p.0 != 0 || q.0 != 0 => return None,
                    (0, 0 | 1) => 0,
                    (1, 0) => 2,
                    (0, _) => 4,
                    (_, 0) => -2,
                    (s, t) if y.0.abs() == x.0.abs() && y.1 == x.1 => s * if t > 0 { 1 } else { 3 },
                    _ => return None,
                };
                Some((reduce(eighths, 4)?, (0, 1)))
            }
            Value::Coordinate(_) | Value::Sqrt(_) | Value::Sin(_) | Value::Cos(_) => None,
        }
    }
}

type Ratio = (i64, i64);

/// Largest numerator that the function [`ratio`] accepts. Integers up to this value are exact in f64.
const MAX_RATIO_NUMERATOR: f64 = 1e15;

/// The fraction that equals a decimal with at most nine digits after the point; `None` for other numbers.
fn ratio(x: f64) -> Option<Ratio> {
    let scaled = x * 1e9;
    if scaled.abs() > MAX_RATIO_NUMERATOR {
        return None;
    }
    let n = scaled.round();
    // The fraction must equal the given decimal, not a neighbouring decimal: n / 1e9 must give the same f64.
    if n / 1e9 != x {
        return None;
    }
    reduce(n as i64, 1_000_000_000)
}

fn reduce(n: i64, d: i64) -> Option<Ratio> {
    let (mut a, mut b) = (n.unsigned_abs(), d.unsigned_abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    let g = i64::try_from(a.max(1)).ok()?;
    Some((n / g, d / g))
}

fn add(a: Ratio, b: Ratio) -> Option<Ratio> {
    let n = a.0.checked_mul(b.1)?.checked_add(b.0.checked_mul(a.1)?)?;
    reduce(n, a.1.checked_mul(b.1)?)
}

fn mul(a: Ratio, b: Ratio) -> Option<Ratio> {
    reduce(a.0.checked_mul(b.0)?, a.1.checked_mul(b.1)?)
}
