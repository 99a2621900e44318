//! Numbers and texts by name: gains of drives, values of symbols, arguments of a description.

use identification::estimators::drive_gains::likelihood::Gain;
use serde_json::{Map, Value, json};

use super::shape::{Flag, Shape};
use super::types::FieldType;
use crate::error::Error;

/// `q1=2.4`.
fn assigned(text: &str) -> Result<(String, f64), String> {
    let (name, number) = text.split_once('=').ok_or("expected NAME=NUMBER")?;
    match number.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok((name.trim().into(), x)),
        _ => Err(format!("`{number}` is not a finite number")),
    }
}

impl FieldType for Vec<(String, f64)> {
    fn shape() -> Shape {
        let json = json!({"anyOf": [{"type": "object", "additionalProperties": {"type": "number"}}, {"type": "null"}]});
        let (expected, python) = ("numbers by name, as {\"q1\": 2.4}", "Mapping[str, float] | None");
        Shape::plain(expected, python, json, Flag::List, |text| assigned(text).map(drop))
    }

    fn of_texts(texts: &[String]) -> Result<Self, Error> {
        texts.iter().map(|text| assigned(text).map_err(Error::new)).collect()
    }

    fn of_value(value: &Value) -> Result<Option<Self>, Error> {
        let one = |(name, x): (&String, &Value)| Some((name.clone(), x.as_f64()?));
        Ok(match value {
            Value::Null => Some(Vec::new()),
            _ => value.as_object().and_then(|by_name| by_name.iter().map(one).collect()),
        })
    }

    fn to_value(&self) -> Value {
        let by_name: Map<String, Value> = self.iter().map(|(name, x)| (name.clone(), json!(x))).collect();
        if by_name.is_empty() { Value::Null } else { by_name.into() }
    }

    fn numbers(&self) -> Vec<f64> {
        self.iter().map(|(_, x)| *x).collect()
    }
}

/// `tool=gripper`.
fn told(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=TEXT")?;
    Ok((name.trim().into(), value.into()))
}

impl FieldType for Vec<(String, String)> {
    fn shape() -> Shape {
        let json = json!({"anyOf": [{"type": "object", "additionalProperties": {"type": "string"}}, {"type": "null"}]});
        let (expected, python) = ("texts by name, as {\"tool\": \"gripper\"}", "Mapping[str, str] | None");
        Shape::plain(expected, python, json, Flag::List, |text| told(text).map(drop))
    }

    fn of_texts(texts: &[String]) -> Result<Self, Error> {
        texts.iter().map(|text| told(text).map_err(Error::new)).collect()
    }

    fn of_value(value: &Value) -> Result<Option<Self>, Error> {
        let one = |(name, text): (&String, &Value)| Some((name.clone(), text.as_str()?.to_string()));
        Ok(match value {
            Value::Null => Some(Vec::new()),
            _ => value.as_object().and_then(|by_name| by_name.iter().map(one).collect()),
        })
    }

    fn to_value(&self) -> Value {
        let by_name: Map<String, Value> = self.iter().map(|(name, text)| (name.clone(), json!(text))).collect();
        if by_name.is_empty() { Value::Null } else { by_name.into() }
    }
}

/// `q1=2.4`, or `q5=11+-2`: near 11.
fn expected(text: &str) -> Result<(String, Gain), String> {
    let (value, deviation) = text.split_once("+-").map_or((text, None), |(gain, d)| (gain, Some(d)));
    let (name, value) = assigned(value)?;
    match deviation.map(str::parse::<f64>) {
        None => Ok((name, Gain::Known(value))),
        Some(Ok(deviation)) if deviation > 0.0 && deviation.is_finite() => Ok((name, Gain::Expected(value, deviation))),
        Some(_) => Err(format!("`{text}`: a positive deviation is expected behind +-")),
    }
}

impl FieldType for Vec<(String, Gain)> {
    fn shape() -> Shape {
        let pair = json!({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2});
        let one = json!({"anyOf": [{"type": "number"}, pair]});
        let json = json!({"anyOf": [{"type": "object", "additionalProperties": one}, {"type": "null"}]});
        let words = "gains by coordinate, as {\"q1\": 2.4}, or {\"q1\": [2.4, 0.2]} for one near 2.4";
        let python = "Mapping[str, float | tuple[float, float]] | None";
        Shape::plain(words, python, json, Flag::List, |text| expected(text).map(drop))
    }

    fn of_texts(texts: &[String]) -> Result<Self, Error> {
        texts.iter().map(|text| expected(text).map_err(Error::new)).collect()
    }

    fn of_value(value: &Value) -> Result<Option<Self>, Error> {
        let gain = |x: &Value| match (x.as_f64(), x.as_array().map(Vec::as_slice)) {
            (Some(gain), _) => Some(Gain::Known(gain)),
            (_, Some([gain, deviation])) => {
                Some(Gain::Expected(gain.as_f64()?, deviation.as_f64().filter(|deviation| *deviation > 0.0)?))
            }
            _ => None,
        };
        let one = |(name, x): (&String, &Value)| Some((name.clone(), gain(x)?));
        Ok(match value {
            Value::Null => Some(Vec::new()),
            _ => value.as_object().and_then(|by_name| by_name.iter().map(one).collect()),
        })
    }

    fn to_value(&self) -> Value {
        let one = |(name, gain): &(String, Gain)| match gain {
            Gain::Known(gain) => Some((name.clone(), json!(gain))),
            Gain::Expected(gain, deviation) => Some((name.clone(), json!([gain, deviation]))),
            Gain::Free => None,
        };
        let by_name: Map<String, Value> = self.iter().filter_map(one).collect();
        if by_name.is_empty() { Value::Null } else { by_name.into() }
    }

    fn numbers(&self) -> Vec<f64> {
        let number = |(_, gain): &(String, Gain)| match gain {
            Gain::Known(gain) | Gain::Expected(gain, _) => Some(*gain),
            Gain::Free => None,
        };
        self.iter().filter_map(number).collect()
    }
}
