//! What every artefact in YAML begins with: its kind, and the version of its form.
//!
//! ```text
//! rist: motion 1 8a41f00c5be7d913
//! ```
//! The digest of the lines below tells a file that was changed since; what it says is then told as what the file says.
//! It is no signature: whoever wants to can make a new one. A file of an earlier version of rist lacks the line, and is
//! read without it.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::yaml;

/// The key of the first line.
const KEY: &str = "rist: ";
/// The form that is written; a reader takes this one and those before it.
const VERSION: usize = 1;

/// What an artefact is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Of an identification.
    Estimate,
    /// Experiments of spectrum analysis.
    Plan,
    /// One exciting motion.
    Motion,
    /// An estimate held against logs that it was not made from.
    Validation,
    /// Robots held against a reference.
    Comparison,
}

impl Kind {
    const ALL: [Kind; 5] = [Kind::Estimate, Kind::Plan, Kind::Motion, Kind::Validation, Kind::Comparison];

    fn word(self) -> &'static str {
        match self {
            Kind::Estimate => "estimate",
            Kind::Plan => "plan",
            Kind::Motion => "motion",
            Kind::Validation => "validation",
            Kind::Comparison => "comparison",
        }
    }

    /// The kind that a text says it is; `None` where it does not say.
    pub fn of(text: &str) -> Option<Kind> {
        let (word, _) = head(text)?;
        Kind::ALL.into_iter().find(|kind| kind.word() == word)
    }
}

/// The words of the first line: kind and version.
fn head(text: &str) -> Option<(&str, &str)> {
    let line = text.lines().next()?.strip_prefix(KEY)?.trim();
    Some(line.split_once(' ').unwrap_or((line, "")))
}

/// The text of an artefact.
pub fn write<T: Serialize>(kind: Kind, artefact: &T) -> Result<String, String> {
    let word = kind.word();
    let text = serde_yaml::to_string(artefact).map_err(|e| format!("the {word} cannot be written: {e}"))?;
    Ok(format!("{KEY}{word} {VERSION} {:016x}\n{text}", digest(&text)))
}

/// Whether the text of an artefact was changed after it was written; a file without the first line cannot tell.
pub fn is_edited(text: &str) -> bool {
    let Some((first, body)) = text.split_once('\n').filter(|_| head(text).is_some()) else { return false };
    first.trim_end().rsplit(' ').next().and_then(|word| u64::from_str_radix(word, 16).ok()) != Some(digest(body))
}

/// Said of an artefact that was changed.
pub const EDITED: &str = "the file was changed after rist wrote it, so that this is what the file says";

/// FNV-1a, 64 bits; an end of line counts as one character, however it is written.
fn digest(text: &str) -> u64 {
    let bytes = text.bytes().filter(|byte| *byte != b'\r');
    bytes.fold(0xcbf2_9ce4_8422_2325, |digest, byte| (digest ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

/// The artefact that a text stands for.
///
/// Fails where it is of another kind or of a later version, and with the line of what is not expected.
pub fn read<T: DeserializeOwned>(kind: Kind, text: &str) -> Result<T, String> {
    let word = kind.word();
    let mut body = text.to_string();
    if let Some((found, version)) = head(text) {
        if found != word {
            return Err(format!("this is no {word}: the first line says `{KEY}{found}`"));
        }
        // The digest follows.
        let version = version.split(' ').next().unwrap_or_default();
        match version.parse::<usize>() {
            Ok(version) if (1..=VERSION).contains(&version) => {}
            _ => {
                return Err(format!(
                    "`{version}` is no version of a {word} that is read here; those up to {VERSION} are: make the file \
                     again, or read it with the version of rist that wrote it"
                ));
            }
        }
        // A comment keeps the numbers of the lines.
        body.insert_str(0, "# ");
    }
    yaml::read(&body).map_err(|e| format!("this is no {word}: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_says_its_kind_and_is_read_without_it() {
        let text = write(Kind::Motion, &vec![1.5, 2.0]).unwrap();
        assert!(text.starts_with("rist: motion 1 "), "{text}");
        assert!(!is_edited(&text) && !is_edited(&text.replace('\n', "\r\n")));
        assert!(is_edited(&text.replace("1.5", "1.6")) && is_edited("rist: motion 1\n- 1.5\n"));
        assert_eq!(Kind::of(&text), Some(Kind::Motion));
        assert_eq!(read::<Vec<f64>>(Kind::Motion, &text).unwrap(), [1.5, 2.0]);
        let before = text.lines().skip(1).collect::<Vec<_>>().join("\n");
        assert_eq!(Kind::of(&before), None);
        assert_eq!(read::<Vec<f64>>(Kind::Motion, &before).unwrap(), [1.5, 2.0]);
    }

    #[test]
    fn another_kind_and_a_later_version_are_refused_by_name() {
        let refused = |text: &str| read::<Vec<f64>>(Kind::Plan, text).unwrap_err();
        assert_eq!(refused("rist: motion 1\n- 1\n"), "this is no plan: the first line says `rist: motion`");
        for version in ["2", "0", "x", ""] {
            let text = refused(&format!("rist: plan {version}\n- 1\n"));
            assert!(text.contains(&format!("`{version}` is no version of a plan")), "{text}");
        }
        let text = refused("rist: plan 1\n- 1\n- x\n");
        assert!(text.contains("3:3") || text.contains("line 3"), "the line is that of the file: {text}");
    }
}
