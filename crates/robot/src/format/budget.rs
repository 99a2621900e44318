//! A bound on what a YAML text stands for.

use serde_yaml::{Budget, Error};

/// Said of a text beyond its bound.
pub const REPEATS_TOO_MUCH: &str = "its anchors repeat more than it holds; write out what they stand for";

/// As many values as the text has room for: what anchors repeat counts as if it were written out, and without anchors a
/// text is read however long it is.
pub fn budget(text: &str) -> Option<Budget> {
    let most = 2 * text.len() + 1000;
    serde_yaml::budget! { max_nodes: most, max_events: most, max_total_scalar_bytes: most }
}

/// Whether a text was refused since it goes beyond its bound.
pub fn is_beyond_budget(error: &Error) -> bool {
    match error {
        Error::Budget { .. } => true,
        Error::AliasError { error, .. } | Error::WithSnippet { error, .. } => is_beyond_budget(error),
        _ => false,
    }
}
