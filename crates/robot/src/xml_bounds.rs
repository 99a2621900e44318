//! Bounds for the size of an XML text, and a check of them.

/// Largest number of nodes in an XML text; no real robot needs more.
pub const MAX_XML_NODES: u32 = 2_000_000;
/// Largest number of attributes of an XML element. The time to find a duplicate grows with the square of their number.
pub const MAX_ATTRIBUTES_PER_ELEMENT: usize = 256;

/// Line and tag of the first element that has too many attributes; `None` if there is none.
pub fn crowded(text: &str) -> Option<(usize, &str)> {
    let tags = text.match_indices('<').map(|(at, _)| (at, &text[at + 1..]));
    let is_element = |rest: &str| !rest.starts_with(['!', '?', '/']);
    let inside =
        tags.filter(|(_, rest)| is_element(rest)).map(|(at, rest)| (at, rest.split('>').next().unwrap_or(rest)));
    let (at, tag) = { inside }
        .find(|(_, tag)| tag.matches('=').take(MAX_ATTRIBUTES_PER_ELEMENT + 1).count() > MAX_ATTRIBUTES_PER_ELEMENT)?;
    Some((1 + text[..at].matches('\n').count(), tag.split_whitespace().next().unwrap_or("")))
}
