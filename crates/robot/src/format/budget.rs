//! Bounds on what a text holds, and on what a YAML text stands for.

use serde_yaml::{Budget, Error};

/// Most bytes of a description that is written by hand. A longer one is an accident or an attack.
pub(in crate::format) const MAX_DESCRIPTION_BYTES: usize = 1 << 20;

/// Most links of a robot in YAML or URDF, which no robot has. The names of links, and the lines of them in a URDF, are
/// looked up one by one, so the time to read grows as the square of their number.
pub(in crate::format) const MAX_LINKS: usize = 2000;

/// The message about a text beyond its bound.
pub const REPEATS_TOO_MUCH: &str = "its anchors repeat more than it holds; write out what they stand for";

/// At most as many values as the text has room for. A value that an anchor repeats counts each time, as if it were
/// written out. A text without anchors is read however long it is.
pub(super) fn budget(text: &str) -> Option<Budget> {
    let most = 2 * text.len() + 1000;
    serde_yaml::budget! { max_nodes: most, max_events: most, max_total_scalar_bytes: most }
}

/// Whether a text was refused since it goes beyond its bound.
pub(super) fn is_beyond_budget(error: &Error) -> bool {
    match error {
        Error::Budget { .. } => true,
        Error::AliasError { error, .. } | Error::WithSnippet { error, .. } => is_beyond_budget(error),
        _ => false,
    }
}
