//! The element tree of a xacro file, without comments. Each element states whether it is in the xacro name space.

use std::rc::Rc;

use crate::error::{Error, Place};
use crate::format::node::DescriptionFile;
use crate::format::shown::shown;
use crate::format::xml::document;

/// Largest depth of nested elements; no real robot needs more.
const MAX_ELEMENT_DEPTH: usize = 200;

#[derive(Debug)]
pub(super) struct XacroElement {
    pub tag: String,
    /// Whether the element is in the xacro name space.
    pub is_macro: bool,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Child>,
    pub file: Rc<str>,
    pub line: usize,
}

#[derive(Clone, Debug)]
pub(super) enum Child {
    Element(Rc<XacroElement>),
    Text(String),
}

impl XacroElement {
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|a| a.0 == name).map(|a| a.1.as_str())
    }

    /// The value of a required attribute. Fails if the attribute is missing.
    pub(super) fn needed(&self, name: &str) -> Result<&str, Error> {
        self.attribute(name).ok_or_else(|| self.error(format!("<xacro:{}> has no `{name}`", shown(&self.tag))))
    }

    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        Error { place: Place { file: self.file.to_string(), line: self.line, column: 0 }, message: message.into() }
    }
}

/// Reads the root element of a xacro file.
pub(super) fn read(text: &str, file: &str) -> Result<Rc<XacroElement>, Error> {
    let document = document(DescriptionFile { file }, text, "a xacro")?;
    element(document.root_element(), &Rc::from(file), 0)
}

fn element(node: roxmltree::Node, file: &Rc<str>, depth: usize) -> Result<Rc<XacroElement>, Error> {
    let line = node.document().text_pos_at(node.range().start).row as usize;
    let tag = node.tag_name();
    // The name space of xacro has several addresses (URIs) in use; all are accepted.
    let is_macro = tag.namespace().is_some_and(|space| space.trim_end_matches('/').ends_with("xacro"));
    let attributes = node.attributes().map(|a| (a.name().to_string(), a.value().to_string())).collect();
    let mut found =
        XacroElement { tag: tag.name().into(), is_macro, attributes, children: Vec::new(), file: file.clone(), line };
    if depth > MAX_ELEMENT_DEPTH {
        return Err(found.error(format!("elements stand {MAX_ELEMENT_DEPTH} deep in each other: no robot is so deep")));
    }
    for child in node.children() {
        if child.is_element() {
            found.children.push(Child::Element(element(child, file, depth + 1)?));
        } else if let Some(text) = child.text().filter(|text| child.is_text() && !text.trim().is_empty()) {
            found.children.push(Child::Text(text.into()));
        }
    }
    Ok(Rc::new(found))
}

/// Writes an element as XML to `out`. It stops if `out` is longer than `most` bytes; the text is then no valid XML.
pub(super) fn write(child: &Child, most: usize, out: &mut String) {
    if out.len() > most {
        return;
    }
    let escaped =
        |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
    match child {
        Child::Text(text) => *out += &escaped(text),
        Child::Element(element) => {
            *out += &format!("<{}", element.tag);
            for (name, value) in &element.attributes {
                *out += &format!(" {name}=\"{}\"", escaped(value));
            }
            *out += ">\n";
            element.children.iter().for_each(|child| write(child, most, out));
            *out += &format!("</{}>\n", element.tag);
        }
    }
}
