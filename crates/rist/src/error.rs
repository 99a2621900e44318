//! The reason why a step gives no result, and the steps that error texts advise: `[:doctor]`, or `[:validate MODEL LOG]`
//! with arguments.

use std::fmt;

use robot::Place;

/// Whether an error is about the input or about the question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The input: it cannot be used.
    Input,
    /// The question: the input was understood, and the answer is no.
    Verdict,
}

/// A message with the finding, the expectation and the remedy, and the same content as fields for programs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    kind: ErrorKind,
    field: Option<String>,
    place: Option<Place>,
    remedy: Option<Step>,
    message: String,
}

impl Error {
    /// Input that cannot be used. A message that is about a field of a request begins with it in brackets: `[gain=q9]: ..`; a
    /// step that it advises stands in brackets too: `[:doctor]`.
    pub fn new(message: impl fmt::Display) -> Error {
        let message = message.to_string();
        let is_of_name = |c: char| c.is_ascii_lowercase() || c == '_';
        let name = message.strip_prefix('[').and_then(|text| text.split(|c| !is_of_name(c)).next());
        let (field, remedy) = (name.filter(|name| !name.is_empty()).map(String::from), Step::advised(&message));
        Error { kind: ErrorKind::Input, field, place: None, remedy, message }
    }

    /// The input was understood, but the answer to the question is no.
    pub fn verdict(message: impl fmt::Display) -> Error {
        Error { kind: ErrorKind::Verdict, ..Error::new(message) }
    }

    /// Names `field` as the subject of the error; a message that already names this field or a file is not changed.
    pub fn about(self, field: &str) -> Error {
        let names_it = self.place.is_some() || self.message.contains(&format!("[{field}"));
        if names_it {
            return self;
        }
        Error { message: format!("[{field}]: {}", self.message), field: Some(field.into()), ..self }
    }

    /// The line of a file that is at fault, if any; it stands in the message too.
    pub fn place(&self) -> Option<&Place> {
        self.place.as_ref()
    }

    /// Whether the error is about the input or the question.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// The field of a request that it is about, if any.
    pub fn field(&self) -> Option<&str> {
        self.field.as_deref()
    }

    /// The step of the library that it advises, if any.
    pub fn remedy(&self) -> Option<Step> {
        self.remedy
    }

    /// Whether the input was read and understood, and the answer is no.
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

/// Steps: the word in texts, the command of the program, the name in Python. Python has no `columns`: its entry is the command.
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

/// A step of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step(&'static (&'static str, &'static str, &'static str));

impl Step {
    /// The step of this word; `None` where the word is unknown.
    pub fn named(word: &str) -> Option<Step> {
        STEPS.iter().find(|(step, ..)| *step == word).map(Step)
    }

    /// The first step that a text advises.
    pub(crate) fn advised(text: &str) -> Option<Step> {
        let (_, behind) = text.split_once("[:")?;
        Step::named(behind.split([' ', ']']).next()?)
    }

    /// Its word.
    pub fn word(self) -> &'static str {
        self.0.0
    }

    /// The command of the program with the arguments `given`; fields stand in brackets.
    pub(crate) fn in_program(self, given: &str) -> String {
        format!("{} {given}", self.0.1).trim_end().into()
    }

    /// The call in Python: `rist.validate(model, log)` of `MODEL LOG`.
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
