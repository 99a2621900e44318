//! The error type of all steps (functions that correspond to commands of
//! `rist`). The text of an error may advise another step, written `[:doctor]`, or with arguments `[:validate MODEL LOG]`. The
//! program shows this as `rist doctor`, Python as `rist.doctor`.

use std::fmt;

use robot::Place;

/// The kind of an error: the input is unusable, or the answer to the user's question is no.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The input cannot be used.
    Input,
    /// The input is valid, and the answer to the user's question is no.
    Verdict,
}

/// A message with the finding, the expectation and the remedy. Programs can read field, place and remedy separately.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    kind: ErrorKind,
    field: Option<String>,
    place: Option<Place>,
    remedy: Option<Step>,
    message: String,
}

impl Error {
    /// An error of the kind [`ErrorKind::Input`]. If the message is about a field of a request, the message starts with this
    /// field in brackets: `[gain=q9]: ..`. A step that the message advises is in brackets too: `[:doctor]`.
    pub fn new(message: impl fmt::Display) -> Error {
        let message = message.to_string();
        let is_of_name = |c: char| c.is_ascii_lowercase() || c == '_';
        let name = message.strip_prefix('[').and_then(|text| text.split(|c| !is_of_name(c)).next());
        let (field, remedy) = (name.filter(|name| !name.is_empty()).map(String::from), Step::advised(&message));
        Error { kind: ErrorKind::Input, field, place: None, remedy, message }
    }

    /// An error of the kind [`ErrorKind::Verdict`]: the input is valid, but the answer to the user's question is no.
    pub fn verdict(message: impl fmt::Display) -> Error {
        Error { kind: ErrorKind::Verdict, ..Error::new(message) }
    }

    /// Puts the name of the request's field `field` before the message, unless the message already names `field` or a file.
    pub fn about(self, field: &str) -> Error {
        let names_it = self.place.is_some() || self.message.contains(&format!("[{field}"));
        if names_it {
            return self;
        }
        Error { message: format!("[{field}]: {}", self.message), field: Some(field.into()), ..self }
    }

    /// The file and line of the mistake, if they are known. The message names them too.
    pub fn place(&self) -> Option<&Place> {
        self.place.as_ref()
    }

    /// Whether the input is unusable, or the answer to the user's question is no.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// The field of the request that the error is about, if any.
    pub fn field(&self) -> Option<&str> {
        self.field.as_deref()
    }

    /// The step of the library that the message advises, if any.
    pub fn remedy(&self) -> Option<Step> {
        self.remedy
    }

    /// Whether the input is valid and the answer to the user's question is no.
    pub fn is_verdict(&self) -> bool {
        self.kind == ErrorKind::Verdict
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

impl From<robot::Error> for Error {
    fn from(e: robot::Error) -> Error {
        Error { place: Some(e.place.clone()).filter(|place| place.line > 0), ..Error::new(e) }
    }
}

impl From<logs::Error> for Error {
    fn from(e: logs::Error) -> Error {
        let place = Place { file: e.file().into(), line: e.line(), column: 0 };
        Error { place: Some(place).filter(|place| place.line > 0), ..Error::new(e) }
    }
}

impl From<numerics::Error> for Error {
    fn from(e: numerics::Error) -> Error {
        Error::new(e)
    }
}

/// For each step: the word in texts, the command of the program, and the name in Python. Python has no `columns`, so the
/// command is listed there too.
const STEPS: [(&str, &str, &str); 14] = [
    ("accumulate", "rist accumulate", "rist.Accumulator"),
    ("check", "rist check", "rist.check"),
    ("columns", "rist columns", "rist columns"),
    ("doctor", "rist doctor", "rist.doctor"),
    ("excite", "rist excite", "rist.excite"),
    ("feedforward", "rist simulate [feedforward]", "rist.simulate(.., feedforward=estimate)"),
    ("generate", "rist generate [estimate]", "model.generate(estimate=estimate)"),
    ("identify", "rist identify", "rist.identify"),
    ("inspect", "rist inspect", "rist.Model"),
    ("plan", "rist plan", "rist.plan"),
    ("report", "rist report", "estimate.report"),
    ("validate", "rist validate", "rist.validate"),
    ("write_mjcf", "[write_mjcf]", "write_mjcf"),
    ("write_urdf", "rist identify [write_urdf]", "identify(.., consistent=True) and estimate.write_urdf"),
];

/// A step of the library: an entry of `STEPS`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step(&'static (&'static str, &'static str, &'static str));

impl Step {
    /// The step with the word `word`; `None` if the word is unknown.
    pub fn named(word: &str) -> Option<Step> {
        STEPS.iter().find(|(step, ..)| *step == word).map(Step)
    }

    /// The first step that a text advises, if any.
    pub(crate) fn advised(text: &str) -> Option<Step> {
        let (_, behind) = text.split_once("[:")?;
        Step::named(behind.split([' ', ']']).next()?)
    }

    /// The word by which texts name this step, for example `doctor`.
    pub fn word(self) -> &'static str {
        self.0.0
    }

    /// The command of the program for this step, with the arguments `given`; fields of requests stay in brackets.
    pub(crate) fn in_program(self, given: &str) -> String {
        format!("{} {given}", self.0.1).trim_end().into()
    }

    /// The call of this step in Python: the arguments `MODEL LOG` give `rist.validate(model, log)`.
    pub(crate) fn in_python(self, given: &str) -> String {
        match given.is_empty() {
            true => self.0.2.into(),
            false => format!("{}({})", self.0.2, given.to_lowercase().replace(' ', ", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_can_ask_what_an_error_is_about() {
        let input = Error::new("[gain=q9]: no such coordinate");
        assert_eq!((input.kind(), input.field(), input.remedy()), (ErrorKind::Input, Some("gain"), None));
        let no = Error::verdict("a.csv: not of this robot ([:doctor] says more; [anyway=true] takes it in)");
        assert_eq!((no.kind(), no.field(), no.remedy()), (ErrorKind::Verdict, None, Step::named("doctor")));
        assert_eq!(Error::new("expected is a number").about("rate").field(), Some("rate"));
        assert_eq!(Error::new("[-2, 2]: is none").field(), None);
    }
}
