//! Escapes untrusted names and texts for outputs.
//!
//! A character that is invisible, or that changes the display of its neighbours, is printed as an escape: `\u{1b}` for the start
//! of a terminal command, `\u{202e}` for a change of writing direction, `\n` for a newline. Other characters are unchanged.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a character is hidden: it is invisible or changes the display of its neighbours. Hidden characters are control
/// characters, line separators, bidirectional controls, and characters of zero width.
pub fn is_hidden(c: char) -> bool {
    let is_bidirectional =
        matches!(c, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let has_no_width = matches!(c, '\u{200b}' | '\u{2060}'..='\u{2065}' | '\u{206a}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}');
    c.is_control() || is_bidirectional || has_no_width || matches!(c, '\u{2028}' | '\u{2029}')
}

/// The text with all hidden characters escaped, so that it stays on one line.
pub fn line(text: &str) -> Cow<'_, str> {
    replaced(text, is_hidden)
}

/// The text with hidden characters escaped, except newlines and tabs.
pub fn lines(text: &str) -> Cow<'_, str> {
    replaced(text, |c| is_hidden(c) && c != '\n' && c != '\t')
}

fn replaced(text: &str, is_replaced: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_replaced) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '\n' | '\r' | '\t' if is_replaced(c) => out.extend(c.escape_debug()),
            _ if is_replaced(c) => out.extend(c.escape_unicode()),
            _ => out.push(c),
        }
    }
    Cow::Owned(out)
}

/// JSON text with hidden characters written as JSON escapes. The JSON values do not change.
pub fn json(text: &str) -> Cow<'_, str> {
    let is_replaced = |c: char| is_hidden(c) && c != '\n';
    if !text.contains(is_replaced) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_replaced(c) {
            // All hidden characters are below U+10000, so one JSON escape is enough. Writing to a string cannot fail.
            let _ = write!(out, "\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

/// The text as one line of Markdown, with the markup of Markdown and HTML escaped.
pub fn markdown(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in line(text).chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '\\' | '|' | '[' | ']' | '`' | '*' => out.extend(['\\', c]),
            _ => out.push(c),
        }
    }
    out
}

/// The text as one line of Markdown code, which is also valid in a table cell: a bar is escaped, and a backtick becomes an
/// apostrophe.
pub fn markdown_code(text: &str) -> String {
    format!("`{}`", line(text).replace('`', "'").replace('|', "\\|"))
}

/// The name as one CSV cell. The cell is in quotation marks if the name contains a delimiter, a quotation mark, `#` or outer
/// blanks.
pub fn csv_cell(name: &str) -> Cow<'_, str> {
    let name = line(name);
    let is_quoted = name.contains([',', ';', '"', '#']) || name.trim() != name;
    if is_quoted { Cow::Owned(format!("\"{}\"", name.replace('"', "\"\""))) } else { name }
}

/// The name as part of a file name: characters with a special meaning for folders, drives or shells become `_`.
pub fn file_name(name: &str) -> String {
    let taken = |c: char| is_hidden(c) || matches!(c, '/' | '\\' | ':' | '*' | '?' | '"' | '<' | '>' | '|');
    let name: String = name.chars().map(|c| if taken(c) { '_' } else { c }).collect();
    if name.trim_matches('.').is_empty() { "_".repeat(name.len().max(1)) } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EVIL: &str = "a\u{1b}[31m\n\u{202e}|<b>,[x](y)/..";

    #[test]
    fn what_is_hidden_is_shown() {
        assert_eq!(line("q1 \u{e9}\u{4e2d}"), "q1 \u{e9}\u{4e2d}");
        assert_eq!(line(EVIL), "a\\u{1b}[31m\\n\\u{202e}|<b>,[x](y)/..");
        assert_eq!(lines("a\n\tb\r"), "a\n\tb\\r");
        assert_eq!(json("{\n\"a\": \"\u{202e}\"}"), "{\n\"a\": \"\\u202e\"}");
        for text in [line(EVIL).into_owned(), markdown(EVIL), csv_cell(EVIL).into_owned(), file_name(EVIL)] {
            assert!(!text.contains(is_hidden), "{text:?}");
        }
    }

    #[test]
    fn a_name_stays_one_cell_one_link_one_file() {
        assert_eq!(markdown("[a](b)|<i>"), "\\[a\\](b)\\|&lt;i&gt;");
        assert_eq!(csv_cell("tau_j,1"), "\"tau_j,1\"");
        assert_eq!(csv_cell("j\"1\""), "\"j\"\"1\"\"\"");
        assert_eq!(csv_cell("tau_q1"), "tau_q1");
        assert_eq!(file_name("left/arm"), "left_arm");
        assert_eq!(file_name(".."), "__");
        assert_eq!(file_name(""), "_");
    }
}
