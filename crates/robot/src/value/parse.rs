//! Parses the text of an expression in a description, such as `q1 + pi/2`, to a value.

use super::exact::{Name, Value};

/// Parses an expression: numbers, `pi`, names, `+ - * /`, parentheses, `sqrt sin cos atan2`, and powers `**` (or `^`) whose
/// exponent is a small integer or a half.
///
/// `name`: returns the meaning of a name. The error is one sentence without a place, because the caller knows the file
/// and the line.
pub fn parse(text: &str, name: &dyn Fn(&str) -> Option<Name>) -> Result<Value, String> {
    let mut p = Parser { rest: text, depth: 0, name };
    let value = p.sum()?;
    p.skip();
    if p.rest.is_empty() { Ok(value) } else { Err(format!("unexpected `{}` in `{text}`", p.rest.trim_end())) }
}

/// Largest depth of nested expressions. It prevents a stack overflow.
const MAX_NESTING_LEVELS: usize = 64;
/// Largest exponent. A power is expanded to a product.
const MAX_EXPONENT: f64 = 4.0;
/// Largest number of operations of an expanded power.
const MAX_POWER_OPERATIONS: f64 = 1000.0;

fn operations(value: &Value) -> usize {
    1 + value.operands().map(operations).sum::<usize>()
}

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
        if self.depth > MAX_NESTING_LEVELS {
            return Err(format!("the expression nests deeper than {MAX_NESTING_LEVELS} levels"));
        }
        let v = self.unnested_factor();
        self.depth -= 1;
        v
    }

    fn unnested_factor(&mut self) -> Result<Value, String> {
        if self.take('-') {
            // Two minus signs cancel. If both were kept, the written text would have more parentheses, and so a deeper nesting.
            return Ok(match self.factor()? {
                Value::Neg(value) => *value,
                value => Value::Neg(Box::new(value)),
            });
        }
        if self.take('+') {
            return self.factor();
        }
        self.power()
    }

    fn power(&mut self) -> Result<Value, String> {
        let base = self.primary()?;
        self.skip();
        let Some(rest) = self.rest.strip_prefix("**").or(self.rest.strip_prefix('^')) else { return Ok(base) };
        self.rest = rest;
        let negative = self.take('-');
        self.skip();
        let Value::Number(exponent) = self.primary()? else {
            return Err("the exponent of a power must be a number".into());
        };
        if exponent.max(1.0) * operations(&base) as f64 > MAX_POWER_OPERATIONS {
            return Err("a power of so long an expression is too long to write out".into());
        }
        let boxed = Box::new;
        let power = if exponent == 0.5 {
            Value::Sqrt(boxed(base))
        } else if exponent.fract() == 0.0 && (1.0..=MAX_EXPONENT).contains(&exponent) {
            (1..exponent as usize).fold(base.clone(), |v, _| Value::Mul(boxed(v), boxed(base.clone())))
        } else {
            return Err(format!("the exponent of a power must be 0.5 or 1 to {MAX_EXPONENT}, found {exponent}"));
        };
        Ok(if negative { Value::Div(boxed(Value::Number(1.0)), boxed(power)) } else { power })
    }

    fn primary(&mut self) -> Result<Value, String> {
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
        // Functions and pi come first, so no symbol or coordinate of the description can replace them.
        if word == "atan2" {
            if !self.take('(') {
                return Err("`atan2` needs its two arguments in parentheses".into());
            }
            let first = Box::new(self.sum()?);
            if !self.take(',') {
                return Err("`atan2` has two arguments, with a comma between them".into());
            }
            let second = Box::new(self.sum()?);
            return if self.take(')') {
                Ok(Value::Atan2(first, second))
            } else {
                Err("the `(` of `atan2` is never closed".into())
            };
        }
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
    use std::f64::consts::PI;

    use super::*;
    use crate::value::CoordinateId;

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
            ("-3**2", -9.0),
            ("2**-1 + 4^0.5", 2.5),
            ("atan2(1, -1)", 3.0 * PI / 4.0),
        ] {
            assert_eq!(read(text).unwrap().number(&[]), value, "{text}");
        }
    }

    /// An expression with any number of minus signs can be read, written and read again.
    #[test]
    fn signs_cancel() {
        let text = |signs: usize| read(&("-".repeat(signs) + "q1")).unwrap().text(&[], &|_| "q1".into());
        assert_eq!([0, 1, 2, 62, 63].map(text), ["q1", "-q1", "q1", "q1", "-q1"]);
        assert_eq!(read("2 - (-(-(-q1)))").unwrap().text(&[], &|_| "q1".into()), "2 - (-q1)");
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
            ("atan2(1, -1) - atan2(-2, 0)", Some((5, 4))),
            ("atan2(1, 2)", None),
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
            ("atan2(1)", "two arguments"),
            ("2**9", "exponent"),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
        assert!(read(&"(".repeat(10_000)).unwrap_err().contains("nests deeper"));
    }
}
