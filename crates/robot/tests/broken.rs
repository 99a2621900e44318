//! Reads broken descriptions, and compares each error message with the expected message.
//!
//! testdata/broken/messages.txt: one line `file: message` per description. The message has no path.

use std::collections::BTreeSet;
use std::path::Path;

use random::SplitMix;
use robot::format;

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/broken")
}

/// The error message for a file, without its path; `None` if the file can be read.
fn message(file: &str) -> Option<String> {
    let path = folder().join(file);
    let error = format::read(&path).err()?;
    let text = error.to_string();
    let rest = text.strip_prefix(&path.display().to_string()).expect("a message begins with the file");
    Some(rest.trim_start_matches(':').trim_start().to_string())
}

#[test]
fn broken_descriptions_give_their_messages() {
    let expected = std::fs::read_to_string(folder().join("messages.txt")).unwrap();
    let mut listed = BTreeSet::new();
    let mut wrong = Vec::new();
    for line in expected.lines() {
        let (file, wanted) = line.split_once(": ").expect("`file: message`");
        listed.insert(file.to_string());
        let found = message(file).unwrap_or_else(|| "(accepted)".into());
        if found != wanted {
            wrong.push(format!("{file}\n  expected {wanted}\n  found    {found}"));
        }
    }
    let present: BTreeSet<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|f| f.unwrap().file_name().into_string().unwrap())
        .filter(|f| f != "messages.txt")
        .collect();
    for file in present.difference(&listed) {
        wrong.push(format!("{file} is not in messages.txt\n  found    {}", message(file).unwrap_or_default()));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(listed.len() >= 24);
}

/// No reader panics if a shipped model is cut off at any byte, or if one byte is changed.
#[test]
fn damaged_models_do_not_panic() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    for name in ["race.yaml", "ur5.urdf", "../crates/robot/testdata/par/race.par"] {
        let text = std::fs::read_to_string(models.join(name)).unwrap();
        let read = match name.rsplit('.').next() {
            Some("yaml") => format::read_yaml,
            Some("par") => format::read_par,
            _ => format::read_urdf,
        };
        let mut random = SplitMix(1995);
        for round in 0..300 {
            let at = (random.bits() % text.len() as u64) as usize;
            if !text.is_char_boundary(at) || !text.is_char_boundary(at + 1) {
                continue;
            }
            let replacement = ["", "-", "{", "\"", "9", "<", " ", "\n", "*", ":"][round % 10];
            let damaged = match round % 3 {
                0 => text[..at].to_string(),
                _ => format!("{}{replacement}{}", &text[..at], &text[at + 1..]),
            };
            if let Err(error) = read(&damaged, name) {
                assert!(error.place.file == name && error.message.len() < 600, "{error}");
            }
        }
    }
}

/// Texts that would use too much time or memory are refused, for example very long or deeply nested expressions.
#[test]
fn hostile_texts_are_refused() {
    let head = "convention: khalil-kleinfinger\nname: x\nlinks:\n  - {link: 1, antecedent: base, theta: q1, d: ";
    let sum = "1+".repeat(100_000) + "1";
    for text in [format!("{head}{sum}}}"), format!("{head}{}}}", "-".repeat(900)), "[".repeat(100_000)] {
        assert!(format::read_yaml(&text, "x.yaml").is_err());
    }
    let powers = (0..60).fold("d2".to_string(), |v, _| format!("({v})**4"));
    let texts =
        ["(*".repeat(100_000), "d = {".repeat(100_000), format!("NL = 1\nd = {{{powers}}}"), "NL = 99999999".into()];
    for text in texts {
        assert!(format::read_par(&text, "x.par").is_err());
    }
    let deep = "<a>".repeat(100_000);
    let laughs = "<!DOCTYPE r [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;\">]><robot name=\"&b;\"/>";
    for text in [format!("<robot>{deep}"), format!("<robot>{deep}{}</robot>", "</a>".repeat(100_000)), laughs.into()] {
        assert!(format::read_urdf(&text, "x.urdf").is_err());
    }
}
