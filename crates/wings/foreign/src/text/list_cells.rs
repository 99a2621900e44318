//! Reads delimited texts with lists in their cells, as pandas and NumPy write them: `0.0,"[1.0, 2.0]","[3.0 4.0]"`.
//!
//! A list becomes the columns name_1 .. name_k. It may be in quotation marks or not, and its numbers may be separated by commas,
//! semicolons or blanks.

use logs::reading::{Budget, Records, TextHead, number, rows};
use logs::{Error, Table};

/// The numbers of a text such as `[1, 2]`, `array([1. 2.])` or `(1, 2)`; `None` if the text is no list of numbers.
pub(crate) fn numbers_of_list(text: &str) -> Option<Vec<f64>> {
    let open = text.find(['[', '('])?;
    let inner = text[open..].trim_matches(|c: char| matches!(c, '[' | ']' | '(' | ')') || c.is_whitespace());
    let all = inner.split(|c: char| matches!(c, ',' | ';') || c.is_whitespace()).filter(|word| !word.is_empty());
    all.map(|word| number(word.as_bytes(), Some(b','))).collect()
}

fn is_list(cell: &str) -> bool {
    let end = cell.trim_end();
    end.ends_with([']', ')']) && end.contains(['[', '(']) && numbers_of_list(end).is_some_and(|all| !all.is_empty())
}

/// The cells of a row, where cells of one list are joined again: a delimiter inside brackets does not separate cells.
fn unbroken(cells: Vec<String>, delimiter: Option<u8>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    let mut is_open = false;
    for cell in cells {
        match all.last_mut().filter(|_| is_open) {
            Some(last) => *last = format!("{last}{}{cell}", delimiter.map_or(' ', char::from)),
            None => all.push(cell),
        }
        let last = all.last().map_or("", String::as_str);
        is_open = last.matches('[').count() > last.matches(']').count();
    }
    all
}

/// Whether the row after the header has as many cells as the header, and one of them is a list.
pub(crate) fn is_so(head: &TextHead) -> bool {
    let [header, row, ..] = head.rows.as_slice() else { return false };
    let row = unbroken(row.clone(), head.delimiter);
    row.len() == header.len() && row.iter().any(|cell| is_list(cell))
}

/// Reads a text with lists in its cells as a table. Fails if there are too many columns.
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let delimiter = TextHead::delimiter_of(bytes);
    let mut all = rows(bytes, delimiter);
    let header = all.next().map(|(_, cells)| cells).unwrap_or_default();
    let mut found = Records::new(budget);
    for (line, cells) in all {
        let set = || {
            for (name, cell) in header.iter().zip(unbroken(cells, delimiter)) {
                if is_list(&cell) {
                    let values = numbers_of_list(&cell).unwrap_or_default();
                    values.iter().enumerate().try_for_each(|(k, x)| found.set(&format!("{name}_{}", k + 1), *x))?;
                } else if let Some(x) = number(cell.as_bytes(), delimiter) {
                    found.set(name, x)?;
                } else {
                    found.set_text(name, &cell)?;
                }
            }
            found.end_row(line)
        };
        set().map_err(|e: String| Error::at(file, line, e))?;
    }
    found.into_table(file, "a row with numbers")
}

#[cfg(test)]
mod tests {
    #[test]
    fn lists_become_columns_however_they_are_written() {
        for text in [
            "t,q,mode\n0,\"[1, -2.5]\",a\n0.1,\"[2, -3]\",a\n",
            "t,q,mode\n0,\"[ 1.  -2.5]\",a\n0.1,\"[2.\n -3. ]\",a\n",
            "t,q,mode\n0,[1, -2.5],a\n0.1,[2, -3],a\n",
            "t;q;mode\n0;array([1, -2.5]);a\n0.1;array([2, -3]);a\n",
        ] {
            let found = crate::text::table(text).unwrap();
            assert_eq!(found.header, ["t", "q_1", "q_2", "mode"], "{text}");
            assert_eq!((&found.columns[0], &found.columns[2]), (&vec![0.0, 0.1], &vec![-2.5, -3.0]), "{text}");
        }
    }
}
