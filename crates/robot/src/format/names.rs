//! Makes names printable.
//!
//! A name may contain invisible characters, or characters that change how their neighbours are displayed. Such a name is replaced
//! by its printable form ([`gate::shown::line`]) when it is read. The names are used in tables, comments, generated source,
//! column heads, and artefacts (files such as plans and estimates). A note tells the user.

use gate::shown::{is_hidden, line};

use crate::robot::{Note, Robot};

/// Replaces all names of the robot by their printable forms, and adds a note for each changed name.
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
        // These names are copies of names that already got a note (links, joints, files), so they get no second note.
        let quietly = |name: &mut String| *name = line(name).into_owned();
        quietly(&mut link.label);
        link.parts.iter_mut().for_each(|part| quietly(&mut part.name));
        link.frames.iter_mut().for_each(|(name, _)| quietly(name));
        link.collisions.iter_mut().for_each(|collision| quietly(&mut collision.link));
    }
    robot.base.parts.iter_mut().for_each(|part| part.name = line(&part.name).into_owned());
    robot
        .base
        .collisions
        .iter_mut()
        .chain(&mut robot.visuals)
        .for_each(|collision| collision.link = line(&collision.link).into_owned());
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

/// Largest length of a name, characters. Names become keys of YAML (at most 1024 characters), identifiers in generated
/// source, and column heads.
const MAX_NAME_CHARACTERS: usize = 256;

/// Number of characters that a message shows of a long name.
const SHOWN_NAME_CHARACTERS: usize = 40;

/// The message about the first name that is too long; `None` if no name is too long.
pub(super) fn too_long(robot: &Robot) -> Option<String> {
    let symbols = robot.symbols.iter().map(|symbol| ("symbol", &symbol.name));
    let coordinates = robot.coordinates.iter().map(|coordinate| ("coordinate", &coordinate.name));
    let passive = robot.passive.iter().map(|passive| ("joint", &passive.name));
    let links = robot
        .links
        .iter()
        .flat_map(|link| [("joint", &link.joint.name), ("link", &link.name), ("the label of a link:", &link.label)]);
    let mut all = symbols.chain(coordinates).chain(passive).chain(links);
    let (what, name) = all.find(|(_, name)| name.chars().nth(MAX_NAME_CHARACTERS).is_some())?;
    let start: String = name.chars().take(SHOWN_NAME_CHARACTERS).collect();
    Some(format!("{what} `{start}..`: a name has at most {MAX_NAME_CHARACTERS} characters"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::format::{ReadOptions, parse_with};

    #[test]
    fn names_are_known_by_what_is_shown_of_them() {
        let text = "convention: khalil-kleinfinger\nname: \"r\\e]0;x\"\nlinks:\n  - {link: 1, name: \"a\\u202Eb\\nc\", antecedent: base, theta: q1}\n";
        let read = |text: &str| parse_with(text, Path::new("r.yaml"), ReadOptions::default()).unwrap();
        let robot = read(text);
        assert_eq!((robot.name.as_str(), robot.links[0].name.as_str()), ("r\\u{1b}]0;x", "a\\u{202e}b\\nc"));
        assert!(robot.notes.iter().any(|note| note.subject == "names" && note.text.starts_with("robot `r")));
        let plain = read(&text.replace("\\e", "").replace("\\u202E", "").replace("\\n", ""));
        assert!(plain.notes.iter().all(|note| note.subject != "names"));
    }

    /// A name that is too long to be a YAML key (1024 characters) is refused, so every name that is read can also be written.
    #[test]
    fn a_name_without_end_is_refused_in_every_format() {
        let urdf = |name: &str| {
            format!(
                "<robot name=\"r\"><link name=\"b\"/><link name=\"l\"><inertial><mass value=\"1\"/>\
                 <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\
                 <joint name=\"{name}\" type=\"continuous\"><parent link=\"b\"/><child link=\"l\"/></joint></robot>"
            )
        };
        let read = |text: &str, file: &str| parse_with(text, Path::new(file), ReadOptions::default());
        let longest = read(&urdf(&"é".repeat(256)), "r.urdf").unwrap();
        let (written, _) = crate::format::write_yaml(&longest);
        assert!(read(&written, "again.yaml").is_ok(), "{written}");
        let yaml =
            "convention: khalil-kleinfinger\nname: r\nlinks:\n  - {link: 1, name: NAME, antecedent: base, theta: q1}\n";
        for (text, file) in [(urdf(&"j".repeat(257)), "r.urdf"), (yaml.replace("NAME", &"j".repeat(257)), "r.yaml")] {
            let message = read(&text, file).unwrap_err().to_string();
            assert!(message.contains("`jjj") && message.contains("at most 256 characters"), "{message}");
        }
    }
}
