//! Names as they are shown.
//!
//! A name that holds what is not seen, or what changes how its neighbours are seen, is known by its shown form from the
//! reader on ([`gate::shown::line`]): in tables, comments, generated source, columns and artefacts alike. A note says so.

use gate::shown::{is_hidden, line};

use crate::robot::{Note, Robot};

/// The robot with names that can be shown.
pub(super) fn shown(mut robot: Robot) -> Robot {
    let mut hidden = Vec::new();
    let mut show = |what: &str, name: &mut String| {
        if name.contains(is_hidden) {
            *name = line(name).into_owned();
            hidden.push(format!("{what} `{name}`"));
        }
    };
    show("robot", &mut robot.name);
    robot.symbols.iter_mut().for_each(|symbol| show("symbol", &mut symbol.name));
    robot.coordinates.iter_mut().for_each(|coordinate| show("coordinate", &mut coordinate.name));
    robot.passive.iter_mut().for_each(|passive| show("joint", &mut passive.name));
    for link in &mut robot.links {
        show("link", &mut link.name);
        show("joint", &mut link.joint.name);
        // These repeat the names of links, joints and files.
        let quietly = |name: &mut String| *name = line(name).into_owned();
        quietly(&mut link.label);
        link.parts.iter_mut().for_each(|part| quietly(&mut part.name));
        link.frames.iter_mut().for_each(|(name, _)| quietly(name));
        link.collisions.iter_mut().for_each(|collision| quietly(&mut collision.link));
    }
    robot.base.parts.iter_mut().for_each(|part| part.name = line(&part.name).into_owned());
    robot.base.collisions.iter_mut().for_each(|collision| collision.link = line(&collision.link).into_owned());
    robot.source = robot.source.map(|source| line(&source).into_owned());
    for note in robot.notes.iter_mut().chain(&mut robot.snapped) {
        (note.subject, note.text) = (line(&note.subject).into_owned(), line(&note.text).into_owned());
    }
    if let Some(first) = hidden.first() {
        let others = if hidden.len() > 1 { format!(", and {} others,", hidden.len() - 1) } else { String::new() };
        let text = format!("{first}{others} holds characters that are not seen; they are shown by their numbers");
        robot.notes.push(Note { subject: "names".into(), text });
    }
    robot
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::format::{ReadOptions, parse_with};

    #[test]
    fn names_are_known_by_what_is_shown_of_them() {
        let text = "convention: khalil-kleinfinger\nname: \"r\\e]0;x\"\nlinks:\n  - {link: 1, name: \"a\\u202Eb\\nc\", antecedent: base, theta: q1}\n";
        let robot = parse_with(text, Path::new("r.yaml"), ReadOptions::default()).unwrap();
        assert_eq!((robot.name.as_str(), robot.links[0].name.as_str()), ("r\\u{1b}]0;x", "a\\u{202e}b\\nc"));
        assert!(robot.notes.iter().any(|note| note.subject == "names" && note.text.starts_with("robot `r")));
        let plain = parse_with(
            &text.replace("\\e", "").replace("\\u202E", "").replace("\\n", ""),
            Path::new("r.yaml"),
            ReadOptions::default(),
        );
        assert!(plain.unwrap().notes.iter().all(|note| note.subject != "names"));
    }
}
