//! Escapes text for XML and HTML.

/// Escapes a text for use in the text and in attributes of XML and HTML.
pub fn escaped(text: &str) -> String {
    gate::shown::line(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
