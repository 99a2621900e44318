//! The option for the friction terms of an identification: the user gives the terms, or rist chooses them.
//!
//! A friction term is, for example, viscous or Coulomb friction, with one parameter per joint.

use linear_model::friction::terms::{FrictionTerm, JointTerm};
use serde_json::{Value, json};

use super::shape::{Flag, ValueShape};
use super::types::FieldType;
use crate::error::Error;

/// The choice of friction terms for every joint.
#[derive(Clone, Debug, PartialEq)]
pub enum FrictionChoice {
    /// The set of terms with the smallest error on held-out segments of the logs.
    Auto,
    /// The given terms; empty: no friction.
    Terms(Vec<FrictionTerm>),
}

impl FrictionChoice {
    /// Parses a choice from words: terms such as `viscous`, `stribeck=0.1`, or a single word `none` or `auto`.
    fn of_words<'a>(words: impl IntoIterator<Item = &'a str>) -> Result<FrictionChoice, Error> {
        let words: Vec<&str> = words.into_iter().map(str::trim).collect();
        match words.as_slice() {
            ["auto"] => return Ok(FrictionChoice::Auto),
            ["none"] => return Ok(FrictionChoice::Terms(Vec::new())),
            _ => {}
        }
        if words.iter().any(|word| ["auto", "none"].contains(word)) {
            return Err(Error::new("auto and none stand alone"));
        }
        let terms: Vec<FrictionTerm> =
            words.iter().map(|word| FrictionTerm::of_word(word).map_err(Error::new)).collect::<Result<_, _>>()?;
        match (1..terms.len()).find(|&i| terms[..i].contains(&terms[i])) {
            Some(i) => Err(Error::new(format_args!("word {} stands there twice", i + 1))),
            None => Ok(FrictionChoice::Terms(terms)),
        }
    }

    /// The given terms; `None` if they are chosen automatically.
    pub fn terms(&self) -> Option<&[FrictionTerm]> {
        match self {
            FrictionChoice::Auto => None,
            FrictionChoice::Terms(terms) => Some(terms),
        }
    }
}

/// The friction terms for a plan or a motion, for which no torques are measured yet. If the request names no terms, these are the
/// standard terms.
///
/// Fails for the automatic choice, which needs a log, and for terms that need a measured torque or belong to a single joint.
pub fn terms_without_torque(asked: Option<&FrictionChoice>) -> Result<Vec<FrictionTerm>, Error> {
    match asked {
        None => Ok(FrictionTerm::STANDARD.to_vec()),
        Some(FrictionChoice::Auto) => Err(Error::new("[friction]: name the terms, or none alone; auto needs a log")),
        Some(FrictionChoice::Terms(terms)) if terms.contains(&FrictionTerm::Load) => {
            Err(Error::new("[friction=load] needs a measured torque; a motion that is still to be run has none"))
        }
        Some(FrictionChoice::Terms(terms)) => match terms.iter().find(|term| term.is_of_one_joint()) {
            Some(term) => Err(Error::new(format_args!(
                "[friction={term}] is the term of a single joint, and a motion is made for the terms of all joints: leave it out"
            ))),
            None => Ok(terms.clone()),
        },
    }
}

impl FieldType for FrictionChoice {
    fn shape() -> ValueShape {
        let json = json!({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]});
        let check: fn(&str) -> Result<(), String> = |text| match text {
            "auto" | "none" => Ok(()),
            _ => FrictionTerm::of_word(text).map(drop),
        };
        ValueShape::plain(
            "words such as viscous,coulomb,offset, or a list of them",
            "str | Sequence[str]",
            json,
            Flag::List,
            check,
        )
    }

    fn of_texts(texts: &[String]) -> Result<FrictionChoice, Error> {
        FrictionChoice::of_words(texts.iter().map(String::as_str))
    }

    fn of_value(value: &Value) -> Result<Option<FrictionChoice>, Error> {
        if let Some(text) = value.as_str() {
            return FrictionChoice::of_words(text.split(',')).map(Some);
        }
        match value.as_array().and_then(|list| list.iter().map(Value::as_str).collect::<Option<Vec<_>>>()) {
            Some(words) if words.is_empty() => Ok(Some(FrictionChoice::Terms(Vec::new()))),
            Some(words) => FrictionChoice::of_words(words).map(Some),
            None => Ok(None),
        }
    }

    fn to_value(&self) -> Value {
        match self {
            FrictionChoice::Auto => json!("auto"),
            FrictionChoice::Terms(terms) if terms.is_empty() => json!("none"),
            FrictionChoice::Terms(terms) => json!(terms.iter().map(word).collect::<Vec<_>>().join(",")),
        }
    }
}

/// The friction terms in the spelling of the command line, separated by commas.
pub(super) fn words(terms: &[FrictionTerm]) -> String {
    terms.iter().map(word).collect::<Vec<_>>().join(",")
}

/// A friction term in the spelling of the command line. A speed in it is written with all its digits.
fn word(term: &FrictionTerm) -> String {
    match term {
        FrictionTerm::SmoothCoulomb(speed) => format!("smooth-coulomb={speed}"),
        FrictionTerm::Stribeck(speed) => format!("stribeck={speed}"),
        FrictionTerm::At(number, JointTerm::Stribeck(speed)) => format!("stribeck={speed}@{number}"),
        plain => plain.to_string(),
    }
}
