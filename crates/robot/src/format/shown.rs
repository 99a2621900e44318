//! Texts of a file in messages.

/// A text of the file, short enough for a message.
pub(in crate::format) fn shown(text: &str) -> String {
    if text.chars().count() <= 60 { text.to_string() } else { text.chars().take(57).chain("...".chars()).collect() }
}
