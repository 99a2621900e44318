//! Repairs a text that is not valid XML but that urdfdom (the reader of ROS and Pinocchio) reads. Two mistakes are repaired: a
//! name space prefix that is not declared, and `<?xml ..?>` that is not at the start.

use roxmltree::Error;

use super::text::{Checked, check_xml};
use crate::error;
use crate::format::node::DescriptionFile;
use crate::format::shown::shown;
use crate::format::xml;
use crate::robot::Note;

/// Largest number of prefixes that are declared.
const MAX_PREFIXES: usize = 20;

/// Checks a URDF text, as [`check_xml`] does. A text that is not valid XML is read as far as urdfdom reads it, with notes.
pub(super) fn check(source: DescriptionFile, text: &str, floats: bool) -> Result<Checked, error::Error> {
    check_xml(source, text, floats).or_else(|error| {
        let Some((text, mut notes)) = repaired(text) else { return Err(error) };
        let mut checked = check_xml(source, &text, floats)?;
        checked.notes.append(&mut notes);
        Ok(checked)
    })
}

/// The text with the mistakes of this module repaired, on the same lines, and notes on them. `None` if the text has none of
/// these mistakes.
pub(in crate::format) fn repaired(text: &str) -> Option<(String, Vec<Note>)> {
    let note = |text: String| Note { subject: "XML".into(), text };
    let (mut text, mut notes) = (text.to_string(), Vec::new());
    let (heads, root) = prolog(&text);
    for (start, end) in heads {
        let line = 1 + text[..start].matches('\n').count();
        // The line breaks and the length are kept, so that all line and column numbers stay valid.
        let blank: String = text[start..end].bytes().map(|b| if b == b'\n' { '\n' } else { ' ' }).collect();
        text.replace_range(start..end, &blank);
        notes.push(note(format!("<?xml ..?> on line {line} is not at the start of the file: skipped")));
    }
    let name = text[root..].find(|c: char| c.is_whitespace() || matches!(c, '>' | '/')).map(|length| root + length);
    for _ in 0..MAX_PREFIXES {
        let (Some(Error::UnknownNamespace(prefix, _)), Some(at)) = (xml::mistake(&text), name) else { break };
        text.insert_str(at, &format!(" xmlns:{prefix}=\"{prefix}\""));
        let prefix = shown(&prefix).to_string();
        let cure = format!("xmlns:{prefix}=\"{prefix}\" in the first element declares it");
        notes.push(note(format!("the prefix `{prefix}:` is not declared, and what it names is skipped; {cure}")));
    }
    (!notes.is_empty()).then_some((text, notes))
}

/// The places of each `<?xml ..?>` before the first element that is not at the start, and the place of the first element.
fn prolog(text: &str) -> (Vec<(usize, usize)>, usize) {
    let (mut heads, mut at) = (Vec::new(), text.len() - text.trim_start_matches('\u{feff}').len());
    let start = at;
    loop {
        at = text.len() - text[at..].trim_start().len();
        let rest = &text[at..];
        let close = match rest {
            _ if rest.starts_with("<!--") => "-->",
            _ if rest.starts_with("<?") => "?>",
            _ if rest.starts_with("<!") => ">",
            _ => return (heads, at),
        };
        let Some(length) = rest.find(close) else { return (heads, at) };
        let end = at + length + close.len();
        if at > start && rest.starts_with("<?xml") && !rest.starts_with("<?xml-") {
            heads.push((at, end));
        }
        at = end;
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::repaired;
    use crate::format::{ReadOptions, parse_with, read_urdf, without_macros};

    const SOUND: &str = "<?xml version=\"1.0\"?>\n<robot name=\"r\"><link name=\"b\"/><link name=\"l\"><inertial><mass value=\"2\"/>\
        <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\n<joint name=\"j\" \
        type=\"continuous\"><parent link=\"b\"/><child link=\"l\"/></joint></robot>";

    #[test]
    fn what_is_sound_or_broken_otherwise_stays() {
        assert!(repaired(SOUND).is_none());
        assert!(read_urdf(SOUND, "r.urdf").unwrap().notes.iter().all(|note| note.subject != "XML"));
        for (old, new, said) in [("</robot>", "", "not valid XML"), ("<mass value=\"2\"/>", "", "has no <mass>")] {
            let message = read_urdf(&SOUND.replace(old, new), "r.urdf").unwrap_err().to_string();
            assert!(message.contains(said), "{message}");
        }
        for text in ["", "<", "<?xml", "<!--", "x<?xml ?>", "<:", "<a:"] {
            assert!(read_urdf(text, "r.urdf").is_err(), "{text}");
        }
    }

    #[test]
    fn what_urdfdom_reads_is_read_and_said() {
        let whole = read_urdf(SOUND, "r.urdf").unwrap();
        let twice = SOUND.replace("<robot", "<!-- é -->\n<?xml version='1.0'\n encoding='utf-8'?><robot");
        let late = format!("\n{SOUND}");
        let prefixed = SOUND
            .replace("<joint name", "<drake:a drake:b=\"1\" c:d=\"2\"/><joint name")
            .replace("<inertial>", "<inertial drake:e=\"3\">");
        for (text, said) in [
            (&twice, &["<?xml ..?> on line 3 is not at the start"][..]),
            (&late, &["<?xml ..?> on line 2 is not"]),
            (&prefixed, &["the prefix `drake:` is not declared, and what it names is skipped; xmlns:drake=", "`c:`"]),
        ] {
            let robot = read_urdf(text, "r.urdf").unwrap();
            assert_eq!(format!("{:?}", robot.links), format!("{:?}", whole.links), "{text}");
            let notes: Vec<_> = robot.notes.iter().filter(|note| note.subject == "XML").collect();
            assert_eq!(notes.len(), said.len(), "{notes:?}");
            assert!(notes.iter().zip(said).all(|(note, said)| note.text.contains(said)), "{notes:?}");
            // A writer gets the repaired text.
            let path = Path::new("r.urdf");
            let written = without_macros(text, path, ReadOptions::default()).unwrap();
            let again = parse_with(&written, path, ReadOptions::default()).unwrap();
            assert_eq!(format!("{:?}", again.links), format!("{:?}", whole.links), "{written}");
            assert!(again.notes.iter().all(|note| note.subject != "XML"), "{written}");
        }
    }

    /// For an `<inertial>` without `<inertia>`, urdfdom keeps the mass and sets the moments to zero.
    #[test]
    fn a_mass_without_inertia_is_a_point() {
        let start = SOUND.find("<inertia ").unwrap();
        let end = SOUND.find("</inertial>").unwrap();
        let robot = read_urdf(&format!("{}{}", &SOUND[..start], &SOUND[end..]), "r.urdf").unwrap();
        assert_eq!(robot.links[0].inertial.map(|x| (x[0], x[5], x[9])), Some((0.0, 0.0, 2.0)));
        let said = |note: &crate::Note| note.text.contains("has no <inertia>");
        assert!(robot.notes.iter().any(said) && !read_urdf(SOUND, "r.urdf").unwrap().notes.iter().any(said));
    }
}
