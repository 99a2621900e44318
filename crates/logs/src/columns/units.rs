//! Interprets the units that a user gives for a quantity, and converts numbers of the file to SI units.
//!
//! | text | meaning of a number x |
//! |---|---|
//! | `deg`, `N mm`, `ms`, ..: the units of headers | x in this unit |
//! | `counts(2.69 mA)` | 2.69 x mA |
//! | `ticks(4096)` | x/4096 of a turn; as a velocity `ticks(4096)/s` |
//! | `permille(25 N m)`, `percent(25 N m)` | x/1000 (x/100) of 25 N m |
//! | `int16 ..` before one of these | x - 65536 from 32768 on: two's complement (also int8, int32) |
//! | `signbit(10) ..` before one of these | 1024 - x from 1024 on: bit 10 is the sign |

use std::f64::consts::TAU;

use gate::suggestion::did_you_mean;
use serde::{Deserialize, Serialize};

use crate::cleaning::raw_words::RawWord;
use crate::columns::words::{Quantity, units, written};

/// Units that the user gives, for quantities without a unit in their headers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct UnitNames {
    /// Unit of the clock, for example `ms`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Unit of the positions, for example `deg` or `ticks(4096)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<String>,
    /// Unit of the velocities, for example `deg/s` or `counts(0.229 rpm)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<String>,
    /// Unit of the accelerations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<String>,
    /// Unit of the torques, for example `N mm` or `permille(25 N m)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<String>,
    /// Unit of the currents, for example `mA` or `counts(2.69 mA)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current: Option<String>,
    /// Unit of the goals, if it differs from the unit of the positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<String>,
}

impl UnitNames {
    /// Whether the user gives no unit.
    pub fn is_empty(&self) -> bool {
        *self == UnitNames::default()
    }

    pub(crate) fn of(&self, quantity: Quantity) -> Option<&str> {
        match quantity {
            Quantity::Time => self.time.as_deref(),
            Quantity::Position => self.position.as_deref(),
            Quantity::Velocity => self.velocity.as_deref(),
            Quantity::Acceleration => self.acceleration.as_deref(),
            Quantity::Torque => self.torque.as_deref(),
            Quantity::Current => self.current.as_deref(),
            Quantity::Goal => self.goal.as_deref().or(self.position.as_deref()),
        }
    }
}

/// The unit of a column: name, factor and word type.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GivenUnit {
    /// Name of the unit in headers, or the text that the user gave.
    pub name: String,
    /// Factor that converts a number to the SI unit.
    pub factor: f64,
    /// The word type of the numbers if they are register words; otherwise `None`.
    pub word: Option<RawWord>,
}

/// The unit that a text means for a quantity. The error message lists the known units.
pub(crate) fn given_unit(quantity: Quantity, text: &str) -> Result<GivenUnit, String> {
    let (word, rest) = signed_word(text.trim())?;
    let (name, factor) = scale(quantity, rest)?;
    let name = if word.is_some() { text.trim().to_string() } else { name };
    Ok(GivenUnit { name, factor, word })
}

/// The word type at the start of a text (`int16` or `signbit(10)`), and the text after it. `None` if there is no word type.
fn signed_word(text: &str) -> Result<(Option<RawWord>, &str), String> {
    let first = text.split_whitespace().next().unwrap_or("");
    let bits = |digits: &str| digits.parse::<i32>().ok().filter(|bits| (1..=32).contains(bits));
    let word = if let Some(digits) = first.strip_prefix("int") {
        let bits = bits(digits).ok_or_else(|| format!("`{first}`: int8, int16 or int32 are read"))?;
        RawWord::TwosComplement { bits, count: 1.0 }
    } else if let Some(digits) = first.strip_prefix("signbit(").and_then(|rest| rest.strip_suffix(')')) {
        let bit = bits(digits).ok_or_else(|| format!("`{first}`: the bit of the sign is from 1 to 32"))?;
        RawWord::SignBit { bit, count: 1.0 }
    } else {
        return Ok((None, text));
    };
    Ok((Some(word), text[first.len()..].trim_start()))
}

/// The name of a unit or scale, and its factor to the SI unit.
fn scale(quantity: Quantity, text: &str) -> Result<(String, f64), String> {
    if text.is_empty() {
        return Ok((written(units(quantity).first().map_or("", |unit| unit.0)).to_string(), 1.0));
    }
    // A text without parentheses is a unit; a text with parentheses is a scale such as `counts(2.69 mA)`.
    let Some((kind, rest)) = text.split_once('(') else { return plain(quantity, text) };
    let (inner, after) = rest.split_once(')').ok_or_else(|| format!("`{text}`: a parenthesis is not closed"))?;
    let (kind, inner, after) = (kind.trim(), inner.trim(), after.trim());
    let positive = |x: f64| if x.is_finite() && x != 0.0 { Ok(x) } else { Err(format!("`{text}`: {x} is no size")) };
    let number =
        |word: &str| word.parse::<f64>().map_err(|_| format!("`{text}`: `{word}` is no number")).and_then(positive);
    let split = || inner.split_once(char::is_whitespace).map_or((inner, ""), |(x, unit)| (x, unit.trim()));
    let part = |share: f64| -> Result<f64, String> {
        let (x, unit) = split();
        let factor = if unit.is_empty() { 1.0 } else { plain(quantity, unit)?.1 };
        Ok(share * number(x)? * factor)
    };
    // A tick is a fraction of a turn; the other scales are multiples of a unit.
    let factor = match (kind, after, quantity) {
        ("ticks", "", Quantity::Position | Quantity::Goal) | ("ticks", "/s", Quantity::Velocity) => {
            TAU / number(inner)?
        }
        ("counts" | "count", "", _) => part(1.0)?,
        ("permille", "", _) => part(1e-3)?,
        ("percent", "", _) => part(1e-2)?,
        _ => {
            let wanted = "ticks(4096) of a turn (of a velocity ticks(4096)/s), counts(2.69 mA), permille(25 N m), \
                          percent(25 N m)";
            return Err(format!("`{text}` is no unit of a {}: {wanted}", format!("{quantity:?}").to_lowercase()));
        }
    };
    Ok((text.to_string(), factor))
}

/// The unit with this name in headers, and its factor to the SI unit.
fn plain(quantity: Quantity, text: &str) -> Result<(String, f64), String> {
    let wanted = text.to_lowercase().replace(['·', '*'], " ");
    let known = units(quantity);
    let is_it = |unit: &&(&'static str, f64)| unit.0 == wanted || written(unit.0).to_lowercase() == wanted;
    if let Some(unit) = known.iter().find(is_it) {
        return Ok((unit.0.to_string(), unit.1));
    }
    let mut names: Vec<&str> = known.iter().map(|unit| written(unit.0)).collect();
    names.dedup();
    let meant = did_you_mean(text, known.iter().map(|unit| unit.0));
    let quantity = format!("{quantity:?}").to_lowercase();
    Err(format!("`{text}` is no unit of a {quantity}{meant}; the units are {}", names.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_says_what_a_number_stands_for() {
        use Quantity::*;
        for (quantity, text, number, si) in [
            (Position, "deg", 180.0, std::f64::consts::PI),
            (Position, "°", 90.0, TAU / 4.0),
            (Position, "ticks(4096)", 1024.0, TAU / 4.0),
            (Goal, "ticks(4096)", 1024.0, TAU / 4.0),
            (Velocity, "ticks(4096)/s", -2048.0, -TAU / 2.0),
            (Velocity, "counts(0.229 rpm)", 100.0, 22.9 * TAU / 60.0),
            (Torque, "N mm", 1500.0, 1.5),
            (Torque, "N·m", 2.0, 2.0),
            (Torque, "permille(25 N m)", 100.0, 2.5),
            (Torque, "percent(25)", 10.0, 2.5),
            (Current, "counts(2.69 mA)", 1000.0, 2.69),
            (Current, "int16 counts(2.69 mA)", 64536.0, -2.69),
            (Current, "int16", 65535.0, -1.0),
            (Torque, "signbit(10) counts(0.001)", 1027.0, -0.003),
            (Time, "ms", 5.0, 0.005),
        ] {
            let unit = given_unit(quantity, text).unwrap();
            let found = unit.factor * unit.word.map_or(number, |word| word.signed(number));
            assert!((found - si).abs() < 1e-12, "{text}: {found} {si}");
        }
    }

    #[test]
    fn what_is_no_unit_is_refused_with_those_that_are() {
        use Quantity::*;
        for (quantity, text, wanted) in [
            (Torque, "Nmmm", "`Nmmm` is no unit of a torque"),
            (Position, "degres", "did you mean `degrees`?"),
            (Position, "ticks", "no unit of a position"),
            (Torque, "ticks(4096)", "no unit of a torque: ticks(4096) of a turn"),
            (Position, "ticks(0)", "0 is no size"),
            (Current, "counts(x mA)", "`x` is no number"),
            (Current, "counts(1 mA", "not closed"),
            (Current, "int99", "int8, int16 or int32"),
            (Current, "signbit(77)", "from 1 to 32"),
        ] {
            let message = given_unit(quantity, text).unwrap_err();
            assert!(message.contains(wanted), "{message}");
        }
    }
}
