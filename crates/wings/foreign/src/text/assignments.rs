//! Reads lines of assignments, as scripts of robots print them: `[0.004] angles=[1.5, 2.0], torque=3`.
//!
//! A number becomes a column with its name, and a list becomes the columns name_1 .. name_k. A number before the first name, in
//! brackets or not, becomes the column `time`.

use logs::reading::{Budget, Records, TextHead};
use logs::{Error, Table};

use crate::text::list_cells::numbers_of_list;

/// Whether the first two lines contain assignments of numbers.
pub(crate) fn is_so(head: &TextHead) -> bool {
    head.lines.len() > 1 && head.lines[..2].iter().all(|line| !of_line(line).1.is_empty())
}

/// Reads lines of assignments as a table. Fails if there are too many columns, or if no line has an assignment.
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let text = String::from_utf8_lossy(bytes);
    let mut rows = Records::new(budget);
    for (k, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let (time, all) = of_line(line);
        let mut set = || {
            time.map_or(Ok(()), |time| rows.set("time", time))?;
            for (name, values) in &all {
                match values.as_slice() {
                    [x] => rows.set(name, *x)?,
                    list => {
                        list.iter().enumerate().try_for_each(|(k, x)| rows.set(&format!("{name}_{}", k + 1), *x))?
                    }
                }
            }
            if all.is_empty() { Ok(()) } else { rows.end_row(k + 1) }
        };
        set().map_err(|e: String| Error::at(file, k + 1, e))?;
    }
    rows.into_table(file, "a line such as `[0.004] q=[1, 2], tau=[3, 4]`")
}

/// Two results: the number before the first name, if there is one, and each name with its numbers.
fn of_line(line: &str) -> (Option<f64>, Vec<(&str, Vec<f64>)>) {
    let is_of_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '/');
    let mut found: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut first = None;
    for (at, _) in line.match_indices(['=', ':']) {
        // The name is the text before `=` or `:`, back to the last character that no name contains. A name begins with a
        // letter, so that a time of day such as `12:30` is not read as an assignment.
        let before = line[..at].trim_end();
        let begin = before
            .rfind(|c: char| !is_of_name(c))
            .map_or(0, |end| end + before[end..].chars().next().map_or(1, char::len_utf8));
        let name = &before[begin..];
        if !name.starts_with(char::is_alphabetic) {
            continue;
        }
        let after = line[at + 1..].trim_start();
        let values = match after.starts_with(['[', '(']) {
            true => numbers_of_list(&after[..after.find([']', ')']).map_or(after.len(), |end| end + 1)]),
            false => {
                let end = after.find(|c: char| c.is_whitespace() || matches!(c, ',' | ';')).unwrap_or(after.len());
                after[..end].parse().ok().map(|x| vec![x])
            }
        };
        if let Some(values) = values {
            first.get_or_insert(begin);
            found.push((name, values));
        }
    }
    // `first`: the position at which the first name begins. Only a number before it can be the time.
    let time = line[..first.unwrap_or(0)]
        .trim_matches(|c: char| c.is_whitespace() || matches!(c, '[' | ']' | ',' | ';' | '(' | ')'));
    (time.parse().ok(), found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_lists_become_columns() {
        let text = "[0.000] angles=[1, -2.5], mode=run, torque: 3\n\n[0.004] angles=[2, -3], torque: 4\n";
        let found = crate::text::table(text).unwrap();
        assert_eq!(found.header, ["time", "angles_1", "angles_2", "torque"]);
        assert_eq!((&found.columns[2], &found.columns[0], found.line(1)), (&vec![-2.5, -3.0], &vec![0.0, 0.004], 3));
        // A time of day (`12:30`) is no assignment, and a header has none.
        assert!(of_line("12:30:01.5,1,2").1.is_empty() && of_line("t,q[0],q[1]").1.is_empty());
    }
}
