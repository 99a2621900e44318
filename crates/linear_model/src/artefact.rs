//! What every artefact in YAML begins with: its kind, and the version of its form.
//!
//! ```text
//! rist: motion 1 8a41f00c5be7d913
//! ```
//! The digest of the lines below tells a file that was changed since; what it says is then told as what the file says.
//! It is no signature: whoever wants to can make a new one. A file of an earlier version of rist lacks the line. It is
//! read, and told as what the file says too: nothing in it shows whether it is as it was written.

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

/// Whether an artefact is as rist wrote it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Seal {
    /// It is, or it was never in a file.
    #[default]
    Whole,
    /// The digest in its first line is not that of the lines below.
    Broken,
    /// There is no first line: an earlier version wrote it, or somebody took the line away.
    Absent,
}

impl Seal {
    /// Of the text of an artefact.
    pub fn of(text: &str) -> Seal {
        if head(text).is_none() {
            return Seal::Absent;
        }
        let (first, body) = text.split_once('\n').unwrap_or((text, ""));
        let written = first.trim_end().rsplit(' ').next().and_then(|word| u64::from_str_radix(word, 16).ok());
        if written == Some(digest(body)) { Seal::Whole } else { Seal::Broken }
    }

    /// What is said of an artefact that is not as rist wrote it, or cannot show that it is.
    pub fn said(self) -> Option<&'static str> {
        match self {
            Seal::Whole => None,
            Seal::Broken => Some("the file was changed after rist wrote it, so that this is what the file says"),
            Seal::Absent => Some(
                "the file lacks the first line, by which rist knows what it wrote, so that this is what the file says",
            ),
        }
    }

    /// The same as a note on a file.
    pub fn note(self, file: impl std::fmt::Display) -> Option<String> {
        self.said().map(|said| format!("{file}: {said}"))
    }
}

/// Stands for the digest of an artefact that was read from a file with another one, so that it stays known as such.
const NOT_WHOLE: &str = "changed";

/// The text of an artefact; `seal`: of the file that it was read from.
pub fn write<T: Serialize>(kind: Kind, seal: Seal, artefact: &T) -> Result<String, String> {
    let word = kind.word();
    let text = serde_yaml::to_string(artefact).map_err(|e| format!("the {word} cannot be written: {e}"))?;
    let digest = if seal == Seal::Whole { format!("{:016x}", digest(&text)) } else { NOT_WHOLE.into() };
    Ok(format!("{KEY}{word} {VERSION} {digest}\n{text}"))
}

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
        let text = write(Kind::Motion, Seal::Whole, &vec![1.5, 2.0]).unwrap();
        assert!(text.starts_with("rist: motion 1 "), "{text}");
        assert_eq!([&text, &text.replace('\n', "\r\n")].map(|text| Seal::of(text)), [Seal::Whole; 2]);
        for changed in [text.replace("1.5", "1.6").as_str(), "rist: motion 1\n- 1.5\n", "rist: motion 1"] {
            assert_eq!(Seal::of(changed), Seal::Broken, "{changed}");
        }
        // What was read from a changed file is written as what it is.
        let again = write(Kind::Motion, Seal::Broken, &vec![1.5, 2.0]).unwrap();
        assert_eq!(Seal::of(&again), Seal::Broken);
        assert_eq!(read::<Vec<f64>>(Kind::Motion, &again).unwrap(), [1.5, 2.0]);
        assert_eq!(Kind::of(&text), Some(Kind::Motion));
        assert_eq!(read::<Vec<f64>>(Kind::Motion, &text).unwrap(), [1.5, 2.0]);
        let before = text.lines().skip(1).collect::<Vec<_>>().join("\n");
        assert_eq!((Kind::of(&before), Seal::of(&before)), (None, Seal::Absent));
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
