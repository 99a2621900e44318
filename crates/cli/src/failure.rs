//! The failure of a command: a message and an exit code.
//!
//! Exit code 2: the input cannot be used. Exit code 1: the command has an answer, and the answer is no.

use std::fmt;
use std::path::Path;

use rist::Place;
use rist::request::spelling::{Audience, spelled};

/// Exit code if the input cannot be used.
pub(crate) const UNUSABLE: u8 = 2;

/// A message for the user and an exit code: 2 if the input cannot be used, 1 if the answer to the user's question is no.
pub(crate) struct Failure {
    message: String,
    code: u8,
    place: Option<Place>,
}

impl Failure {
    pub(crate) fn new(message: impl fmt::Display) -> Failure {
        Failure { message: message.to_string(), code: UNUSABLE, place: None }
    }

    /// The failure of a command that has printed its result and whose answer is no.
    pub(crate) fn verdict(message: impl fmt::Display) -> Failure {
        Failure { message: message.to_string(), code: 1, place: None }
    }

    /// The message for the user. If the faulty line of the file is known, the line follows the message.
    pub(crate) fn text(&self) -> String {
        let line = self.place.as_ref().and_then(excerpt).unwrap_or_default();
        format!("rist: {}\n{line}", spelled(&self.message, Audience::Program))
    }

    /// The exit code of the program.
    pub(crate) fn exit_code(&self) -> u8 {
        self.code
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Converts errors of `rist`, and errors of other packages that `rist::Error` includes.
impl<E: Into<rist::Error>> From<E> for Failure {
    fn from(e: E) -> Failure {
        let e: rist::Error = e.into();
        let code = if e.is_verdict() { 1 } else { UNUSABLE };
        Failure { message: e.to_string(), code, place: e.place().cloned() }
    }
}

/// Number of bytes at the start of a file in which the faulty line is searched.
const SEARCHED_BYTES: usize = 1 << 20;
/// Largest number of characters of the faulty line that are shown.
const SHOWN_CHARACTERS: usize = 100;

/// The line at `place`, with a mark below the column if the column is known. `None` if the line cannot be read again, for
/// example from a pipe.
fn excerpt(place: &Place) -> Option<String> {
    let text = rist::gate::source::glance(Path::new(&place.file), SEARCHED_BYTES)?;
    let line = text.split(|&b| b == b'\n').nth(place.line.checked_sub(1)?)?;
    Some(marked(std::str::from_utf8(line).ok()?, place))
}

fn marked(line: &str, place: &Place) -> String {
    let plain = |c: char| if rist::gate::shown::is_hidden(c) { ' ' } else { c };
    let line: Vec<char> = line.trim_end().chars().map(plain).collect();
    // If the line is long, only a part around the faulty column is shown.
    let first = if place.column > SHOWN_CHARACTERS { place.column - SHOWN_CHARACTERS / 2 } else { 0 };
    let shown: String = line.iter().skip(first).take(SHOWN_CHARACTERS).collect();
    let number = place.line.to_string();
    let margin = " ".repeat(number.len());
    let mut text = format!(" {number} | {shown}\n");
    if (1..=line.len() + 1).contains(&place.column) {
        text += &format!(" {margin} | {}^\n", " ".repeat(place.column - 1 - first));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_stands_below_the_column() {
        let place = |line, column| Place { file: String::new(), line, column };
        assert_eq!(marked("  thta: q1  ", &place(12, 3)), " 12 |   thta: q1\n    |   ^\n");
        assert_eq!(marked("a\tb", &place(1, 0)), " 1 | a b\n");
        let long = "x".repeat(300) + "!";
        let text = marked(&long, &place(7, 301));
        let [shown, mark] = text.lines().collect::<Vec<_>>()[..] else { panic!("{text}") };
        assert_eq!(shown.find('!'), mark.find('^'), "{text}");
        assert!(shown.len() < 120);
    }
}
