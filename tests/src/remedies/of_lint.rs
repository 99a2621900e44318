//! Tests `rist lint`: descriptions with one mistake in the inertial of a link or in the limits of a joint.
//!
//! Each case is a description of a robot in URDF, in which one number is changed as by a mistake.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::arms::Arm;
use super::case::{Case, Command, Told, written};
use crate::program::Run;
use crate::random_situations::draw::Draw;

/// The kinds of mistakes, each with phrases of a finding that names it. One phrase is enough.
const KINDS: [(&str, &[&str]); 14] = [
    ("none", &[]),
    ("negative mass", &["the mass is negative"]),
    ("mass in g", &["no link is so heavy", "no metal is so dense", "the mass is far above", "the mass in g"]),
    ("centre in mm", &["the centre of mass is far from the joint", "outside the collision"]),
    ("inertia in kg mm^2", &["the inertia is too large for"]),
    ("swapped products", &["Ixz and Iyz exchanged"]),
    ("Pinocchio's order", &["Pinocchio's order"]),
    ("moved twice", &["taken off once too often"]),
    ("negative moment", &["no body has these moments"]),
    ("no inertia", &["the inertia is 0"]),
    ("no mass", &["the mass is 0, the inertia is not"]),
    ("limits in degrees", &["are degrees meant?"]),
    ("limits exchanged", &["is above its upper limit"]),
    ("placeholder", &["a placeholder of an exporter"]),
];
const INERTIA: [&str; 6] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];

pub const COMMAND: Command = Command { word: "lint", case, findings, obeyed };

fn case(seed: u64, arms: &[Arm]) -> Case<'_> {
    let draw = &mut Draw::of(seed, 1);
    let (name, says) = KINDS[(seed % KINDS.len() as u64) as usize];
    let arm = &arms[draw.below(arms.len())];
    let given = text_of(arm, "<!--", "-->");
    let able: Vec<Element> =
        Element::all(&given, "link").into_iter().filter(|link| link.number(&given, "mass", "value") > 0.05).collect();
    let link = able[draw.below(able.len())].clone();
    // The principal axes of this inertia differ from all frame axes. So a wrong order of its entries can be detected.
    let mut right = given;
    let body = oblique(name, link.number(&right, "mass", "value"), draw);
    link.set_inertia(&mut right, &body);
    let mut wrong = right.clone();
    let joints: Vec<Element> = Element::all(&right, "joint");
    let joints: Vec<&Element> = joints.iter().filter(|joint| arm.names().contains(&joint.name)).collect();
    let turns =
        joints.iter().filter(|joint| !arm.slides(arm.names().iter().position(|n| *n == joint.name).unwrap_or(0)));
    let turns: Vec<&&Element> = turns.collect();
    let mut subject = link.name.clone();
    let is_above = match name {
        "limits in degrees" | "limits exchanged" => {
            let joint = turns[draw.below(turns.len())];
            let limits = ["lower", "upper"].map(|side| joint.number(&right, "limit", side));
            let [low, high] =
                if name == "limits exchanged" { [limits[1], limits[0]] } else { limits.map(f64::to_degrees) };
            joint.set(&mut wrong, "limit", "upper", high);
            joint.set(&mut wrong, "limit", "lower", low);
            subject.clone_from(&joint.name);
            low.abs().max(high.abs()) > 13.0 || name == "limits exchanged"
        }
        _ => spoil(name, &link, &mut wrong, draw),
    };
    let [wrong, right] = [("wrong.urdf", wrong), ("right.urdf", right)].map(|(file, text)| written(file, &text));
    let words = |file: String| [vec!["lint".to_string(), file], arm.flags()].concat();
    let is_right =
        move |text: &str| says.iter().any(|words| text.contains(words)) && text.starts_with(&format!("{subject}: "));
    Case { arm, kind: name, is_right: Box::new(is_right), is_above, words: words(wrong), clean: Some(words(right)) }
}

/// The file of a robot without all text between `begin` and `end`.
pub(super) fn text_of(arm: &Arm, begin: &str, end: &str) -> String {
    let text = std::fs::read_to_string(&arm.path).unwrap_or_else(|e| panic!("{}: {e}", arm.path.display()));
    text.split(begin).map(|part| part.split_once(end).map_or(part, |(_, behind)| behind)).collect()
}

/// The inertia entries of a slender, physically possible body. It is rotated so that the entries in a wrong order, or about a
/// wrong point, are impossible.
fn oblique(kind: &str, mass: f64, draw: &mut Draw) -> [f64; 6] {
    loop {
        let turn = Rotation3::new(Vector3::from_fn(|_, _| draw.uniform(-2.0, 2.0))).into_inner();
        let size = mass * draw.uniform(0.05, 0.12).powi(2);
        let i = turn * Matrix3::from_diagonal(&Vector3::new(1.0, 0.95, 0.1)) * turn.transpose() * size;
        let six = [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]];
        let shows = match kind {
            "swapped products" => !can_exist(exchanged(six, 2, 4)),
            "Pinocchio's order" => !can_exist(exchanged(six, 2, 3)),
            _ => true,
        };
        if shows {
            return six;
        }
    }
}

fn exchanged(mut six: [f64; 6], a: usize, b: usize) -> [f64; 6] {
    six.swap(a, b);
    six
}

/// The inertia of a body moved by the parallel axis theorem: m (c.c E - c c^T) is added. c: the given position.
fn shifted(six: [f64; 6], mass: f64, [x, y, z]: [f64; 3]) -> [f64; 6] {
    let shift = [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y];
    std::array::from_fn(|i| six[i] + mass * shift[i])
}

fn can_exist([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> bool {
    let moments = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigenvalues();
    moments.min() > 0.0 && moments.sum() > 2.01 * moments.max()
}

/// Puts a mistake into the description of a link. Returns whether the mistake is large enough to be found.
fn spoil(kind: &str, link: &Element, text: &mut String, draw: &mut Draw) -> bool {
    let mass = link.number(text, "mass", "value");
    let six = INERTIA.map(|key| link.number(text, "inertia", key));
    let centre = link.centre(text);
    match kind {
        "none" => {
            let factor = draw.uniform(0.85, 1.15);
            link.set(text, "mass", "value", factor * mass);
            link.set_inertia(text, &six.map(|i| factor * i));
        }
        "negative mass" => link.set(text, "mass", "value", -mass),
        "no mass" => link.set(text, "mass", "value", 0.0),
        "mass in g" => link.set(text, "mass", "value", 1e3 * mass),
        "centre in mm" => link.set_centre(text, centre.map(|x| 1e3 * x)),
        "inertia in kg mm^2" => link.set_inertia(text, &six.map(|i| 1e6 * i)),
        "swapped products" => link.set_inertia(text, &exchanged(six, 2, 4)),
        "Pinocchio's order" => link.set_inertia(text, &exchanged(six, 2, 3)),
        "moved twice" => {
            let moved = shifted(six, -mass, centre);
            link.set_inertia(text, &moved);
            return !can_exist(moved);
        }
        "negative moment" => link.set_inertia(text, &[-six[0], six[1], six[2], six[3], six[4], six[5]]),
        "no inertia" => link.set_inertia(text, &[0.0; 6]),
        "placeholder" => {
            link.set(text, "mass", "value", 1.0);
            link.set_inertia(text, &[1.0, 0.0, 0.0, 1.0, 0.0, 1.0]);
        }
        _ => {}
    }
    kind != "centre in mm" || centre.iter().any(|x| x.abs() > 0.011)
}

#[derive(Clone)]
pub(super) struct Element {
    tag: &'static str,
    name: String,
}

impl Element {
    pub(super) fn all(text: &str, tag: &'static str) -> Vec<Element> {
        let begin = format!("<{tag} ");
        let heads = text.split(&begin).skip(1);
        let name =
            |head: &str| head.split_once("name=\"").and_then(|(_, rest)| Some(rest.split_once('"')?.0.to_string()));
        heads.filter_map(name).map(|name| Element { tag, name }).collect()
    }

    /// Inserts a text before the end of the element, if it has an end tag.
    pub(super) fn append(&self, text: &mut String, more: &str) {
        let begin = text.find(&format!("<{} name=\"{}\"", self.tag, self.name));
        let end = format!("</{}>", self.tag);
        let place = begin.and_then(|begin| Some(begin + text[begin..].find(&end)?));
        place.into_iter().for_each(|place| text.insert_str(place, more));
    }

    /// The position of the value of an attribute of a child element; `None` if it does not exist.
    fn place(&self, text: &str, child: &str, key: &str) -> Option<std::ops::Range<usize>> {
        let head = format!("<{} name=\"{}\"", self.tag, self.name);
        let begin = text.find(&head)?;
        // If the element has no end tag, it ends before the next element of the same kind begins.
        let behind = begin + head.len();
        let end = text[behind..].find(&format!("<{} ", self.tag)).map_or(text.len(), |length| behind + length);
        let begin = begin + if self.tag == "link" { text[begin..end].find("<inertial")? } else { 0 };
        let child = begin + text[begin..end].find(&format!("<{child} "))?;
        let close = child + text[child..].find('>')?;
        let value = child + text[child..close].find(&format!("{key}=\""))? + key.len() + 2;
        Some(value..value + text[value..].find('"')?)
    }

    fn string<'a>(&self, text: &'a str, child: &str, key: &str) -> &'a str {
        self.place(text, child, key).map_or("", |place| &text[place])
    }

    pub(super) fn number(&self, text: &str, child: &str, key: &str) -> f64 {
        self.string(text, child, key).parse().unwrap_or(0.0)
    }

    fn write(&self, text: &mut String, child: &str, key: &str, value: &str) {
        if let Some(place) = self.place(text, child, key) {
            text.replace_range(place, value);
        }
    }

    fn set(&self, text: &mut String, child: &str, key: &str, value: f64) {
        self.write(text, child, key, &format!("{value:?}"));
    }

    fn set_inertia(&self, text: &mut String, six: &[f64; 6]) {
        INERTIA.iter().zip(six).for_each(|(key, value)| self.set(text, "inertia", key, *value));
    }

    pub(super) fn centre(&self, text: &str) -> [f64; 3] {
        let numbers = self.string(text, "origin", "xyz").split_whitespace();
        let numbers: Vec<f64> = numbers.filter_map(|x| x.parse().ok()).collect();
        std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0))
    }

    fn set_centre(&self, text: &mut String, [x, y, z]: [f64; 3]) {
        self.write(text, "origin", "xyz", &format!("{x:?} {y:?} {z:?}"));
    }
}

fn findings(_: &[String], run: &Run) -> Vec<String> {
    let is_other = |line: &&str| {
        line.contains(" of them without parameters") || line.starts_with("total mass ") || line.starts_with("note: ")
    };
    run.out.lines().filter(|line| !is_other(line)).map(str::to_string).collect()
}

/// Does what a finding names: exchanges, or another unit.
fn obeyed(case: &Case, finding: &str) -> Told {
    let mut text = std::fs::read_to_string(&case.words[1]).ok()?;
    let name = finding.split_once(": ")?.0.to_string();
    let tag = if case.arm.names().contains(&name) { "joint" } else { "link" };
    let element = Element { tag, name };
    let six = INERTIA.map(|key| element.number(&text, "inertia", key));
    let mass = element.number(&text, "mass", "value");
    let centre = element.centre(&text);
    if finding.contains("taken off once too often") {
        element.set_inertia(&mut text, &shifted(six, mass, centre));
    } else if finding.contains("Ixz and Iyz exchanged") {
        element.set_inertia(&mut text, &exchanged(six, 2, 4));
    } else if finding.contains("Pinocchio's order") {
        element.set_inertia(&mut text, &exchanged(six, 2, 3));
    } else if finding.contains("with the mass in g that") {
        element.set(&mut text, "mass", "value", 1e-3 * mass);
    } else if finding.contains("with the centre of mass in mm that") {
        element.set_centre(&mut text, centre.map(|x| 1e-3 * x));
    } else if finding.contains("with the inertia in kg mm^2 that") {
        element.set_inertia(&mut text, &six.map(|i| 1e-6 * i));
    } else if finding.contains("are degrees meant?") {
        for side in ["lower", "upper"] {
            let limit = element.number(&text, "limit", side);
            element.set(&mut text, "limit", side, limit.to_radians());
        }
    } else {
        return None;
    }
    let file = written("obeyed.urdf", &text);
    Some(Ok([vec!["lint".to_string(), file], case.arm.flags()].concat()))
}
