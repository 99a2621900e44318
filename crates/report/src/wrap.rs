//! Text for a terminal: lines that are broken between words, and tables as wide as their content.

use std::fmt::Write;

/// A paragraph within `width`, its first line indented by `first`, the others by `rest`. A word longer than a line stays
/// whole.
pub fn wrapped(text: &str, first: usize, rest: usize, width: usize) -> String {
    let leading = text.chars().take_while(|c| *c == ' ').count();
    let mut s = " ".repeat(first + leading);
    let mut column = first + leading;
    let mut is_first = true;
    // Blanks between words are kept where the line goes on: they align.
    for word in words(&text[leading..]) {
        let length = word.trim_end().chars().count();
        if !is_first && column + length > width {
            s.truncate(s.trim_end().len());
            let _ = write!(s, "\n{}", " ".repeat(rest));
            column = rest;
        }
        s += word;
        column += word.chars().count();
        is_first = false;
    }
    s.truncate(s.trim_end().len());
    s + "\n"
}

/// Words with the blanks behind them.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let end = rest.find(' ')?;
        let behind = rest[end..].find(|c| c != ' ').map_or(rest.len(), |more| end + more);
        let (word, more) = rest.split_at(behind);
        rest = more;
        Some(word)
    })
    .chain(text.rsplit(' ').next().filter(|last| !last.is_empty()))
}

/// A column of a table.
pub struct Column {
    /// Above it.
    pub head: &'static str,
}

/// A table of left-aligned columns; the last is wrapped within `width`.
pub fn table(columns: &[Column], rows: &[Vec<String>], width: usize) -> String {
    let wide = |c: usize| {
        let cells = rows.iter().map(|row| row[c].chars().count());
        cells.chain([columns[c].head.chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns.len()).map(wide).collect();
    let before: usize = widths.iter().rev().skip(1).map(|w| w + 2).sum();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let mut text = String::new();
        for (cell, w) in cells.zip(&widths) {
            let _ = write!(text, "{cell:<w$}  ");
        }
        wrapped(text.trim_end(), 0, before.min(width / 2), width)
    };
    let mut s = line(&mut columns.iter().map(|c| c.head));
    rows.iter().for_each(|row| s += &line(&mut row.iter().map(String::as_str)));
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_words() {
        assert_eq!(wrapped("one two three four", 0, 2, 9), "one two\n  three\n  four\n");
        assert_eq!(wrapped("ZZR1  a b", 1, 3, 80), " ZZR1  a b\n");
        assert_eq!(wrapped("averylongword next", 0, 1, 5), "averylongword\n next\n");
        assert_eq!((wrapped("", 0, 0, 5), wrapped("  x", 0, 4, 5)), ("\n".into(), "  x\n".into()));
    }

    #[test]
    fn columns_stand_below_their_heads() {
        let rows = [vec!["1".into(), "upper arm".into()], vec!["2".into(), "tool".into()]];
        let text = table(&[Column { head: "link" }, Column { head: "name" }], &rows, 80);
        assert_eq!(text, "link  name\n1     upper arm\n2     tool\n");
    }
}
