//! Texts of a file in messages.

/// Largest length of a text in a message, characters, with the dots of a shortened one.
const SHOWN_CHARACTERS: usize = 60;

/// A text of the file, short enough for a message.
pub(in crate::format) fn shown(text: &str) -> String {
    match text.chars().count() <= SHOWN_CHARACTERS {
        true => text.to_string(),
        false => text.chars().take(SHOWN_CHARACTERS - 3).chain("...".chars()).collect(),
    }
}
