//! Remedies of contradictions.

use std::fmt;

use serde::Serialize;

use crate::figure::Figure;

/// A request that removes a fault: a step, and fields of its request. The program and Python spell them for their users.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Remedy {
    /// The step: `identify`.
    pub step: String,
    /// Fields of its request, each with its value as YAML: `0.02`, `auto`, `[q2, q3]`.
    pub fields: Vec<(String, String)>,
    /// Its effect, as an advice: `let the delay be found`.
    pub sentence: String,
}

impl Remedy {
    /// A step without fields.
    pub fn new(step: impl Into<String>, sentence: impl Into<String>) -> Remedy {
        Remedy { step: step.into(), fields: Vec::new(), sentence: sentence.into() }
    }

    /// Adds a field.
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
    /// It was tried, and changed a quantity.
    Tried {
        /// The compared quantity: `residual`.
        quantity: String,
        /// Its value without the remedy.
        before: Figure,
        /// Its value with the remedy.
        after: Figure,
    },
    /// It was not tried.
    NotTried {
        /// The reason, as a clause: `it needs another log`.
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
