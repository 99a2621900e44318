//! Changes attributes and elements in an XML text; comments, order and spacing stay.

use std::cmp::Reverse;
use std::ops::Range;

use roxmltree::Node;

/// Changes of a text, collected and then applied together.
pub(super) struct Edits<'a> {
    text: &'a str,
    edits: Vec<(Range<usize>, String)>,
}

impl<'a> Edits<'a> {
    /// An empty list of changes of `text`.
    pub(super) fn of(text: &'a str) -> Edits<'a> {
        Edits { text, edits: Vec::new() }
    }

    /// Applies all changes and returns the new text.
    pub(super) fn apply(mut self) -> String {
        // Changes are applied from the end of the text, so that earlier positions stay valid.
        self.edits.sort_by_key(|e| Reverse((e.0.start, e.0.end)));
        let mut text = self.text.to_string();
        self.edits.into_iter().for_each(|(range, new)| text.replace_range(range, &new));
        text
    }

    /// Replaces a range of the text by `new`.
    pub(super) fn replace(&mut self, range: Range<usize>, new: &str) {
        self.edits.push((range, new.into()));
    }

    /// Sets attributes of a child element. The child element is created if it does not exist.
    pub(super) fn set_child(&mut self, parent: &Node, tag: &str, attributes: &[(&str, String)]) {
        match parent.children().find(|n| n.has_tag_name(tag)) {
            Some(child) => self.set_attributes(&child, attributes),
            None => self.insert(parent, &tagged(tag, attributes)),
        }
    }

    /// Sets attributes of an element.
    pub(super) fn set_attributes(&mut self, node: &Node, attributes: &[(&str, String)]) {
        let mut missing = String::new();
        for (name, value) in attributes {
            match node.attribute_node(*name) {
                Some(attribute) => self.replace(attribute.range_value(), value),
                None => missing.push_str(&format!(" {name}=\"{value}\"")),
            }
        }
        if !missing.is_empty() {
            let at = node.range().start + 1 + node.tag_name().name().len();
            self.replace(at..at, &missing);
        }
    }

    /// Inserts text after the opening tag of an element; an empty element `<tag/>` gets a closing tag.
    pub(super) fn insert(&mut self, node: &Node, content: &str) {
        let range = node.range();
        let tag = node.tag_name().name();
        // The opening tag ends at the first `>` outside of quotes.
        let mut quote = None;
        let opening = self.text[range.clone()].char_indices().find(|&(_, c)| {
            match (quote, c) {
                (None, '"' | '\'') => quote = Some(c),
                (Some(q), c) if q == c => quote = None,
                (None, '>') => return true,
                _ => {}
            }
            false
        });
        let Some((end, _)) = opening else { return };
        let end = range.start + end;
        match self.text[..end].ends_with('/') {
            true => self.replace(end - 1..end + 1, &format!(">{content}</{tag}>")),
            false => self.replace(end + 1..end + 1, content),
        }
    }
}

/// Writes an element without content.
pub(super) fn tagged(tag: &str, attributes: &[(&str, String)]) -> String {
    let attributes: String = attributes.iter().map(|(k, v)| format!(" {k}=\"{v}\"")).collect();
    format!("<{tag}{attributes}/>")
}
