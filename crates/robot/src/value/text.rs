//! Writes values and joint variables as text in the form that a user would write. [`crate::value::parse`] can read it.

use super::affine::Affine;
use super::exact::{CoordinateId, Symbol, Value};

/// The precedence of an operation. It determines where parentheses are necessary.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Sum,
    Product,
    Factor,
}

impl Value {
    /// The expression as text. `name`: returns the name of a coordinate.
    pub fn text(&self, symbols: &[Symbol], name: &dyn Fn(CoordinateId) -> String) -> String {
        self.bound_text(symbols, name, Binding::Sum)
    }

    fn bound_text(&self, symbols: &[Symbol], name: &dyn Fn(CoordinateId) -> String, within: Binding) -> String {
        use Binding::{Factor, Product, Sum};
        let t = |v: &Value, within| v.bound_text(symbols, name, within);
        // A minus before a product is read as the sign of its first factor. So a negative first factor needs no parentheses.
        let left = |v: &Value| match v {
            Value::Neg(_) | Value::Number(_) => t(v, Sum),
            v => t(v, Product),
        };
        let (text, own) = match self {
            Value::Number(x) if x.is_sign_negative() && *x != 0.0 => (x.to_string(), Sum),
            Value::Number(x) => (x.abs().to_string(), Factor),
            Value::Pi => ("pi".into(), Factor),
            Value::Symbol(s) => (symbols[s.0].name.clone(), Factor),
            Value::Coordinate(k) => (name(*k), Factor),
            Value::Neg(a) => (format!("-{}", t(a, Product)), Sum),
            Value::Add(a, b) => match &**b {
                Value::Neg(b) => (format!("{} - {}", t(a, Sum), t(b, Product)), Sum),
                b => (format!("{} + {}", t(a, Sum), t(b, Product)), Sum),
            },
            Value::Sub(a, b) => (format!("{} - {}", t(a, Sum), t(b, Product)), Sum),
            Value::Mul(a, b) => (format!("{}*{}", left(a), t(b, Factor)), Product),
            Value::Div(a, b) => (format!("{}/{}", left(a), t(b, Factor)), Product),
            Value::Sqrt(a) => (format!("sqrt({})", t(a, Sum)), Factor),
            Value::Sin(a) => (format!("sin({})", t(a, Sum)), Factor),
            Value::Cos(a) => (format!("cos({})", t(a, Sum)), Factor),
            Value::Atan2(a, b) => (format!("atan2({}, {})", t(a, Sum), t(b, Sum)), Factor),
        };
        if own < within { format!("({text})") } else { text }
    }
}

impl Affine {
    /// The joint variable plus `constant` as text, for example `q3 - q2 - DEL`.
    pub fn text(&self, constant: &Value, symbols: &[Symbol], name: &dyn Fn(CoordinateId) -> String) -> String {
        let mut text = String::new();
        // Terms with a positive coefficient are written first.
        let ordered = || self.terms.iter().filter(|t| t.1 > 0.0).chain(self.terms.iter().filter(|t| t.1 < 0.0));
        for &(k, c) in ordered() {
            let sign = if c < 0.0 { "-" } else { "+" };
            let factor = if c.abs() == 1.0 { String::new() } else { format!("{}*", c.abs()) };
            text += &format!(" {sign} {factor}{}", name(k));
        }
        for offset in [&self.offset, constant] {
            if *offset != Value::ZERO {
                let offset = offset.text(symbols, name);
                text += &match offset.strip_prefix('-') {
                    Some(rest) => format!(" - {rest}"),
                    None => format!(" + {offset}"),
                };
            }
        }
        match text.strip_prefix(" + ").or(text.strip_prefix(' ')) {
            None => "0".into(),
            Some(text) => match text.strip_prefix("- ") {
                Some(rest) => format!("-{rest}"),
                None => text.to_string(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::{Name, SymbolId, parse};

    fn read(text: &str) -> Value {
        let name = |w: &str| match w {
            "q1" => Some(Name::Coordinate(CoordinateId(0))),
            "q2" => Some(Name::Coordinate(CoordinateId(1))),
            "D" => Some(Name::Symbol(SymbolId(0))),
            _ => None,
        };
        parse(text, &name).unwrap()
    }

    #[test]
    fn what_is_written_reads_back() {
        let symbols = [Symbol { name: "D".into(), value: Value::Number(0.3), generic: false }];
        let name = |k: CoordinateId| format!("q{}", k.0 + 1);
        for text in [
            "5*pi/6",
            "-(D + 1)*3",
            "2 - (3 - 4)",
            "8/(2/2)",
            "8/2/2",
            "(-D)*2",
            "-D*2",
            "1 - (-D)",
            "2*(-3)",
            "D - -3",
            "1 + (-3 + D)",
            "sqrt(2)/2*D",
            "atan2(D, 1 + D)",
            "cos(-pi/4)",
            "0.1 + 1e-9",
            "D**3/2",
            "4**-0.5",
        ] {
            let value = read(text);
            let written = value.text(&symbols, &name);
            let back = read(&written);
            assert_eq!(back.number(&symbols), value.number(&symbols), "{text} -> {written}");
            assert_eq!(back.text(&symbols, &name), written);
        }
        assert_eq!(read("5*pi/6 - (D - 1)").text(&symbols, &name), "5*pi/6 - (D - 1)");
        let affine = Affine::from_value(&read("-q1 + 2*q2 - D"), &symbols).unwrap();
        assert_eq!(affine.text(&Value::Pi, &symbols, &name), "2*q2 - q1 - D + pi");
        assert_eq!(Affine::constant(Value::ZERO).text(&Value::ZERO, &symbols, &name), "0");
        assert_eq!(Affine::constant(Value::ZERO).text(&read("-pi/2"), &symbols, &name), "-pi/2");
    }
}
