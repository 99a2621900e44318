//! The functions and operators of xacro expressions.

use std::rc::Rc;

use super::value::{MAX_TEXT_BYTES, NameSource, XacroValue};

/// Largest length of a list that an operator or a method makes.
pub(super) const MAX_LIST_ITEMS: usize = 2000;

/// Calls the function `name` with these arguments. `names`: gives the values of names, and the content of YAML files.
pub(super) fn function(name: &str, arguments: &[XacroValue], names: &mut dyn NameSource) -> Result<XacroValue, String> {
    let number = |k: usize| {
        let value = arguments.get(k).ok_or_else(|| format!("`{name}` lacks an argument"))?;
        // As `float('0.5')` in Python, a text that spells a number counts as this number.
        let of_text = || if let XacroValue::Text(text) = value { text.trim().parse().ok() } else { None };
        value.number().or_else(of_text).ok_or_else(|| format!("`{name}` of {}", value.kind()))
    };
    if let Some(plain) = of_one_number(name) {
        return Ok(XacroValue::Number(plain(number(0)?)));
    }
    let whole = |x: f64| XacroValue::Int(x as i64);
    Ok(match (name, arguments) {
        ("abs", [XacroValue::Int(i)]) => XacroValue::Int(i.saturating_abs()),
        ("abs", _) => XacroValue::Number(number(0)?.abs()),
        ("int", _) => whole(number(0)?.trunc()),
        ("floor", _) => whole(number(0)?.floor()),
        ("ceil", _) => whole(number(0)?.ceil()),
        // Python rounds a half to the nearest even number.
        ("round", [_]) => whole(number(0)?.round_ties_even()),
        ("atan2", _) => XacroValue::Number(number(0)?.atan2(number(1)?)),
        ("pow", _) => XacroValue::Number(number(0)?.powf(number(1)?)),
        ("hypot", _) => XacroValue::Number(number(0)?.hypot(number(1)?)),
        ("min" | "max", [_, _, ..]) => {
            let mut best = 0;
            for k in 1..arguments.len() {
                let is_better = if name == "min" { number(k)? < number(best)? } else { number(k)? > number(best)? };
                best = if is_better { k } else { best };
            }
            number(best)?;
            arguments[best].clone()
        }
        ("str", [value]) => XacroValue::Text(value.text()),
        ("bool", [value]) => XacroValue::Bool(value.holds()),
        ("len", [XacroValue::Text(text)]) => XacroValue::Int(text.chars().count() as i64),
        ("len", [XacroValue::List(items)]) => XacroValue::Int(items.len() as i64),
        ("len", [XacroValue::Map(entries)]) => XacroValue::Int(entries.len() as i64),
        ("load_yaml", [XacroValue::Text(file)]) => names.yaml(file)?,
        ("arg", [XacroValue::Text(name)]) => names.argument(name)?,
        ("list", [XacroValue::List(items)]) => XacroValue::List(items.clone()),
        // Functions that only print a message give an empty text.
        ("message" | "warning" | "print_location", _) => XacroValue::Text(String::new()),
        _ => return Err(format!("the function `{name}` of these {} arguments is not known here", arguments.len())),
    })
}

/// The mathematical function of one number with this name; `None` if there is none.
fn of_one_number(name: &str) -> Option<fn(f64) -> f64> {
    match name {
        "sin" => Some(f64::sin),
        "cos" => Some(f64::cos),
        "tan" => Some(f64::tan),
        "asin" => Some(f64::asin),
        "acos" => Some(f64::acos),
        "atan" => Some(f64::atan),
        "sqrt" => Some(f64::sqrt),
        "exp" => Some(f64::exp),
        "log" => Some(f64::ln),
        "fabs" => Some(f64::abs),
        "radians" => Some(|x| x * (std::f64::consts::PI / 180.0)),
        "degrees" => Some(|x| x * (180.0 / std::f64::consts::PI)),
        "float" => Some(|x| x),
        _ => None,
    }
}

/// Applies an operator to two values.
pub(super) fn binary(operator: &str, left: &XacroValue, right: &XacroValue) -> Result<XacroValue, String> {
    match (operator, left, right) {
        ("+", XacroValue::Text(a), XacroValue::Text(b)) if a.len() + b.len() <= MAX_TEXT_BYTES => {
            return Ok(XacroValue::Text(format!("{a}{b}")));
        }
        ("+", XacroValue::List(a), XacroValue::List(b)) if a.len() + b.len() <= MAX_LIST_ITEMS => {
            return Ok(XacroValue::List(Rc::new([a.as_slice(), b].concat())));
        }
        _ => {}
    }
    // Integers stay exact, as in Python. For b > 0 the Euclidean quotient is floor(a / b). If b <= 0 or the result is too
    // large, the operation is done with floating-point numbers below.
    if let (XacroValue::Int(a), XacroValue::Int(b)) = (left, right) {
        let exact = match operator {
            "+" => a.checked_add(*b),
            "-" => a.checked_sub(*b),
            "*" => a.checked_mul(*b),
            "//" => a.checked_div_euclid(*b).filter(|_| *b > 0),
            "%" => a.checked_rem_euclid(*b).filter(|_| *b > 0),
            "**" => u32::try_from(*b).ok().and_then(|b| a.checked_pow(b)),
            _ => None,
        };
        if let Some(exact) = exact {
            return Ok(XacroValue::Int(exact));
        }
    }
    let (Some(a), Some(b)) = (left.number(), right.number()) else {
        return Err(format!("`{operator}` of {} and {}", left.kind(), right.kind()));
    };
    if ["/", "//", "%"].contains(&operator) && b == 0.0 {
        return Err("a division by zero".into());
    }
    Ok(XacroValue::Number(match operator {
        "+" => a + b,
        "-" => a - b,
        "*" => a * b,
        "/" => a / b,
        "//" => (a / b).floor(),
        "%" => a - b * (a / b).floor(),
        _ => a.powf(b),
    }))
}

/// Whether a text, a list or a map contains a value.
pub(super) fn contains(all: &XacroValue, one: &XacroValue) -> Result<bool, String> {
    match (all, one) {
        (XacroValue::Text(all), XacroValue::Text(one)) => Ok(all.contains(one.as_str())),
        (XacroValue::List(items), one) => Ok(items.contains(one)),
        (XacroValue::Map(entries), one) => Ok(entries.contains_key(&one.text())),
        _ => Err(format!("`in` of {}", all.kind())),
    }
}
