//! Types of request fields for identification: the delay of the torques, and the joints that get an effect (a term of the joint
//! model, for example torque ripple, a spring or backlash).
//!
//! A request is a struct with all options of a command; each field is one option.

use identification::signals::signal_options::possible_delay;
use serde_json::{Value, json};

use super::shape::{Flag, ValueShape};
use super::types::{FieldType, last};
use crate::error::Error;

/// The coordinates that get an effect, for example torque ripple or backlash.
#[derive(Clone, Debug, PartialEq)]
pub enum JointSelector {
    /// Every coordinate.
    All,
    /// The coordinate of this name.
    Coordinate(String),
}

/// The delay of the torques relative to the positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delay {
    /// The delay is unknown and is estimated.
    Auto,
    /// The known delay, s.
    Seconds(f64),
}

impl Delay {
    fn of_text(text: &str) -> Result<Delay, String> {
        match (text, text.parse::<f64>()) {
            ("auto", _) => Ok(Delay::Auto),
            (_, Ok(seconds)) => possible_delay(seconds).map(Delay::Seconds),
            _ => Err("expected auto, or seconds".into()),
        }
    }
}

impl FieldType for Delay {
    fn shape() -> ValueShape {
        let json = json!({"anyOf": [{"type": "number"}, {"const": "auto"}]});
        let python = "float | Literal[\"auto\"]";
        ValueShape::plain("seconds, or auto", python, json, Flag::Number, |text| Delay::of_text(text).map(drop))
    }

    fn of_texts(texts: &[String]) -> Result<Delay, Error> {
        Delay::of_text(last(texts)).map_err(Error::new)
    }

    fn of_value(value: &Value) -> Result<Option<Delay>, Error> {
        match (value.as_f64(), value.as_str()) {
            (Some(seconds), _) => Ok(Some(Delay::Seconds(possible_delay(seconds).map_err(Error::new)?))),
            (_, Some("auto")) => Ok(Some(Delay::Auto)),
            _ => Ok(None),
        }
    }

    fn to_value(&self) -> Value {
        match self {
            Delay::Auto => json!("auto"),
            Delay::Seconds(seconds) => json!(seconds),
        }
    }
}

/// Parses the name of a coordinate, or `all`.
fn joint_selector(text: &str) -> JointSelector {
    if text == "all" { JointSelector::All } else { JointSelector::Coordinate(text.into()) }
}

impl FieldType for Vec<JointSelector> {
    fn shape() -> ValueShape {
        let names = json!({"type": "array", "items": {"type": "string"}});
        let json = json!({"anyOf": [{"type": "boolean"}, {"type": "string"}, names]});
        ValueShape::plain(
            "true for all joints, or a list of coordinates",
            "bool | str | Sequence[str]",
            json,
            Flag::List,
            |_| Ok(()),
        )
    }

    fn of_texts(texts: &[String]) -> Result<Self, Error> {
        Ok(texts.iter().map(|text| joint_selector(text)).collect())
    }

    fn of_value(value: &Value) -> Result<Option<Self>, Error> {
        Ok(match value {
            Value::Bool(true) => Some(vec![JointSelector::All]),
            Value::Bool(false) | Value::Null => Some(Vec::new()),
            Value::String(name) => Some(vec![joint_selector(name)]),
            Value::Array(names) => names.iter().map(|name| name.as_str().map(joint_selector)).collect(),
            _ => None,
        })
    }

    fn to_value(&self) -> Value {
        let name = |selector: &JointSelector| match selector {
            JointSelector::All => "all".to_string(),
            JointSelector::Coordinate(name) => name.clone(),
        };
        if self.is_empty() { json!(false) } else { json!(self.iter().map(name).collect::<Vec<_>>()) }
    }
}

/// Parses the number of periods of the torque ripple per turn of a joint: `q2=12`, or `12` for all joints.
fn ripple(text: &str) -> Result<(JointSelector, f64), String> {
    let (name, number) = text.split_once('=').unwrap_or(("all", text));
    let periods = number.parse().map_err(|_| format!("`{number}` is no number of periods a turn"))?;
    Ok((joint_selector(name), periods))
}

impl FieldType for Vec<(JointSelector, f64)> {
    fn shape() -> ValueShape {
        let one = json!({"anyOf": [{"type": "number"}, {"type": "array", "items": {"type": "number"}}]});
        let by_name = json!({"type": "object", "additionalProperties": one.clone()});
        let json = json!({"anyOf": [one, by_name, {"type": "null"}]});
        let expected = "periods a turn of all joints, or of some, as {\"q2\": 12} or {\"q2\": [6, 12]}";
        let python = "float | Sequence[float] | Mapping[str, float | Sequence[float]] | None";
        ValueShape::plain(expected, python, json, Flag::List, |text| ripple(text).map(drop))
    }

    fn of_texts(texts: &[String]) -> Result<Self, Error> {
        texts.iter().map(|text| ripple(text).map_err(Error::new)).collect()
    }

    fn of_value(value: &Value) -> Result<Option<Self>, Error> {
        // The value of a name is one number of periods per turn, or a list of such numbers.
        let periods = |x: &Value| match x.as_array() {
            Some(list) => list.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>(),
            None => x.as_f64().map(|one| vec![one]),
        };
        let of = |selector: JointSelector, x: &Value| {
            Some(periods(x)?.into_iter().map(|periods| (selector.clone(), periods)).collect::<Vec<_>>())
        };
        Ok(match value {
            Value::Null => Some(Vec::new()),
            Value::Object(by_name) => {
                let all: Option<Vec<Vec<_>>> = by_name.iter().map(|(name, x)| of(joint_selector(name), x)).collect();
                all.map(|all| all.concat())
            }
            for_all => of(JointSelector::All, for_all),
        })
    }

    fn to_value(&self) -> Value {
        if self.is_empty() {
            return Value::Null;
        }
        let mut by_name = serde_json::Map::new();
        for (selector, periods) in self {
            let name = if let JointSelector::Coordinate(name) = selector { name.as_str() } else { "all" };
            let entry = by_name.entry(name).or_insert_with(|| json!([]));
            if let Some(list) = entry.as_array_mut() {
                list.push(json!(periods));
            }
        }
        by_name.into()
    }
}
