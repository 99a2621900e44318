//! The elements of an SDF: their text, numbers and places.
//!
//! A mistake is an error message with the line of the file.

use roxmltree::Node;

use robot::Note;
use robot::format::RobotDescription;

/// Largest absolute value of a number, in SI units. No robot has a larger one.
const LARGEST_NUMBER: f64 = 1e15;

/// A mistake in a text: the message and its line. Line 0: the mistake concerns the whole text.
pub(crate) struct Mistake {
    pub line: usize,
    pub message: String,
}

pub(super) fn wrong(node: Node, message: impl Into<String>) -> Mistake {
    let line = node.document().text_pos_at(node.range().start).row as usize;
    Mistake { line, message: message.into() }
}

pub(super) fn note(described: &mut RobotDescription, subject: &str, text: String) {
    described.notes.push(Note { subject: subject.into(), text });
}

pub(super) fn children<'a, 'i: 'a>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(tag))
}

pub(super) fn child<'a, 'i: 'a>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.has_tag_name(tag))
}

pub(super) fn name<'a>(node: Node<'a, '_>) -> &'a str {
    node.attribute("name").unwrap_or("")
}

pub(super) fn text<'a>(node: Node<'a, '_>) -> &'a str {
    node.text().unwrap_or("").trim()
}

pub(super) fn is_true(text: &str) -> bool {
    matches!(text.trim(), "true" | "1")
}

/// The N numbers of an element. Fails if there are more or fewer, or if one is not finite.
pub(super) fn numbers<const N: usize>(node: Node) -> Result<[f64; N], Mistake> {
    let words: Vec<Option<f64>> = text(node).split_whitespace().map(|word| word.parse().ok()).collect();
    let found: Option<Vec<f64>> = words.into_iter().collect();
    let found = found.filter(|found| found.iter().all(|x| x.abs() <= LARGEST_NUMBER));
    found.and_then(|found| found.try_into().ok()).ok_or_else(|| {
        let shown: String = text(node).chars().take(40).collect();
        wrong(node, format!("<{}> is `{shown}`; expected are {N} finite numbers", node.tag_name().name()))
    })
}
