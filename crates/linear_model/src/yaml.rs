//! Reads YAML: artefacts, and files that users write.

use gate::suggestion::did_you_mean;
use robot::format::{REPEATS_TOO_MUCH, budget, is_beyond_budget};
use serde::de::DeserializeOwned;

/// The value that a text stands for.
///
/// Fails with the line and column of what is not expected, and the word that was meant where there is one, and where
/// anchors repeat more than the text holds.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let options = serde_yaml::options! { budget: budget(text) };
    serde_yaml::from_str_with_options(text, options)
        .map_err(|e| if is_beyond_budget(&e) { REPEATS_TOO_MUCH.to_string() } else { meant(&e.to_string()) })
}

/// A message on an unknown word with the known one that is nearest to it: the library names both between backticks.
fn meant(message: &str) -> String {
    let mut words = message.split('`').skip(1).step_by(2);
    let (Some(word), true) = (words.next(), message.contains("unknown")) else { return message.to_string() };
    let known: Vec<&str> = words.filter(|known| *known != word).collect();
    let meant = did_you_mean(word, known);
    match message.split_once(&format!("`{word}`")) {
        Some((before, after)) if !meant.is_empty() => format!("{before}`{word}`{meant}{after}"),
        _ => message.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Pair {
        #[allow(dead_code, reason = "read by nobody: the test is about the message")]
        columns: f64,
        #[allow(dead_code, reason = "as above")]
        signal: Option<f64>,
    }

    #[test]
    fn a_misspelt_key_comes_with_the_one_that_was_meant() {
        let said = |text: &str| super::read::<Pair>(text).map(|_| ()).unwrap_err();
        let message = said("columns: 1\nsignl: 2\n");
        assert!(message.contains("`signl` (did you mean `signal`?)"), "{message}");
        assert!(!said("columns: 1\nweather: 2\n").contains("did you mean"));
        assert!(said("columns: [").len() > 5);
    }
}
