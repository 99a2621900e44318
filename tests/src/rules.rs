//! Evaluates printed rules for base parameters, such as `XXR2 = XX2 - YY2 - D2^2*(M3 + M4)`.
//!
//! A test compares these coefficients with the coefficients that the library computes.

use std::collections::BTreeMap;

use robot::{Affine, CoordinateId, Symbol, SymbolId, Value, value};

/// The coefficient of each parameter in a sum such as `XX2 - YY2 - D2^2*(M3 + M4)`, for these values of the symbols. Panics if
/// the text is not such a sum.
pub fn coefficients(sum: &str, parameters: &[String], symbols: &[(String, f64)]) -> BTreeMap<String, f64> {
    let table: Vec<Symbol> = symbols
        .iter()
        .map(|(name, x)| Symbol { name: name.clone(), value: Value::Number(*x), generic: false })
        .collect();
    let name = |word: &str| {
        let parameter = parameters.iter().position(|p| p == word).map(|c| value::Name::Coordinate(CoordinateId(c)));
        parameter.or_else(|| symbols.iter().position(|s| s.0 == word).map(|s| value::Name::Symbol(SymbolId(s))))
    };
    let parsed = value::parse(&without_powers(sum), &name).unwrap_or_else(|e| panic!("{sum}: {e}"));
    let affine = Affine::from_value(&parsed, &table).unwrap_or_else(|| panic!("{sum}: not linear"));
    assert_eq!(affine.offset.number(&table), 0.0, "{sum}");
    affine.terms.iter().map(|&(k, c)| (parameters[k.0].clone(), c)).collect()
}

/// Writes powers as products: `D2^3*x` becomes `D2*D2*D2*x`, `sin(a)^2` becomes `sin(a)*sin(a)`.
fn without_powers(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find('^') {
        let (before, after) = (&rest[..at], &rest[at + 1..]);
        let digits = after.find(|c: char| !c.is_ascii_digit()).unwrap_or(after.len());
        let power: usize = after[..digits].parse().unwrap_or_else(|e| panic!("{text}: {e}"));
        let mut depth = 0;
        let start = before
            .char_indices()
            .rev()
            .take_while(|&(_, c)| {
                match c {
                    ')' => depth += 1,
                    '(' => depth -= 1,
                    _ => {}
                }
                depth > 0 || c.is_alphanumeric() || matches!(c, '_' | '(')
            })
            .last()
            .map_or(at, |(i, _)| i);
        out += &before[..start];
        // A power after a division sign becomes several divisions.
        let joint = if out.ends_with('/') { "/" } else { "*" };
        out += &vec![&before[start..]; power].join(joint);
        rest = &after[digits..];
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_products() {
        assert_eq!(without_powers("D2^2*(M3 + M4) - sin(DEL)^3*X"), "D2*D2*(M3 + M4) - sin(DEL)*sin(DEL)*sin(DEL)*X");
        assert_eq!(without_powers("a/b^2"), "a/b/b");
    }

    #[test]
    fn a_rule_is_read_back() {
        let found =
            coefficients("XX2 - D2^2*(M3 + 2*M4)", &["XX2", "M3", "M4"].map(String::from), &[("D2".into(), 3.0)]);
        let expected = [("XX2", 1.0), ("M3", -9.0), ("M4", -18.0)];
        assert_eq!(found, expected.map(|(name, c)| (name.to_string(), c)).into());
    }
}
