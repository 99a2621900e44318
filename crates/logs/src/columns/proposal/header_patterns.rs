//! Headers that differ by a number or a joint name only: patterns with one column per joint.
//!
//! Example: the headers `q1`, `q2`, .. have the pattern `q{}`, and `q_elbow`, `q_wrist` have `q_{joint}`.

use std::collections::BTreeMap;

use crate::columns::names::NamePattern;
use crate::table::Table;

/// Header patterns that occur once for each joint, each with its columns in the order of the joints.
pub(super) fn patterns(table: &Table, coordinates: &[String]) -> Vec<(String, Vec<usize>)> {
    let mut numbered: BTreeMap<String, BTreeMap<usize, usize>> = BTreeMap::new();
    let mut named: BTreeMap<String, BTreeMap<usize, usize>> = BTreeMap::new();
    for (column, header) in table.header.iter().enumerate() {
        for (start, end, number) in digits(header) {
            let pattern = format!("{}{{}}{}", &header[..start], &header[end..]);
            numbered.entry(pattern).or_default().insert(number, column);
        }
        for (k, name) in coordinates.iter().enumerate() {
            // Joint names often start with a capital letter, so case is ignored. Only ASCII letters are converted, because byte
            // positions must not change.
            let at = header.to_ascii_lowercase().find(&name.to_ascii_lowercase());
            if let Some(start) = at {
                let pattern = format!("{}{{joint}}{}", &header[..start], &header[start + name.len()..]);
                named.entry(pattern).or_default().insert(k, column);
            }
        }
    }
    let n = coordinates.len();
    let whole = |(pattern, columns): (String, BTreeMap<usize, usize>), first: usize| {
        let all: Option<Vec<usize>> = (first..first + n).map(|k| columns.get(&k).copied()).collect();
        all.map(|columns| (pattern, columns))
    };
    let mut found: Vec<(String, Vec<usize>)> = named.into_iter().filter_map(|entry| whole(entry, 0)).collect();
    for entry in numbered {
        // If a file has a column with the number 0, its numbers start at 0.
        let first = usize::from(!entry.1.contains_key(&0));
        found.extend(whole(entry, first));
    }
    found
}

/// The numbers in a header: start, end and value.
fn digits(header: &str) -> Vec<(usize, usize, usize)> {
    let bytes = header.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let end = (at..bytes.len()).find(|&k| !bytes[k].is_ascii_digit()).unwrap_or(bytes.len());
        if end > at && end - at <= 3 {
            found.extend(header[at..end].parse().ok().map(|number| (at, end, number)));
        }
        at = end.max(at + 1);
    }
    found
}

/// The column names of a pattern, and their text in the options. The text is a list of headers if some joint names in the headers
/// differ in case from the coordinates; otherwise it is the pattern.
pub(super) fn given(table: &Table, coordinates: &[String], pattern: &str, columns: &[usize]) -> (NamePattern, String) {
    let headers: Vec<String> = columns.iter().map(|&c| table.header[c].clone()).collect();
    let is_as_written = |(header, name): (&String, &String)| {
        !pattern.contains("{joint}") || *header == pattern.replace("{joint}", name)
    };
    match headers.iter().zip(coordinates).all(is_as_written) {
        true => (NamePattern::Pattern(pattern.into()), quoted(pattern)),
        false => {
            let each: Vec<String> = headers.iter().map(|header| quoted(header)).collect();
            (NamePattern::Each(headers), format!("[{}]", each.join(", ")))
        }
    }
}

pub(super) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
