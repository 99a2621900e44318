//! Limits on the length of a description text, and on the number of values that a YAML text expands to.

use serde_yaml::{Budget, Error};

/// Largest size of a description, bytes. Descriptions are written by hand, so a longer one is an accident or an attack.
pub(in crate::format) const MAX_DESCRIPTION_BYTES: usize = 1 << 20;

/// Largest number of links of a robot in YAML or URDF; no real robot has more. Each link is searched by its name among all links,
/// so the time to read grows with the square of their number.
pub(in crate::format) const MAX_LINKS: usize = 2000;

/// The message for a YAML text that expands to more values than the limit allows.
pub const REPEATS_TOO_MUCH: &str = "its anchors repeat more than it holds; write out what they stand for";

/// The limit on the number of values in a YAML text, proportional to the length of the text. A value that an anchor repeats
/// counts each time it is repeated. A text without anchors never exceeds the limit.
pub(super) fn budget(text: &str) -> Option<Budget> {
    let most = 2 * text.len() + 1000;
    serde_yaml::budget! { max_nodes: most, max_events: most, max_total_scalar_bytes: most }
}

/// Whether an error of the YAML library means that the text has more values than [`budget`] allows.
pub(super) fn is_beyond_budget(error: &Error) -> bool {
    match error {
        Error::Budget { .. } => true,
        Error::AliasError { error, .. } | Error::WithSnippet { error, .. } => is_beyond_budget(error),
        _ => false,
    }
}
