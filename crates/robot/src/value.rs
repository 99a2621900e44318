//! A number as the user wrote it: kept exact until somebody asks for its f64.
//!
//! `5*pi/6`, `D2`, `-D4/2` and `q3 - q2 - DEL` are values; what may stand in one depends on the
//! place: lengths and angles may name symbols, a joint variable may also name coordinates.

use std::f64::consts::PI;

/// Index of a symbol in [`crate::Robot::symbols`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SymbolId(pub usize);

/// Index of a coordinate in [`crate::Robot::coordinates`], and beyond their number in
/// [`crate::Robot::passive`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CoordinateId(pub usize);

/// A named constant of the robot: a length in m or an angle in rad.
#[derive(Clone, Debug, PartialEq)]
pub struct Symbol {
    pub name: String,
    /// Its value, free of coordinates; may name symbols that stand before it.
    pub value: Value,
    /// The file gives no value and this one only keeps apart what the symbols keep apart: ranks and
    /// rules are right, figures mean nothing.
    pub generic: bool,
}

/// An exact expression in numbers, pi, symbols and coordinates.
///
/// A `Number` is the decimal the user wrote: the shortest decimal that reads back as this f64.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Number(f64),
    Pi,
    Symbol(SymbolId),
    Coordinate(CoordinateId),
    Neg(Box<Value>),
    Add(Box<Value>, Box<Value>),
    Sub(Box<Value>, Box<Value>),
    Mul(Box<Value>, Box<Value>),
    Div(Box<Value>, Box<Value>),
    Sqrt(Box<Value>),
    Sin(Box<Value>),
    Cos(Box<Value>),
}

/// What a name in an expression stands for.
#[derive(Clone, Copy, Debug)]
pub enum Name {
    Symbol(SymbolId),
    Coordinate(CoordinateId),
}

impl Value {
    pub const ZERO: Value = Value::Number(0.0);

    /// The f64 of the value; coordinates count as zero.
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
        }
    }

    /// `num/den * pi` with small integers when the value is such a multiple by its form
    /// (`5*pi/6`, `-pi`, a symbol so defined, zero); `None` otherwise.
    pub fn as_multiple_of_pi(&self, symbols: &[Symbol]) -> Option<(i64, i64)> {
        let (a, b) = self.as_affine_in_pi(symbols)?;
        if b.0 == 0 { Some(a) } else { None }
    }

    /// `a pi + b` with rational a, b, as ((num, den), (num, den)).
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
            Value::Coordinate(_) | Value::Sqrt(_) | Value::Sin(_) | Value::Cos(_) => None,
        }
    }
}

type Ratio = (i64, i64);

/// A decimal with at most nine digits after the point, as a fraction.
fn ratio(x: f64) -> Option<Ratio> {
    let scaled = x * 1e9;
    if scaled.abs() > 1e15 {
        return None;
    }
    let n = scaled.round();
    // The decimal itself, not a neighbour: n / 1e9 must read back as the same f64.
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

/// Reads an expression: numbers, `pi`, names, `+ - * /`, parentheses, `sqrt sin cos`.
///
/// `name` says what an identifier stands for. The error is one sentence without a place: the
/// caller knows the file and the line.
pub fn parse(text: &str, name: &dyn Fn(&str) -> Option<Name>) -> Result<Value, String> {
    let mut p = Parser { rest: text, depth: 0, name };
    let value = p.sum()?;
    p.skip();
    if p.rest.is_empty() { Ok(value) } else { Err(format!("unexpected `{}` in `{text}`", p.rest.trim_end())) }
}

/// Deeper nesting than this is not a robot but an attack on the stack.
const MAX_DEPTH: usize = 64;

struct Parser<'a> {
    rest: &'a str,
    depth: usize,
    name: &'a dyn Fn(&str) -> Option<Name>,
}

impl Parser<'_> {
    fn skip(&mut self) {
        self.rest = self.rest.trim_start();
    }

    fn take(&mut self, c: char) -> bool {
        self.skip();
        if let Some(rest) = self.rest.strip_prefix(c) {
            self.rest = rest;
            return true;
        }
        false
    }

    fn sum(&mut self) -> Result<Value, String> {
        let mut v = self.product()?;
        loop {
            if self.take('+') {
                v = Value::Add(Box::new(v), Box::new(self.product()?));
            } else if self.take('-') {
                v = Value::Sub(Box::new(v), Box::new(self.product()?));
            } else {
                return Ok(v);
            }
        }
    }

    fn product(&mut self) -> Result<Value, String> {
        let mut v = self.factor()?;
        loop {
            if self.take('*') {
                v = Value::Mul(Box::new(v), Box::new(self.factor()?));
            } else if self.take('/') {
                v = Value::Div(Box::new(v), Box::new(self.factor()?));
            } else {
                return Ok(v);
            }
        }
    }

    fn factor(&mut self) -> Result<Value, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("the expression nests deeper than {MAX_DEPTH} levels"));
        }
        let v = self.unnested_factor();
        self.depth -= 1;
        v
    }

    fn unnested_factor(&mut self) -> Result<Value, String> {
        if self.take('-') {
            return Ok(Value::Neg(Box::new(self.factor()?)));
        }
        if self.take('+') {
            return self.factor();
        }
        if self.take('(') {
            let v = self.sum()?;
            return if self.take(')') { Ok(v) } else { Err("a `(` is never closed".into()) };
        }
        self.skip();
        let starts = |f: fn(char) -> bool| self.rest.chars().next().is_some_and(f);
        if starts(|c| c.is_ascii_digit() || c == '.') {
            return self.number();
        }
        if starts(|c| c.is_alphabetic() || c == '_') {
            return self.identifier();
        }
        match self.rest.chars().next() {
            Some(c) => Err(format!("a number, a name or `(` was expected, `{c}` was found")),
            None => Err("the expression ends where a number or a name was expected".into()),
        }
    }

    fn number(&mut self) -> Result<Value, String> {
        let bytes = self.rest.as_bytes();
        let mut end = 0;
        while end < bytes.len() {
            let exponent_sign = end > 0 && matches!(bytes[end - 1], b'e' | b'E') && matches!(bytes[end], b'+' | b'-');
            if bytes[end].is_ascii_digit() || matches!(bytes[end], b'.' | b'e' | b'E') || exponent_sign {
                end += 1;
            } else {
                break;
            }
        }
        let (digits, rest) = self.rest.split_at(end);
        self.rest = rest;
        match digits.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(Value::Number(x)),
            _ => Err(format!("`{digits}` is not a finite number")),
        }
    }

    fn identifier(&mut self) -> Result<Value, String> {
        let end = self.rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        if matches!(word, "sqrt" | "sin" | "cos") {
            if !self.take('(') {
                return Err(format!("`{word}` needs its argument in parentheses"));
            }
            let argument = Box::new(self.sum()?);
            if !self.take(')') {
                return Err(format!("the `(` of `{word}` is never closed"));
            }
            return Ok(match word {
                "sqrt" => Value::Sqrt(argument),
                "sin" => Value::Sin(argument),
                _ => Value::Cos(argument),
            });
        }
        if word == "pi" || word == "Pi" {
            return Ok(Value::Pi);
        }
        match (self.name)(word) {
            Some(Name::Symbol(s)) => Ok(Value::Symbol(s)),
            Some(Name::Coordinate(c)) => Ok(Value::Coordinate(c)),
            None => Err(format!("`{word}` is not the name of a symbol or a coordinate")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Value, String> {
        parse(text, &|w| (w == "q1").then_some(Name::Coordinate(CoordinateId(0))))
    }

    #[test]
    fn values() {
        for (text, value) in [
            ("5*pi/6", 5.0 * PI / 6.0),
            ("-(1 + 2)*3", -9.0),
            ("1e-3", 1e-3),
            ("2 - 3 - 4", -5.0),
            ("8/2/2", 2.0),
            ("sqrt(2)/2", 2f64.sqrt() / 2.0),
            ("--1", 1.0),
        ] {
            assert_eq!(read(text).unwrap().number(&[]), value, "{text}");
        }
    }

    #[test]
    fn multiples_of_pi() {
        for (text, multiple) in [
            ("5*pi/6", Some((5, 6))),
            ("-pi/2", Some((-1, 2))),
            ("pi*0.25", Some((1, 4))),
            ("0", Some((0, 1))),
            ("pi/2 - pi", Some((-1, 2))),
            ("1.5", None),
            ("pi + 1", None),
            ("q1", None),
        ] {
            assert_eq!(read(text).unwrap().as_multiple_of_pi(&[]), multiple, "{text}");
        }
    }

    #[test]
    fn refusals_say_what_was_found() {
        for (text, part) in [
            ("D9", "`D9` is not the name"),
            ("1 +", "ends where"),
            ("(1", "never closed"),
            ("1 2", "unexpected `2`"),
            ("1e999", "not a finite number"),
            ("sin 2", "parentheses"),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
        assert!(read(&"(".repeat(10_000)).unwrap_err().contains("nests deeper"));
    }
}
