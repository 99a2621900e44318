//! Bounds of the size of a text, and of the expanded content of a YAML text.

use serde_yaml::{Budget, Error};

/// Largest description that is written by hand, bytes. A longer one is an accident or an attack.
pub(in crate::format) const MAX_DESCRIPTION_BYTES: usize = 1 << 20;

/// Largest number of links of a robot in YAML or URDF, above the number of any robot. The names of links, and their lines in
/// a URDF, are looked up one by one, so the time to read grows as the square of their number.
pub(in crate::format) const MAX_LINKS: usize = 2000;

/// The message about a text that exceeds its bound.
pub const REPEATS_TOO_MUCH: &str = "its anchors repeat more than it holds; write out what they stand for";

/// A bound of the number of values from the length of the text. A value that an anchor repeats counts each time, as if it
/// were written out. A text without anchors always stays within this bound.
pub(super) fn budget(text: &str) -> Option<Budget> {
    let most = 2 * text.len() + 1000;
    serde_yaml::budget! { max_nodes: most, max_events: most, max_total_scalar_bytes: most }
}

/// Whether a text was refused because it exceeds its bound.
pub(super) fn is_beyond_budget(error: &Error) -> bool {
    match error {
        Error::Budget { .. } => true,
        Error::AliasError { error, .. } | Error::WithSnippet { error, .. } => is_beyond_budget(error),
        _ => false,
    }
}
