//! Types of request fields: unknowns that a fit identifies in addition to the parameters, and the mount of a base.
//!
//! The mount is the orientation of the base. A field is one option of a request (a struct with all options of a command).

use serde_json::{Value, json};

use super::shape::{Flag, ValueShape};
use super::types::{FieldType, last, plain_type};
use super::words::WordChoice;
use crate::error::Error;

words! {
    /// Unknowns that a fit identifies in addition to the parameters, each for all joints.
    pub enum UnknownKind {
        /// The mount of the base (direction of gravity).
        Mount = "mount" "",
        /// The encoder zero of each joint.
        Zeros = "zeros" "",
        /// A common factor of each joint's torque, relative to the other joints.
        Scales = "scales" "",
        /// A spring at each joint.
        Springs = "springs" "",
    }
}

fn unknown(text: &str) -> Result<UnknownKind, String> {
    UnknownKind::of_word(text).ok_or_else(|| format!("`{text}`: expected is one of mount, zeros, scales, springs"))
}

impl FieldType for Vec<UnknownKind> {
    fn shape() -> ValueShape {
        let json = json!({"type": "array", "items": <UnknownKind as FieldType>::shape().json});
        let python = "Sequence[Literal[\"mount\", \"zeros\", \"scales\", \"springs\"]]";
        let expected = "some of mount, zeros, scales, springs";
        ValueShape::plain(expected, python, json, Flag::List, |text| unknown(text).map(drop))
    }

    fn of_texts(texts: &[String]) -> Result<Self, Error> {
        texts.iter().map(|text| unknown(text).map_err(Error::new)).collect()
    }

    fn of_value(value: &Value) -> Result<Option<Self>, Error> {
        let one = |x: &Value| x.as_str().and_then(UnknownKind::of_word);
        Ok(value.as_array().and_then(|list| list.iter().map(one).collect()))
    }

    fn to_value(&self) -> Value {
        json!(self.iter().map(|unknown| unknown.word()).collect::<Vec<_>>())
    }
}

/// Parses three numbers: `0.1,0,-0.2`.
fn three(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    numbers.and_then(|x| x.try_into().ok()).ok_or_else(|| format!("`{text}`: expected are three numbers, as 0,0.1,0"))
}

fn three_numbers() -> ValueShape {
    let json = json!({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3});
    ValueShape::plain("three numbers", "Sequence[float]", json, Flag::Numbers, |text| three(text).map(drop))
}

plain_type!([f64; 3], three_numbers(), |texts| three(last(texts)).map_err(Error::new));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_numbers_and_nothing_else() {
        assert_eq!(three("-0.1, 0,3.5").unwrap(), [-0.1, 0.0, 3.5]);
        for text in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,nan", "1,2,inf"] {
            assert!(three(text).unwrap_err().contains("three numbers"), "{text}");
        }
    }

    #[test]
    fn a_word_that_is_none_is_named_with_those_that_are() {
        let said = Vec::<UnknownKind>::of_texts(&["zeros".into(), "offsets".into()]).unwrap_err().to_string();
        assert!(said.contains("`offsets`") && said.contains("mount, zeros, scales, springs"), "{said}");
    }
}
