//! A joint variable as an affine function of the coordinates: q_j = sum_k c_k q_k + offset.

use super::exact::{CoordinateId, Symbol, Value};

/// A joint variable q_j = sum_k coefficient_k * q_k + offset. The offset does not contain coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Affine {
    /// The coordinates with non-zero coefficients, in the order of the coordinates.
    pub terms: Vec<(CoordinateId, f64)>,
    /// Value of the joint variable if all coordinates are zero, rad or m.
    pub offset: Value,
}

impl Affine {
    /// The variable of a joint that is locked at `offset`.
    pub fn constant(offset: Value) -> Affine {
        Affine { terms: Vec::new(), offset }
    }

    /// The variable of a joint that equals this coordinate.
    pub fn coordinate(k: CoordinateId) -> Affine {
        Affine { terms: vec![(k, 1.0)], offset: Value::ZERO }
    }

    /// Splits a value into its linear terms in the coordinates and its offset. `None` if the value is not affine.
    pub fn from_value(value: &Value, symbols: &[Symbol]) -> Option<Affine> {
        let part = |v: &Value| Affine::from_value(v, symbols);
        let combine = |a: Affine, b: Affine, sign: f64, offset: Value| {
            let mut terms = a.terms;
            for (k, c) in b.terms {
                match terms.iter_mut().find(|t| t.0 == k) {
                    Some(t) => t.1 += sign * c,
                    None => terms.push((k, sign * c)),
                }
            }
            terms.retain(|t| t.1 != 0.0);
            terms.sort_by_key(|t| t.0);
            Affine { terms, offset }
        };
        match value {
            Value::Coordinate(k) => Some(Affine::coordinate(*k)),
            Value::Neg(a) => {
                let a = part(a)?;
                let offset = negated(&a.offset);
                Some(combine(Affine::constant(Value::ZERO), a, -1.0, offset))
            }
            Value::Add(a, b) => {
                let (a, b) = (part(a)?, part(b)?);
                let offset = sum(&a.offset, &b.offset);
                Some(combine(a, b, 1.0, offset))
            }
            Value::Sub(a, b) => {
                let (a, b) = (part(a)?, part(b)?);
                let offset = sum(&a.offset, &negated(&b.offset));
                Some(combine(a, b, -1.0, offset))
            }
            // The product of a constant and an affine value. In the offset, the constant stays an exact expression; in the
            // coefficients, it becomes a number.
            Value::Mul(a, b) => {
                let (fa, fb) = (part(a)?, part(b)?);
                match (fa.terms.is_empty(), fb.terms.is_empty()) {
                    (true, true) => Some(Affine::constant(value.clone())),
                    (true, false) => Some(fb.scaled(a.number(symbols), |v| Value::Mul(a.clone(), Box::new(v)))),
                    (false, true) => Some(fa.scaled(b.number(symbols), |v| Value::Mul(Box::new(v), b.clone()))),
                    (false, false) => None,
                }
            }
            Value::Div(a, b) => {
                let (fa, fb) = (part(a)?, part(b)?);
                match (fa.terms.is_empty(), fb.terms.is_empty()) {
                    (true, true) => Some(Affine::constant(value.clone())),
                    (false, true) => Some(fa.scaled(1.0 / b.number(symbols), |v| Value::Div(Box::new(v), b.clone()))),
                    _ => None,
                }
            }
            Value::Sqrt(a) | Value::Sin(a) | Value::Cos(a) => {
                part(a)?.terms.is_empty().then(|| Affine::constant(value.clone()))
            }
            Value::Atan2(a, b) => {
                (part(a)?.terms.is_empty() && part(b)?.terms.is_empty()).then(|| Affine::constant(value.clone()))
            }
            Value::Number(_) | Value::Pi | Value::Symbol(_) => Some(Affine::constant(value.clone())),
        }
    }

    fn scaled(self, factor: f64, offset: impl Fn(Value) -> Value) -> Affine {
        let zero = self.offset == Value::ZERO;
        Affine {
            terms: self.terms.into_iter().map(|(k, c)| (k, c * factor)).filter(|t| t.1 != 0.0).collect(),
            offset: if zero { Value::ZERO } else { offset(self.offset) },
        }
    }

    /// The value of the joint variable at the coordinates `q`, rad or m.
    pub fn number(&self, q: &[f64], symbols: &[Symbol]) -> f64 {
        self.offset.number(symbols) + self.rate(q)
    }

    /// The linear part evaluated at `dq` is the velocity of the joint; evaluated at `ddq`, it is the acceleration.
    pub fn rate(&self, dq: &[f64]) -> f64 {
        self.terms.iter().map(|&(k, c)| c * dq[k.0]).sum()
    }
}

fn sum(a: &Value, b: &Value) -> Value {
    match (a, b) {
        (a, b) if *b == Value::ZERO => a.clone(),
        (a, b) if *a == Value::ZERO => b.clone(),
        (a, Value::Neg(b)) => Value::Sub(Box::new(a.clone()), b.clone()),
        (a, b) => Value::Add(Box::new(a.clone()), Box::new(b.clone())),
    }
}

fn negated(a: &Value) -> Value {
    match a {
        a if *a == Value::ZERO => Value::ZERO,
        Value::Neg(a) => (**a).clone(),
        a => Value::Neg(Box::new(a.clone())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::{Name, SymbolId, parse};

    #[test]
    fn splits_coordinates_from_the_rest() {
        let symbols = [Symbol { name: "DEL".into(), value: Value::Number(0.5), generic: false }];
        let name = |w: &str| match w {
            "q1" => Some(Name::Coordinate(CoordinateId(0))),
            "q2" => Some(Name::Coordinate(CoordinateId(1))),
            "DEL" => Some(Name::Symbol(SymbolId(0))),
            _ => None,
        };
        let affine = |t: &str| Affine::from_value(&parse(t, &name).unwrap(), &symbols);
        let a = affine("q2 - q1 - DEL").unwrap();
        assert_eq!(a.terms, [(CoordinateId(0), -1.0), (CoordinateId(1), 1.0)]);
        assert_eq!(a.offset.number(&symbols), -0.5);
        assert_eq!(affine("2*(q1 - q1) + DEL").unwrap().terms, []);
        assert_eq!(affine("(q1 + 1)/2").unwrap().offset.number(&[]), 0.5);
        assert!(affine("q1*q2").is_none());
        assert!(affine("sin(q1)").is_none());
    }
}
