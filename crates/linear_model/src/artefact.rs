//! The first line of every YAML file that rist writes. Such a file is called an artefact (estimate, plan, motion, ..). The line
//! has the kind of the artefact, the version of its format, and a checksum.
//!
//! ```text
//! rist: motion 1 8a41f00c5be7d913
//! ```
//! The checksum is computed from all other lines and detects changes of the file. If the checksum does not match, the user is
//! warned that the file was changed after rist wrote it. The checksum is not a signature: anybody can compute a new one. A file
//! of an earlier version of rist has no such line. Such a file is read with a warning, because changes cannot be detected.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::yaml;

/// The key of the first line.
const KEY: &str = "rist: ";
/// Version of the format that is written. This version and earlier versions can be read.
const FORMAT_VERSION: usize = 1;

/// The kind of an artefact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArtefactKind {
    /// The estimate of an identification.
    Estimate,
    /// A plan: experiments for spectral analysis.
    Plan,
    /// An exciting motion.
    Motion,
    /// A validation: comparison of an estimate with logs that were not used for it.
    Validation,
    /// A comparison of the robots of a fleet with a reference.
    Comparison,
}

impl ArtefactKind {
    const ALL: [ArtefactKind; 5] = [
        ArtefactKind::Estimate,
        ArtefactKind::Plan,
        ArtefactKind::Motion,
        ArtefactKind::Validation,
        ArtefactKind::Comparison,
    ];

    fn word(self) -> &'static str {
        match self {
            ArtefactKind::Estimate => "estimate",
            ArtefactKind::Plan => "plan",
            ArtefactKind::Motion => "motion",
            ArtefactKind::Validation => "validation",
            ArtefactKind::Comparison => "comparison",
        }
    }

    /// The kind of artefact that the first line of `text` states. `None` if there is no such line or the kind is unknown.
    pub fn of(text: &str) -> Option<ArtefactKind> {
        let (word, _) = head(text)?;
        ArtefactKind::ALL.into_iter().find(|kind| kind.word() == word)
    }
}

/// The kind that the first line states, and the rest of this line. `None` if the text does not start with such a line.
fn head(text: &str) -> Option<(&str, &str)> {
    let line = text.lines().next()?.strip_prefix(KEY)?.trim();
    Some(line.split_once(' ').unwrap_or((line, "")))
}

/// The result of checking the checksum of an artefact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Checksum {
    /// The checksum matches, or the artefact was not read from a file.
    #[default]
    Whole,
    /// The checksum in the first line differs from the checksum of the lines below.
    Broken,
    /// There is no first line: an earlier version wrote the file, or somebody removed the line.
    Absent,
}

impl Checksum {
    /// Compares the checksum in the first line of an artefact with the checksum of its other lines.
    pub fn of(text: &str) -> Checksum {
        if head(text).is_none() {
            return Checksum::Absent;
        }
        let (first, body) = text.split_once('\n').unwrap_or((text, ""));
        let written = first.trim_end().rsplit(' ').next().and_then(|word| u64::from_str_radix(word, 16).ok());
        if written == Some(digest(body)) { Checksum::Whole } else { Checksum::Broken }
    }

    /// A sentence for the user if the checksum does not match or is absent. `None` if the checksum matches.
    pub fn said(self) -> Option<&'static str> {
        match self {
            Checksum::Whole => None,
            Checksum::Broken => Some("the file was changed after rist wrote it, so that this is what the file says"),
            Checksum::Absent => Some(
                "the file lacks the first line, by which rist knows what it wrote, so that this is what the file says",
            ),
        }
    }

    /// The sentence of [`Checksum::said`] with the name of the file before it.
    pub fn note(self, file: impl std::fmt::Display) -> Option<String> {
        self.said().map(|said| format!("{file}: {said}"))
    }
}

/// Word that is written instead of a checksum if the artefact was read from a file with a wrong or missing checksum. This word
/// never matches a checksum, so the new file counts as changed too.
const NO_CHECKSUM: &str = "changed";

/// The text of an artefact with its first line. `seal`: result of the checksum test of the file from which the artefact was
/// read; `Whole` if the artefact was not read from a file.
pub fn write<T: Serialize>(kind: ArtefactKind, seal: Checksum, artefact: &T) -> Result<String, String> {
    let word = kind.word();
    let text = serde_yaml::to_string(artefact).map_err(|e| format!("the {word} cannot be written: {e}"))?;
    let digest = if seal == Checksum::Whole { format!("{:016x}", digest(&text)) } else { NO_CHECKSUM.into() };
    Ok(format!("{KEY}{word} {FORMAT_VERSION} {digest}\n{text}"))
}

/// The checksum FNV-1a of 64 bits. Carriage returns are left out, so that both kinds of line ends give the same checksum.
fn digest(text: &str) -> u64 {
    let bytes = text.bytes().filter(|byte| *byte != b'\r');
    bytes.fold(0xcbf2_9ce4_8422_2325, |digest, byte| (digest ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

/// Reads an artefact of the given kind from its text.
///
/// Fails if the first line states another kind or a later version. Fails at an unexpected entry; the message gives its line.
pub fn read<T: DeserializeOwned>(kind: ArtefactKind, text: &str) -> Result<T, String> {
    let word = kind.word();
    let mut body = text.to_string();
    if let Some((found, version)) = head(text) {
        if found != word {
            return Err(format!("this is no {word}: the first line says `{KEY}{found}`"));
        }
        // The checksum comes after the version.
        let version = version.split(' ').next().unwrap_or_default();
        match version.parse::<usize>() {
            Ok(version) if (1..=FORMAT_VERSION).contains(&version) => {}
            _ => {
                return Err(format!(
                    "`{version}` is no version of a {word} that is read here; those up to {FORMAT_VERSION} are: make the file \
                     again, or read it with the version of rist that wrote it"
                ));
            }
        }
        // The first line becomes a comment and is not removed, so that errors state the right line numbers.
        body.insert_str(0, "# ");
    }
    yaml::read(&body).map_err(|e| format!("this is no {word}: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_says_its_kind_and_is_read_without_it() {
        let text = write(ArtefactKind::Motion, Checksum::Whole, &vec![1.5, 2.0]).unwrap();
        assert!(text.starts_with("rist: motion 1 "), "{text}");
        assert_eq!([&text, &text.replace('\n', "\r\n")].map(|text| Checksum::of(text)), [Checksum::Whole; 2]);
        for changed in [text.replace("1.5", "1.6").as_str(), "rist: motion 1\n- 1.5\n", "rist: motion 1"] {
            assert_eq!(Checksum::of(changed), Checksum::Broken, "{changed}");
        }
        // An artefact from a changed file is written without a checksum.
        let again = write(ArtefactKind::Motion, Checksum::Broken, &vec![1.5, 2.0]).unwrap();
        assert_eq!(Checksum::of(&again), Checksum::Broken);
        assert_eq!(read::<Vec<f64>>(ArtefactKind::Motion, &again).unwrap(), [1.5, 2.0]);
        assert_eq!(ArtefactKind::of(&text), Some(ArtefactKind::Motion));
        assert_eq!(read::<Vec<f64>>(ArtefactKind::Motion, &text).unwrap(), [1.5, 2.0]);
        let before = text.lines().skip(1).collect::<Vec<_>>().join("\n");
        assert_eq!((ArtefactKind::of(&before), Checksum::of(&before)), (None, Checksum::Absent));
        assert_eq!(read::<Vec<f64>>(ArtefactKind::Motion, &before).unwrap(), [1.5, 2.0]);
    }

    #[test]
    fn another_kind_and_a_later_version_are_refused_by_name() {
        let refused = |text: &str| read::<Vec<f64>>(ArtefactKind::Plan, text).unwrap_err();
        assert_eq!(refused("rist: motion 1\n- 1\n"), "this is no plan: the first line says `rist: motion`");
        for version in ["2", "0", "x", ""] {
            let text = refused(&format!("rist: plan {version}\n- 1\n"));
            assert!(text.contains(&format!("`{version}` is no version of a plan")), "{text}");
        }
        let text = refused("rist: plan 1\n- 1\n- x\n");
        assert!(text.contains("3:3") || text.contains("line 3"), "the line is that of the file: {text}");
    }
}
