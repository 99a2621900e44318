//! Exact sums of angles: a symbol minus itself is zero, and multiples of pi/12 are added as integers.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use crate::angle_snap::computed_angle;
use crate::value::{Symbol, SymbolId, Value};

/// An angle as a sum: symbols with integer factors, a multiple of pi/12, and other terms with integer factors.
#[derive(Default)]
pub(crate) struct LinearAngle {
    symbols: BTreeMap<SymbolId, i64>,
    twelfths: i64,
    others: Vec<(Value, i64)>,
}

impl LinearAngle {
    pub(crate) fn add_symbol(&mut self, s: SymbolId, m: i64) {
        *self.symbols.entry(s).or_default() += m;
    }

    pub(crate) fn add(&mut self, value: &Value, m: i64, symbols: &[Symbol]) {
        match value {
            Value::Symbol(s) => self.add_symbol(*s, m),
            Value::Neg(a) => self.add(a, -m, symbols),
            Value::Add(a, b) => {
                self.add(a, m, symbols);
                self.add(b, m, symbols);
            }
            Value::Sub(a, b) => {
                self.add(a, m, symbols);
                self.add(b, -m, symbols);
            }
            _ => match value.as_multiple_of_pi(symbols) {
                Some((a, b)) if 12 % b == 0 && a.abs() < 1000 => self.twelfths += m * a * (12 / b),
                _ => self.others.push((value.clone(), m)),
            },
        }
    }

    pub(crate) fn value(self) -> Value {
        let symbols = self.symbols.into_iter().map(|(s, m)| (Value::Symbol(s), m));
        let turns = computed_angle(wrapped(self.twelfths.rem_euclid(24) as f64 * PI / 12.0));
        let mut sum = Value::ZERO;
        for (value, m) in symbols.chain(self.others).chain([(turns, 1)]) {
            if m == 0 || value == Value::ZERO {
                continue;
            }
            let size = match m.abs() {
                1 => value,
                size => Value::Mul(Box::new(Value::Number(size as f64)), Box::new(value)),
            };
            sum = match (sum == Value::ZERO, m < 0, size) {
                (true, false, size) => size,
                (true, true, size) => Value::Neg(Box::new(size)),
                (false, false, Value::Neg(size)) => Value::Sub(Box::new(sum), size),
                (false, false, size) => Value::Add(Box::new(sum), Box::new(size)),
                (false, true, size) => Value::Sub(Box::new(sum), Box::new(size)),
            };
        }
        sum
    }
}

/// The angle in (-pi, pi], rad, that differs from `angle` by full turns.
pub(crate) fn wrapped(angle: f64) -> f64 {
    let turned = angle.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cancels_is_gone() {
        let symbols = [Symbol { name: "A".into(), value: Value::Number(0.3), generic: false }];
        let name = |w: &str| (w == "A").then_some(crate::value::Name::Symbol(SymbolId(0)));
        let read = |t: &str| crate::value::parse(t, &name).unwrap();
        let mut sum = LinearAngle::default();
        sum.add(&read("A - pi/2 + sqrt(2)"), 1, &symbols);
        sum.add(&read("pi/3 - A"), 1, &symbols);
        assert_eq!(sum.value().text(&symbols, &|_| String::new()), "sqrt(2) - pi/6");
        let mut whole = LinearAngle::default();
        whole.add(&read("3*pi/2"), 1, &symbols);
        whole.add(&read("-pi/2"), -1, &symbols);
        assert_eq!(whole.value(), Value::ZERO);
    }
}
