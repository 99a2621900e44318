//! Shortens texts of a file for messages.

/// Largest length of a text in a message, characters. It includes the dots at the end of a shortened text.
const SHOWN_CHARACTERS: usize = 60;

/// The text of a file, shortened for a message.
pub(in crate::format) fn shown(text: &str) -> String {
    match text.chars().count() <= SHOWN_CHARACTERS {
        true => text.to_string(),
        false => text.chars().take(SHOWN_CHARACTERS - 3).chain("...".chars()).collect(),
    }
}
