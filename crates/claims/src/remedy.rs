//! Remedies for faults that a check has found. A remedy is a request: a command of the program (step) with its options, which
//! are called fields.

use std::fmt;

use serde::Serialize;

use crate::figure::Figure;

/// A request that removes a fault: the command to run (`step`) and its options (`fields`). The command line and Python each
/// print the fields in their own syntax.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Remedy {
    /// The name of the command: `identify`.
    pub step: String,
    /// Names of fields of the request, each with its value as YAML: `0.02`, `auto`, `[q2, q3]`.
    pub fields: Vec<(String, String)>,
    /// The effect of the remedy, as advice: `let the delay be found`.
    pub sentence: String,
}

impl Remedy {
    /// Makes a remedy that runs `step` without fields. `sentence`: the effect of the remedy, as advice.
    pub fn new(step: impl Into<String>, sentence: impl Into<String>) -> Remedy {
        Remedy { step: step.into(), fields: Vec::new(), sentence: sentence.into() }
    }

    /// Adds a field of the request with its value.
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

/// Whether a remedy was tried, and the effect of the remedy.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Trial {
    /// The remedy was tried. The value of a quantity is given without and with the remedy.
    Tried {
        /// The compared quantity: `residual`.
        quantity: String,
        /// The value of the quantity without the remedy.
        before: Figure,
        /// The value of the quantity with the remedy.
        after: Figure,
    },
    /// The remedy was not tried.
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
