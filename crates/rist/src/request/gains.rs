//! Types of fields that assign values to names: drive gains, values of symbols, arguments of a description file.
//!
//! A field is one option of a request (a struct with all options of a command). Example of an assignment: `q1=2.4`.

use identification::estimators::drive_gains::likelihood::Gain;
use serde_json::{Map, Value, json};

use super::shape::{Flag, ValueShape};
use super::types::FieldType;
use crate::error::Error;

/// A type of value that the user can assign to a name, as in `q1=2.4`.
trait Named: Sized {
    /// Two texts: what messages say is expected for a list of assignments, and the Python type of this list.
    const ALL: [&'static str; 2];

    /// The JSON type of one value.
    fn json() -> Value;

    /// Parses a text with one name and its value.
    fn assigned(text: &str) -> Result<(String, Self), String>;

    fn of_value(value: &Value) -> Option<Self>;

    /// The number of this value, which must be in the field's range; `None` if the value is a text.
    fn to_value(&self) -> Option<Value>;

    /// The number that must be in the field's range; `None` for a text.
    fn number(&self) -> Option<f64>;
}

impl<T: Named> FieldType for Vec<(String, T)> {
    fn shape() -> ValueShape {
        let json = json!({"anyOf": [{"type": "object", "additionalProperties": T::json()}, {"type": "null"}]});
        let [expected, python] = T::ALL;
        ValueShape::plain(expected, python, json, Flag::List, |text| T::assigned(text).map(drop))
    }

    fn of_texts(texts: &[String]) -> Result<Self, Error> {
        texts.iter().map(|text| T::assigned(text).map_err(Error::new)).collect()
    }

    fn of_value(value: &Value) -> Result<Option<Self>, Error> {
        let one = |(name, x): (&String, &Value)| Some((name.clone(), T::of_value(x)?));
        Ok(match value {
            Value::Null => Some(Vec::new()),
            _ => value.as_object().and_then(|by_name| by_name.iter().map(one).collect()),
        })
    }

    fn to_value(&self) -> Value {
        let one = |(name, x): &(String, T)| Some((name.clone(), x.to_value()?));
        let by_name: Map<String, Value> = self.iter().filter_map(one).collect();
        if by_name.is_empty() { Value::Null } else { by_name.into() }
    }

    fn numbers(&self) -> Vec<f64> {
        self.iter().filter_map(|(_, x)| x.number()).collect()
    }
}

impl Named for f64 {
    const ALL: [&'static str; 2] = ["numbers by name, as {\"q1\": 2.4}", "Mapping[str, float] | None"];

    fn json() -> Value {
        json!({"type": "number"})
    }

    /// Parses `q1=2.4`.
    fn assigned(text: &str) -> Result<(String, f64), String> {
        let (name, number) = text.split_once('=').ok_or("expected NAME=NUMBER")?;
        match number.trim().parse::<f64>() {
            Ok(x) if x.is_finite() => Ok((name.trim().into(), x)),
            _ => Err(format!("`{number}` is not a finite number")),
        }
    }

    fn of_value(value: &Value) -> Option<f64> {
        value.as_f64()
    }

    fn to_value(&self) -> Option<Value> {
        Some(json!(self))
    }

    fn number(&self) -> Option<f64> {
        Some(*self)
    }
}

impl Named for String {
    const ALL: [&'static str; 2] = ["texts by name, as {\"tool\": \"gripper\"}", "Mapping[str, str] | None"];

    fn json() -> Value {
        json!({"type": "string"})
    }

    /// Parses `tool=gripper`.
    fn assigned(text: &str) -> Result<(String, String), String> {
        let (name, value) = text.split_once('=').ok_or("expected NAME=TEXT")?;
        Ok((name.trim().into(), value.into()))
    }

    fn of_value(value: &Value) -> Option<String> {
        value.as_str().map(String::from)
    }

    fn to_value(&self) -> Option<Value> {
        Some(json!(self))
    }

    fn number(&self) -> Option<f64> {
        None
    }
}

impl Named for Gain {
    const ALL: [&'static str; 2] = [
        "gains by coordinate, as {\"q1\": 2.4}, or {\"q1\": [2.4, 0.2]} for one near 2.4",
        "Mapping[str, float | tuple[float, float]] | None",
    ];

    fn json() -> Value {
        let pair = json!({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2});
        json!({"anyOf": [{"type": "number"}, pair]})
    }

    /// Parses `q1=2.4`, or `q5=11+-2`: a gain expected near 11, with a standard deviation of 2.
    fn assigned(text: &str) -> Result<(String, Gain), String> {
        let (value, deviation) = text.split_once("+-").map_or((text, None), |(gain, d)| (gain, Some(d)));
        let (name, value) = f64::assigned(value)?;
        match deviation.map(str::parse::<f64>) {
            None => Ok((name, Gain::Known(value))),
            Some(Ok(deviation)) if deviation > 0.0 && deviation.is_finite() => {
                Ok((name, Gain::Expected(value, deviation)))
            }
            Some(_) => Err(format!("`{text}`: a positive sigma is expected behind +-")),
        }
    }

    fn of_value(value: &Value) -> Option<Gain> {
        match (value.as_f64(), value.as_array().map(Vec::as_slice)) {
            (Some(gain), _) => Some(Gain::Known(gain)),
            (_, Some([gain, deviation])) => {
                Some(Gain::Expected(gain.as_f64()?, deviation.as_f64().filter(|deviation| *deviation > 0.0)?))
            }
            _ => None,
        }
    }

    fn to_value(&self) -> Option<Value> {
        match self {
            Gain::Known(gain) => Some(json!(gain)),
            Gain::Expected(gain, deviation) => Some(json!([gain, deviation])),
            Gain::Free => None,
        }
    }

    fn number(&self) -> Option<f64> {
        match self {
            Gain::Known(gain) | Gain::Expected(gain, _) => Some(*gain),
            Gain::Free => None,
        }
    }
}
