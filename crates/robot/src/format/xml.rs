//! Parses an XML text, with limits on its size. Every XML reader starts with this function.

use roxmltree::{Document, Node, ParsingOptions};

use crate::error::Error;
use crate::format::node::DescriptionFile;
use crate::format::shown::shown;
use crate::xml_bounds::{MAX_ATTRIBUTES_PER_ELEMENT, MAX_XML_NODES, crowded};

/// Parses an XML text. `kind`: the expected format, for messages.
///
/// Fails, with the place, if the text is not XML or exceeds the bounds.
pub(in crate::format) fn document<'a>(
    source: DescriptionFile,
    text: &'a str,
    kind: &str,
) -> Result<Document<'a>, Error> {
    if let Some((line, tag)) = crowded(text) {
        let message =
            format!("<{}> has more than {MAX_ATTRIBUTES_PER_ELEMENT} attributes: no element of {kind} has", shown(tag));
        return Err(source.error(line, 0, message));
    }
    let options = ParsingOptions { nodes_limit: MAX_XML_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|e| {
        // An element that is not closed is reported at the end of the text.
        let at = match e {
            roxmltree::Error::UnclosedRootNode => roxmltree::TextPos::new(text.lines().count() as u32, 0),
            _ => e.pos(),
        };
        let message = e.to_string();
        // The library writes line and column at the end of its messages. Our messages start with line and column, so they are
        // removed at the end.
        let message = message.split(" at ").next().unwrap_or("").to_string();
        let message = if message.contains("DTD") { format!("{message}: take the <!DOCTYPE> out") } else { message };
        let message = if text.trim().is_empty() { "the file is empty".into() } else { message };
        source.error(at.row as usize, at.col as usize, format!("not valid XML: {message}"))
    })
}

/// The first mistake for which a text is not valid XML within the bounds. `None` if there is no mistake, or if the text exceeds
/// the bounds.
pub(in crate::format) fn mistake(text: &str) -> Option<roxmltree::Error> {
    let options = ParsingOptions { nodes_limit: MAX_XML_NODES, ..ParsingOptions::default() };
    crowded(text).is_none().then(|| Document::parse_with_options(text, options).err())?
}

/// The first child element with this tag.
pub(in crate::format) fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|n| n.has_tag_name(tag))
}

/// The tag of the first element of a text, without its name space prefix. Empty if there is no element.
pub(in crate::format) fn root_tag(text: &str) -> &str {
    let mut rest = text.trim_start_matches('\u{feff}').trim_start();
    loop {
        let end = match rest {
            _ if rest.starts_with("<!--") => "-->",
            _ if rest.starts_with("<?") => "?>",
            _ if rest.starts_with("<!") => ">",
            _ => break,
        };
        let Some((_, after)) = rest.split_once(end) else { return "" };
        rest = after.trim_start();
    }
    let tag = rest.strip_prefix('<').unwrap_or("");
    let tag = tag.split(|c: char| c.is_whitespace() || matches!(c, '>' | '/')).next().unwrap_or("");
    tag.rsplit(':').next().unwrap_or(tag)
}

#[cfg(test)]
mod tests {
    use super::root_tag;

    #[test]
    fn the_first_element_is_found_behind_what_stands_before_it() {
        let text = "\u{feff}<?xml version=\"1.0\"?>\n<!DOCTYPE robot>\n<!-- <robot> -->\n<mujoco model=\"x\">";
        assert_eq!(root_tag(text), "mujoco");
        assert_eq!(["<robot/>", "<a:sdf>", "<!-- ", "name: x"].map(root_tag), ["robot", "sdf", "", ""]);
    }
}
