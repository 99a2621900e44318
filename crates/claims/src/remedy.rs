//! What mends a contradiction.

use std::fmt;

use serde::Serialize;

use crate::figure::Figure;

/// A request that mends what is wrong: a step, and fields of its request. Each surface spells them for its user.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Remedy {
    /// The step to take: `identify`.
    pub step: String,
    /// Fields of its request, each with its value as YAML has it: `0.02`, `auto`, `[q2, q3]`.
    pub fields: Vec<(String, String)>,
    /// What it does, as an advice: `let the delay be found`.
    pub sentence: String,
}

impl Remedy {
    /// A step that is taken as it is.
    pub fn new(step: impl Into<String>, sentence: impl Into<String>) -> Remedy {
        Remedy { step: step.into(), fields: Vec::new(), sentence: sentence.into() }
    }

    /// The same with one field more.
    pub fn with(mut self, field: impl Into<String>, value: impl fmt::Display) -> Remedy {
        self.fields.push((field.into(), value.to_string()));
        self
    }
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fields: String = self.fields.iter().map(|(field, value)| format!(", {field} = {value}")).collect();
        write!(f, "{} ({}{fields})", self.sentence, self.step)
    }
}

/// Whether a remedy was tried.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Trial {
    /// It was, and changed a quantity.
    Tried {
        /// What is compared: `residual`.
        quantity: String,
        /// Its figure without the remedy.
        before: Figure,
        /// Its figure with it.
        after: Figure,
    },
    /// It was not.
    NotTried {
        /// A clause: `it needs another log`.
        why: String,
    },
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Trial::Tried { quantity, before, after } => write!(f, "tried: {quantity} {before} before, {after} after"),
            Trial::NotTried { why } => write!(f, "not tried, because {why}"),
        }
    }
}
