//! Checks the angles of a .par file. An angle of more than a full turn is assumed to be in degrees.

use std::f64::consts::TAU;

use crate::error::Error;
use crate::format::expression::KnownNames;
use crate::format::node::{DescriptionFile, Node};
use crate::robot::ModifiedDh;
use crate::value::{Symbol, Value};

/// Reads one of gamma, b, alpha, d, theta, r. Fails if an angle exceeds a full turn, because such an angle is probably in
/// degrees.
pub(super) fn within_a_turn(
    source: DescriptionFile,
    names: &KnownNames,
    (key, what): (&str, &str),
    node: &Node,
    value: Value,
) -> Result<Value, Error> {
    let is_angle = ["gamma", "alpha", "theta"].contains(&key);
    match value.beyond_a_turn(&names.symbols).filter(|_| is_angle) {
        Some(x) => {
            let why =
                format!("{what} is {x:.4} rad, more than a whole turn: angles of a .par are in rad, as `pi/2` is");
            Err(source.at(node, why))
        }
        None => Ok(value),
    }
}

/// A placement whose angles are reduced to less than a full turn. They can exceed a turn if each is a sum of angles of the file.
pub(super) fn within_turns(mut placement: ModifiedDh, symbols: &[Symbol]) -> ModifiedDh {
    for angle in [&mut placement.gamma, &mut placement.alpha, &mut placement.theta] {
        if let Some(x) = angle.beyond_a_turn(symbols) {
            *angle = Value::Number(x % TAU);
        }
    }
    placement
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::SymbolId;

    /// A sum of two angles is reduced by a full turn. The angle of a symbol is not changed.
    #[test]
    fn sums_of_angles_are_within_a_turn() {
        let sum = Value::Add(Value::Number(6.0).into(), Value::Number(5.0).into());
        let symbols = [Symbol { name: "G".into(), value: Value::Number(8.0), generic: false }];
        let symbol = Value::Symbol(SymbolId(0));
        let [d, theta, r] = [(); 3].map(|()| Value::ZERO);
        let placement = ModifiedDh { gamma: sum, b: Value::Number(7.0), alpha: symbol.clone(), d, theta, r };
        let within = within_turns(placement, &symbols);
        assert!((within.gamma.number(&symbols) - (11.0 - TAU)).abs() < 1e-15);
        assert_eq!((within.b, within.alpha), (Value::Number(7.0), symbol));
    }
}
