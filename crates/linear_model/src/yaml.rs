//! Reads YAML: artefacts, and files that users write.

use robot::format::{REPEATS_TOO_MUCH, budget, is_beyond_budget};
use serde::de::DeserializeOwned;

/// The value that a text stands for.
///
/// Fails with the line and column of what is not expected, and where anchors repeat more than the text holds.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let options = serde_yaml::options! { budget: budget(text) };
    serde_yaml::from_str_with_options(text, options)
        .map_err(|e| if is_beyond_budget(&e) { REPEATS_TOO_MUCH.to_string() } else { e.to_string() })
}
