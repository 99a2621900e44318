//! Angles of a .par: no robot is turned by more than once around, and one that seems to be is in degrees.

use std::f64::consts::TAU;

use crate::error::Error;
use crate::format::expression::Names;
use crate::format::node::{Node, Source};
use crate::robot::ModifiedDh;
use crate::value::{Symbol, Value};

/// One of gamma b alpha d theta r; fails where an angle is more than a whole turn, as one in degrees is.
pub(super) fn within_a_turn(
    source: Source,
    names: &Names,
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

/// A placement whose angles are sums, which may be more than a turn.
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

    /// A sum of two angles stands as it does a turn less, and one of a symbol stays.
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
