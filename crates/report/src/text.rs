//! Text in markup.

/// The text, escaped for text and attributes of XML and HTML.
pub fn escaped(text: &str) -> String {
    gate::shown::line(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
