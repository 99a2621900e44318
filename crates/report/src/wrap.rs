//! Formats text for a terminal: breaks lines between words, and lays out tables.

use std::fmt::Write;

/// Breaks a paragraph into lines of at most `width` characters. The first line is indented by `first` characters, the other
/// lines by `rest`. A word that is longer than a line is not broken.
pub fn wrapped(text: &str, first: usize, rest: usize, width: usize) -> String {
    let leading = text.chars().take_while(|c| *c == ' ').count();
    let mut s = " ".repeat(first + leading);
    let mut column = first + leading;
    let mut is_first = true;
    // Spaces between words of one line are kept, because such spaces align columns.
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

/// The words of a text, each with the spaces after it.
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

/// Indentation of the last column of a table if this column is printed below its row.
const INDENT_BELOW_ROW: usize = 6;

/// Writes a table with left-aligned columns. If the table is wider than `width`, the last column of each row is printed below
/// the row.
pub fn table(heads: &[&str], rows: &[Vec<String>], width: usize) -> String {
    let wide = |c: usize| {
        let cells = rows.iter().map(|row| row[c].chars().count());
        cells.chain([heads[c].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..heads.len()).map(wide).collect();
    let total: usize = widths.iter().map(|w| w + 2).sum();
    let in_row = if total <= width + 2 { heads.len() } else { heads.len().saturating_sub(1) };
    let line = |cells: &[&str]| {
        let padded = cells[..in_row].iter().zip(&widths).map(|(cell, w)| format!("{cell:<w$}  "));
        let mut text = padded.collect::<String>().trim_end().to_string() + "\n";
        for cell in cells[in_row..].iter().filter(|cell| !cell.is_empty()) {
            text += &wrapped(cell, INDENT_BELOW_ROW, INDENT_BELOW_ROW + 2, width);
        }
        text
    };
    let rows = rows.iter().map(|row| line(&row.iter().map(String::as_str).collect::<Vec<_>>()));
    [line(heads)].into_iter().chain(rows).collect()
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
        let text = |width: usize| table(&["link", "name"], &rows, width);
        assert_eq!(text(80), "link  name\n1     upper arm\n2     tool\n");
        assert_eq!(text(12), "link\n      name\n1\n      upper\n        arm\n2\n      tool\n");
    }
}
