//! Fields with fixed choices. The user selects a choice by its word, and each word has a line of help.
//!
//! A field is one option of a request (a struct with all options of a command).

use experiments::excitation::criterion::SearchObjective;
use experiments::motion::point_trajectory::Interpolation;
use experiments::motion::profile::Profile;
use experiments::plan::exchange::Criterion;
use identification::estimators::weighted::Weights;
use linear_model::description_options::RotorInertias;
use robot::format::{AngleSnapping, Mimic};
use serde_json::json;

use super::shape::{Flag, ValueShape};
use super::types::{every_text, last};
use crate::error::Error;

/// A type with a fixed set of choices. On the command line, each choice has a word.
pub trait WordChoice: Copy + PartialEq + 'static {
    /// All choices, each with its word and a line of help.
    const WORDS: &'static [(Self, &'static str, &'static str)];

    /// The choice with the word `word`; `None` if there is no such word.
    fn of_word(word: &str) -> Option<Self> {
        Self::WORDS.iter().find(|(_, known, _)| *known == word).map(|(choice, ..)| *choice)
    }

    /// The word of this choice.
    fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(choice, ..)| *choice == self).map_or("", |(_, word, _)| word)
    }
}

/// The form of a field with the choices of `T`.
pub fn shape<T: WordChoice>() -> ValueShape {
    let words: Vec<&str> = T::WORDS.iter().map(|(_, word, _)| *word).collect();
    let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    ValueShape {
        expected: format!("one of {}", words.join(", ")),
        python: format!("Literal[{}]", quoted.join(", ")),
        json: json!({"enum": words}),
        flag: Flag::One,
        words: T::WORDS.iter().map(|(_, word, help)| (*word, *help)).collect(),
        is_file: false,
        check: every_text,
    }
}

/// Makes a type with fixed choices usable for a field, by a word and help for each choice. It can also declare the `enum`.
#[macro_export]
macro_rules! words {
    ($(#[doc = $about:literal])* pub enum $type:ident {
        $($(#[doc = $doc:literal])* $choice:ident = $word:literal $help:expr),* $(,)?
    }) => {
        $(#[doc = $about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $type {
            $($(#[doc = $doc])* $choice),*
        }

        $crate::words! { $type: $($choice = $word $help),* }
    };
    ($type:ty: $($choice:ident = $word:literal $help:expr),* $(,)?) => {
        impl $crate::request::words::WordChoice for $type {
            const WORDS: &'static [($type, &'static str, &'static str)] = &[$((<$type>::$choice, $word, $help)),*];
        }

        impl $crate::request::FieldType for $type {
            fn shape() -> $crate::request::ValueShape {
                $crate::request::words::shape::<$type>()
            }

            fn of_texts(texts: &[String]) -> Result<$type, $crate::Error> {
                $crate::request::words::of_texts(texts)
            }

            fn of_value(value: &serde_json::Value) -> Result<Option<$type>, $crate::Error> {
                Ok(value.as_str().and_then(<$type as $crate::request::words::WordChoice>::of_word))
            }

            fn to_value(&self) -> serde_json::Value {
                $crate::request::words::WordChoice::word(*self).into()
            }
        }
    };
}

/// The choice for the last text of `texts`. Fails if it is not one of the words.
pub fn of_texts<T: WordChoice>(texts: &[String]) -> Result<T, Error> {
    let word = last(texts);
    T::of_word(word).ok_or_else(|| Error::new(format_args!("`{word}`: expected is {}", shape::<T>().expected)))
}

words! { Criterion:
    Determinant = "determinant" "The determinant of the information matrix",
    FrobeniusCondition = "condition" "The condition number of the information matrix, in the Frobenius norm",
}

words! { Profile:
    BangBang = "bang-bang" "Piecewise constant, as in [Vandanjon, Gautier, Desbats 1995]",
    Smooth = "smooth" "Without jumps",
}

words! { Interpolation:
    Linear = "linear" "Straight lines, so that velocities jump at the points",
    Cubic = "cubic" "Polynomials of degree 3 through positions and velocities",
    Quintic = "quintic" "Polynomials of degree 5 through positions, velocities and accelerations",
}

words! { SearchObjective:
    Determinant = "determinant" "The determinant of the information matrix",
    Condition = "condition" "The condition number of the regressor columns, scaled to unit norm",
}

words! { Mimic:
    Constraint = "constraint" "",
    Independent = "independent" "",
}

words! { AngleSnapping:
    Meant = "meant" "",
    AsGiven = "as-given" "",
}

words! { RotorInertias:
    None = "none" "",
    Actuated = "actuated" "",
    All = "all" "",
}

words! { Weights:
    None = "none" "all equal (OLS)",
    Joint = "joint" "rows weigh by the residual of their joint (WLS)",
    Huber = "huber" "as joint, but rows with large residuals weigh less",
    Bisquare = "bisquare" "as huber, but rows with very large residuals weigh nothing",
}
