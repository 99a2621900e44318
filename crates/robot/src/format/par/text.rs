//! Splits the text of a .par file into comments, scalars `key = value` and lists `key = {a, b, ...}`.
//!
//! Lists may extend over several lines. Commas inside parentheses do not separate items (`atan2(a, b)`). Old spellings of keys
//! are accepted. Unlike in OpenSYMORO, a line of a list may contain a comment. Two kinds of comments contain data:
//! `(* Robotname = 'NAME' *)`, and `(* Value D3 = 0.45 *)`, which gives a symbol a value. OpenSYMORO ignores comments with
//! values.

use crate::error::Error;
use crate::format::budget::MAX_DESCRIPTION_BYTES;
use crate::format::node::{DescriptionFile, Node, NodeValue};

/// A key of the file with its items, and its place.
#[derive(Clone, Debug)]
pub(super) struct ParEntry {
    pub key: String,
    pub line: usize,
    pub column: usize,
    pub items: Vec<Node>,
    pub is_list: bool,
}

#[derive(Clone, Debug, Default)]
pub(super) struct ParText {
    pub name: Option<String>,
    /// Values of symbols from comments, in the order of the file: name and value of each.
    pub values: Vec<(String, Node)>,
    pub entries: Vec<ParEntry>,
}

/// Spellings of keys in SYMORO+, each with the spelling used here.
const SYMORO_KEYS: [(&str, &str); 7] =
    [("Ant", "ant"), ("Sigma", "sigma"), ("Mu", "mu"), ("B", "b"), ("R", "r"), ("Alpha", "alpha"), ("Theta", "theta")];

pub(super) fn scan(source: DescriptionFile, text: &str) -> Result<ParText, Error> {
    if text.len() > MAX_DESCRIPTION_BYTES {
        return Err(source.error(0, 0, "the description is larger than 1 MiB"));
    }
    let mut found = ParText::default();
    let plain = without_comments(source, text, &mut found)?;
    let mut cursor = Cursor { rest: &plain, line: 1, column: 1 };
    loop {
        cursor.skip(|c| c.is_whitespace() || c == ';');
        let Some(c) = cursor.peek() else { break };
        let (line, column) = (cursor.line, cursor.column);
        let word = cursor.take(|c| c.is_alphanumeric() || c == '_');
        cursor.skip(|c| c == ' ' || c == '\t');
        if word.is_empty() || cursor.peek() != Some('=') {
            let what = if word.is_empty() { c.to_string() } else { word.chars().take(40).collect() };
            return Err(source.error(line, column, format!("expected `key = value`, found `{what}`")));
        }
        cursor.skip(|c| matches!(c, '=' | ' ' | '\t'));
        let key = SYMORO_KEYS.iter().find(|k| k.0 == word).map_or(word, |k| k.1).to_string();
        if let Some(first) = found.entries.iter().find(|e: &&ParEntry| e.key == key) {
            return Err(source.error(line, column, format!("`{key}` stands twice, first on line {}", first.line)));
        }
        let is_list = cursor.peek() == Some('{');
        let items = if is_list { list(source, &mut cursor, &key)? } else { vec![cursor.scalar()] };
        found.entries.push(ParEntry { key, line, column, items, is_list });
    }
    Ok(found)
}

/// Returns the text without comments. The data in comments is stored in `found`.
fn without_comments(source: DescriptionFile, text: &str, found: &mut ParText) -> Result<String, Error> {
    let mut plain = String::with_capacity(text.len());
    let mut cursor = Cursor { rest: text.strip_prefix('\u{feff}').unwrap_or(text), line: 1, column: 1 };
    loop {
        let Some(at) = cursor.rest.find("(*") else {
            plain.push_str(cursor.rest);
            return Ok(plain);
        };
        plain.push_str(&cursor.rest[..at]);
        cursor.advance(at);
        let (line, column) = (cursor.line, cursor.column);
        let Some(end) = cursor.rest[2..].find("*)") else {
            return Err(source.error(line, column, "a comment `(*` is never closed with `*)`"));
        };
        let comment = &cursor.rest[2..2 + end];
        carried(comment, (line, column), found);
        plain.extend(comment.chars().filter(|c| *c == '\n'));
        plain.push(' ');
        cursor.advance(end + 4);
    }
}

/// If a comment is `Robotname = 'NAME'` or `Value NAME = expression`, stores its data in `found`.
fn carried(comment: &str, at: (usize, usize), found: &mut ParText) {
    if let Some((_, rest)) = comment.split_once("Robotname") {
        let name = rest.trim_start().strip_prefix('=').and_then(|r| r.trim_start().strip_prefix('\''));
        if let Some((name, _)) = name.and_then(|n| n.split_once('\''))
            && !name.trim().is_empty()
        {
            found.name.get_or_insert(name.trim().to_string());
        }
    }
    if let Some((name, value)) = comment.trim().strip_prefix("Value ").and_then(|rest| rest.split_once('=')) {
        let node = Node { line: at.0, column: at.1, content: NodeValue::Text(value.trim().to_string()) };
        found.values.push((name.trim().to_string(), node));
    }
}

/// Reads the items of a list, from its `{` to its `}`.
fn list(source: DescriptionFile, cursor: &mut Cursor, key: &str) -> Result<Vec<Node>, Error> {
    let opened = (cursor.line, cursor.column);
    cursor.advance(1);
    let mut items = Vec::new();
    loop {
        cursor.skip(char::is_whitespace);
        let (line, column) = (cursor.line, cursor.column);
        let mut depth = 0usize;
        let text = cursor.take(|c| {
            match c {
                '(' => depth += 1,
                ')' => depth = depth.saturating_sub(1),
                _ => {}
            }
            !matches!(c, '{' | '}' | '=') && (c != ',' || depth > 0)
        });
        let text = text.trim();
        let end = cursor.peek();
        if !matches!(end, Some(',' | '}')) {
            return Err(source.place(opened, format!("the list of `{key}` is never closed with `}}`")));
        }
        cursor.advance(1);
        if text.is_empty() && !(items.is_empty() && end == Some('}')) {
            return Err(source.error(line, column, format!("item {} of `{key}` is empty", items.len() + 1)));
        }
        if !text.is_empty() {
            // A line break inside an item counts as a blank.
            let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
            items.push(Node { line, column, content: NodeValue::Text(text) });
        }
        if end == Some('}') {
            return Ok(items);
        }
    }
}

/// A position in a text, with the text after it. Lines and columns are counted from 1.
struct Cursor<'a> {
    rest: &'a str,
    line: usize,
    column: usize,
}

impl<'a> Cursor<'a> {
    fn peek(&self) -> Option<char> {
        self.rest.chars().next()
    }

    fn advance(&mut self, bytes: usize) {
        let (passed, rest) = self.rest.split_at(bytes);
        for c in passed.chars() {
            if c == '\n' {
                (self.line, self.column) = (self.line + 1, 1);
            } else {
                self.column += 1;
            }
        }
        self.rest = rest;
    }

    fn skip(&mut self, wanted: impl FnMut(char) -> bool) {
        self.take(wanted);
    }

    fn take(&mut self, mut wanted: impl FnMut(char) -> bool) -> &'a str {
        let rest = self.rest;
        let end = rest.find(|c| !wanted(c)).unwrap_or(rest.len());
        self.advance(end);
        &rest[..end]
    }

    /// Reads the remaining text of the line as a value.
    fn scalar(&mut self) -> Node {
        let (line, column) = (self.line, self.column);
        let text = self.take(|c| c != '\n');
        let text = text.trim().trim_end_matches(';').trim_end().to_string();
        Node { line, column, content: NodeValue::Text(text) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: DescriptionFile = DescriptionFile { file: "f" };

    fn texts(entry: &ParEntry) -> Vec<String> {
        entry.items.iter().map(|n| n.kind()).collect()
    }

    #[test]
    fn comments_lists_and_old_keys() {
        let text = "(* Robotname = 'RX 90' *)\nNL = 2 (* links *)\nAnt = {0,\n 1}\nalpha = {atan2(1, 2), (* no *) -Pi/2}\n\
                    (* Value D3 = 0.45 *)\n";
        let found = scan(SOURCE, text).unwrap();
        assert_eq!(found.name.as_deref(), Some("RX 90"));
        let keys: Vec<&str> = found.entries.iter().map(|e| e.key.as_str()).collect();
        assert_eq!(keys, ["NL", "ant", "alpha"]);
        assert_eq!(texts(&found.entries[0]), ["`2`"]);
        assert_eq!(texts(&found.entries[2]), ["`atan2(1, 2)`", "`-Pi/2`"]);
        assert_eq!((found.entries[1].items[1].line, found.entries[1].items[1].column), (4, 2));
        assert_eq!((found.values[0].0.as_str(), found.values[0].1.kind()), ("D3", "`0.45`".into()));
    }
}
