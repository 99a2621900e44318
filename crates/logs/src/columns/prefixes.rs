//! Finds joint names of a table that differ from the names in the description by a prefix.
//!
//! Example: the description has the joint `j1`, and the table has the column `left_j1_position`.

use crate::table::Table;

/// Possible names of the coordinates in a table, each list with a sentence that explains it. The names have a prefix that occurs
/// in the table, or lack a prefix that all coordinates have in common.
pub(crate) fn prefixes(table: &Table, coordinates: &[String]) -> Vec<(String, Vec<String>)> {
    /// Largest number of prefixes that are tried; a table of one robot has fewer.
    const MAX_PREFIXES: usize = 40;
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    let first = coordinates[0].to_lowercase();
    let is_end = |c: char| !c.is_alphanumeric();
    // Possible prefixes: the texts before the name of the first joint, each starting after a separator.
    let mut prefixes: Vec<String> = Vec::new();
    for header in &table.header {
        let lower = header.to_lowercase();
        for (at, _) in lower.match_indices(&first) {
            let before = &lower[..at];
            if !before.ends_with(is_end) {
                continue;
            }
            let starts = before.char_indices().filter(|(_, c)| is_end(*c)).map(|(i, c)| i + c.len_utf8());
            for start in std::iter::once(0).chain(starts).filter(|start| *start < at) {
                let prefix = before[start..].to_string();
                if prefixes.len() < MAX_PREFIXES && !prefixes.contains(&prefix) {
                    prefixes.push(prefix);
                }
            }
        }
    }
    for prefix in prefixes {
        let said = format!("the joints are named with `{prefix}` in front of the names of the description");
        found.push((said, coordinates.iter().map(|name| format!("{prefix}{name}")).collect()));
    }
    let shared = coordinates.iter().fold(coordinates[0].as_str(), |shared, name| {
        let same = shared.chars().zip(name.chars()).take_while(|(a, b)| a == b).map(|(a, _)| a.len_utf8()).sum();
        &shared[..same]
    });
    let shared = shared.rfind(is_end).map_or("", |at| &shared[..=at]);
    if !shared.is_empty() && coordinates.iter().all(|name| name.len() > shared.len()) {
        let said = format!("the joints are named without the `{shared}` of the description");
        found.push((said, coordinates.iter().map(|name| name[shared.len()..].to_string()).collect()));
    }
    found
}
