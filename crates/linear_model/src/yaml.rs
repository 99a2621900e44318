//! Reads YAML files: artefacts (files that rist writes), and files that users write. Errors name the line and suggest a word
//! for a misspelt one.

use gate::suggestion::did_you_mean;
use robot::format::read_as;
use serde::de::DeserializeOwned;

/// Reads a value from YAML text.
///
/// Fails at an unexpected entry; the message gives its line and column, and suggests a word if it is misspelt. Fails if YAML
/// anchors expand to more than the size of the text.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    read_as(text).map_err(|e| meant(&e))
}

/// Adds "did you mean" with the most similar expected word to an error message about an unknown word. The message already lists
/// the expected words.
fn meant(message: &str) -> String {
    let parts = message.split_once('`').and_then(|(before, rest)| Some((before, rest.split_once('`')?)));
    let Some((before, (word, after))) = parts.filter(|(before, _)| before.contains("unknown")) else {
        return message.to_string();
    };
    let listed = after.lines().next().unwrap_or("").split_once("expected").map_or("", |(_, listed)| listed);
    let names = listed.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '-'));
    let known = names.filter(|name| !["", "one", "of", "or"].contains(name));
    format!("{before}`{word}`{}{after}", did_you_mean(word, known))
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Pair {
        columns: f64,
        signal: Option<f64>,
    }

    #[test]
    fn a_misspelt_key_comes_with_the_one_that_was_meant() {
        let whole: Pair = super::read("columns: 1\nsignal: 2\n").unwrap();
        assert_eq!((whole.columns, whole.signal), (1.0, Some(2.0)));
        let said = |text: &str| super::read::<Pair>(text).map(|_| ()).unwrap_err();
        let message = said("columns: 1\nsignl: 2\n");
        assert!(message.contains("`signl` (did you mean `signal`?)"), "{message}");
        assert!(!said("columns: 1\nweather: 2\n").contains("did you mean"));
        assert!(said("columns: [").len() > 5);
    }
}
