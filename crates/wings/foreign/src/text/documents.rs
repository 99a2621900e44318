//! Reads texts with one document per sample: YAML, as `ros2 topic echo` prints messages, and XML, as KUKA RSI sends them.
//!
//! In XML, an attribute becomes a column with the name element.attribute (`AIPos.A1`). The text of an element becomes a column
//! with the name of the element (`IPOC`). The root element is not part of the names.

use logs::reading::{Budget, Records, TextHead, add_document, named, number};
use logs::{Error, Table};
use robot::xml_bounds::{MAX_ATTRIBUTES_PER_ELEMENT, crowded};

use serde_json::Value;

/// The line that separates two YAML documents.
const SEPARATOR: &str = "---";
/// Spellings of infinite numbers and NaN in YAML; here they count as missing.
const NOT_FINITE: [&str; 4] = ["-.inf", ".inf", ".nan", ".NaN"];
/// Largest memory of a parsed document, in bytes per byte of its text.
const MEMORY_PER_BYTE: usize = size_of::<Value>();

/// Whether the first lines of a text are YAML documents: they contain a separator, and the first other line begins with a key.
pub(crate) fn is_yaml(head: &TextHead) -> bool {
    let is_key = |line: &&&str| {
        line.split_once(':').is_some_and(|(key, _)| key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_'))
    };
    head.lines.contains(&SEPARATOR) && head.lines.iter().find(|line| **line != SEPARATOR).as_ref().is_some_and(is_key)
}

/// Reads YAML documents as a table with one row per document. Fails if a document is not YAML, or if none contains a number.
pub(crate) fn read_yaml(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let text = utf8(file, bytes)?;
    let mut rows = Records::new(budget);
    let mut documents = vec![(1, 0..0)];
    let mut at = 0;
    for (k, line) in text.split_inclusive('\n').enumerate() {
        let next = at + line.len();
        if line.trim_end() == SEPARATOR {
            documents.push((k + 2, next..next));
        } else if let Some((_, document)) = documents.last_mut() {
            document.end = next;
        }
        at = next;
    }
    for (line, document) in documents.into_iter().filter(|(_, range)| !text[range.clone()].trim().is_empty()) {
        let failed = |e: String| Error::at(file, line, format!("this is no YAML of a message: {e}"));
        rows.budget.clone().draw(document.len().saturating_mul(MEMORY_PER_BYTE)).map_err(failed)?;
        let document = NOT_FINITE.iter().fold(text[document].to_string(), |text, word| text.replace(word, "null"));
        let value: Value = serde_yaml::from_str(&document).map_err(|e| failed(e.to_string()))?;
        add_document(&mut rows, &value).map_err(|e| failed(e.to_string()))?;
        rows.end_row(line).map_err(failed)?;
    }
    rows.into_table(file, "a message with numbers")
}

/// The name of the first element.
fn root(text: &str) -> Option<&str> {
    let begin = text.match_indices('<').find(|(at, _)| text[at + 1..].starts_with(char::is_alphabetic))?.0 + 1;
    let length = text[begin..].find(|c: char| c.is_whitespace() || matches!(c, '>' | '/'))?;
    Some(&text[begin..begin + length])
}

/// Whether the first lines of a text contain the end of the same root element at least twice.
pub(crate) fn is_xml(head: &TextHead) -> bool {
    let Some(first) = head.lines.first().filter(|line| line.trim_start().starts_with('<')) else { return false };
    let text = head.lines.join("\n");
    root(first).or(root(&text)).is_some_and(|root| text.matches(&format!("</{root}>")).count() > 1)
}

/// Reads XML elements as a table with one row per root element. Fails if an element is not XML, or if none contains a number.
pub(crate) fn read_xml(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let text = utf8(file, bytes)?;
    let end = format!("</{}>", root(text).unwrap_or_default());
    let mut rows = Records::new(budget);
    let mut line = 1;
    for element in text.split_inclusive(&end) {
        let begin = element.len() - element.trim_start().len();
        line += element[..begin].matches('\n').count();
        let failed = |e: String| Error::at(file, line, format!("this is no element of XML: {e}"));
        let trimmed = element.trim();
        if !trimmed.is_empty() {
            // roxmltree compares each attribute of an element with all others.
            if let Some((line_in, _)) = crowded(trimmed) {
                let message = format!("more than {MAX_ATTRIBUTES_PER_ELEMENT} attributes");
                return Err(Error::at(file, line + line_in - 1, message));
            }
            let document = roxmltree::Document::parse(trimmed).map_err(|e| failed(e.to_string()))?;
            values(document.root_element(), "", &mut rows).map_err(failed)?;
            rows.end_row(line).map_err(failed)?;
        }
        line += element[begin..].matches('\n').count();
    }
    rows.into_table(file, "an element with numbers")
}

/// Adds the attributes and the text of an element, and of all elements in it, to the current row. `name`: path of the element.
fn values(element: roxmltree::Node, name: &str, rows: &mut Records) -> Result<(), String> {
    let mut set = |name: &str, text: &str| match number(text.trim().as_bytes(), None) {
        Some(x) => rows.set(name, x),
        None => rows.set_text(name, text),
    };
    for attribute in element.attributes() {
        set(&named(name, attribute.name(), '.')?, attribute.value())?;
    }
    let text = element.text().unwrap_or_default();
    if !name.is_empty() && !text.trim().is_empty() {
        set(name, text)?;
    }
    for inner in element.children().filter(roxmltree::Node::is_element) {
        values(inner, &named(name, inner.tag_name().name(), '.')?, rows)?;
    }
    Ok(())
}

fn utf8<'a>(file: &str, bytes: &'a [u8]) -> Result<&'a str, Error> {
    let text = std::str::from_utf8(bytes).map_err(|e| Error::at(file, 0, format!("this text is no UTF-8: {e}")))?;
    Ok(text.trim_start_matches('\u{feff}'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<Table, String> {
        crate::text::table(text).map_err(|e| e.to_string())
    }

    #[test]
    fn messages_are_rows_and_joints_have_their_names() {
        let message = |sec: usize, q: f64| {
            format!(
                "header:\n  stamp:\n    sec: {sec}\n    nanosec: 5\nname:\n- b\n- a\nposition:\n- {q}\n- 2.0\neffort: [.nan, 3]\n---\n"
            )
        };
        let found = table(&format!("{}{}", message(7, 1.0), message(8, 1.5))).unwrap();
        let column = |name: &str| &found.columns[found.header.iter().position(|h| h == name).unwrap()];
        assert_eq!((column("header.stamp.sec"), column("position_b")), (&vec![7.0, 8.0], &vec![1.0, 1.5]));
        assert_eq!((column("position_a"), column("effort_a"), found.line(1)), (&vec![2.0; 2], &vec![3.0; 2], 13));
        let broken = table(&format!("{}position: [1\n---\n", message(7, 1.0))).unwrap_err();
        assert!(broken.contains("x:13: this is no YAML of a message"), "{broken}");
    }

    #[test]
    fn elements_are_rows() {
        let element = |q: f64, ipoc: usize| {
            format!("<Rob Type=\"KUKA\"><AIPos A1=\"{q}\" A2=\"2\"/><Delay D=\"0\"/><IPOC>{ipoc}</IPOC></Rob>\r\n")
        };
        let found = table(&format!("<?xml version=\"1.0\"?>\n{}{}", element(1.0, 4), element(1.5, 8))).unwrap();
        assert_eq!(found.header, ["Type", "AIPos.A1", "AIPos.A2", "Delay.D", "IPOC"]);
        assert_eq!((&found.columns[1], &found.columns[4]), (&vec![1.0, 1.5], &vec![4.0, 8.0]));
        assert_eq!((found.line(1), &found.texts[0]), (3, &Some((1, "KUKA".into()))));
        let broken = table(&format!("{}{}<Rob><A></Rob>", element(1.0, 4), element(1.0, 8))).unwrap_err();
        assert!(broken.contains("x:3: this is no element of XML"), "{broken}");
        // A text with a single root element is a description of a robot, not a log.
        assert!(!is_xml(&TextHead {
            bytes: b"",
            lines: vec!["<robot name=\"a\">", "</robot>"],
            rows: vec![],
            delimiter: None
        }));
    }
}
