//! Checks a URDF text before urdf-rs reads it, and reads data that urdf-rs does not provide.
//!
//! urdf-rs has no line numbers. It reads a missing inertial as a massless link and a missing limit as zeros, and it accepts NaN.
//! So this file checks every element of the mechanism, with its line, and writes a text with only these elements for urdf-rs.

use std::collections::BTreeMap;
use std::fmt::Write;

use roxmltree::{Document, Node};

use super::collision::shapes;
use super::oddities::{oddities, stated_loops};
use crate::collision::Collision;
use crate::error::Error;
use crate::finding::Finding;
use crate::format::budget::MAX_LINKS;
use crate::format::expression::LARGEST_NUMBER;
use crate::format::node::DescriptionFile;
use crate::format::shown::shown;
use crate::format::xml::{child, document};
use crate::robot::Note;
use gate::suggestion::{did_you_mean, nearest};

/// A type of element: its name, the children that are read, and the attributes that are read. Each attribute has its name, the
/// count of numbers in it (0: the attribute is a text), and whether it is required.
type UrdfElement = (&'static str, &'static [&'static str], &'static [(&'static str, usize, bool)]);

/// All elements that are read, with their children and attributes.
const KNOWN_ELEMENTS: [UrdfElement; 14] = [
    ("robot", &["link", "joint"], &[("name", 0, false)]),
    ("link", &["inertial"], &[("name", 0, true)]),
    ("inertial", &["origin", "mass", "inertia"], &[]),
    ("mass", &[], &[("value", 1, true)]),
    (
        "inertia",
        &[],
        &[("ixx", 1, true), ("ixy", 1, true), ("ixz", 1, true), ("iyy", 1, true), ("iyz", 1, true), ("izz", 1, true)],
    ),
    (
        "joint",
        &["origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "safety_controller"],
        &[("name", 0, true), ("type", 0, true)],
    ),
    ("origin", &[], &[("xyz", 3, false), ("rpy", 3, false)]),
    ("parent", &[], &[("link", 0, true)]),
    ("child", &[], &[("link", 0, true)]),
    ("axis", &[], &[("xyz", 3, true)]),
    (
        "limit",
        &[],
        &[
            ("lower", 1, false),
            ("upper", 1, false),
            ("effort", 1, false),
            ("velocity", 1, false),
            ("acceleration", 1, false),
        ],
    ),
    ("dynamics", &[], &[("damping", 1, false), ("friction", 1, false)]),
    (
        "safety_controller",
        &[],
        &[("soft_lower_limit", 1, false), ("soft_upper_limit", 1, false), ("k_velocity", 1, false)],
    ),
    ("mimic", &[], &[("joint", 0, true), ("multiplier", 1, false), ("offset", 1, false)]),
];

/// Elements of a URDF that are ignored here.
const UNUSED_ELEMENTS: &str = "visual collision contact self_collision_checking calibration material transmission gazebo \
    sensor";

/// Required children: name of the element, and name of the child that it must have.
const REQUIRED_CHILDREN: [(&str, &str); 3] = [("inertial", "mass"), ("joint", "parent"), ("joint", "child")];

/// Line and column of an element in the file.
pub(super) type Position = (usize, usize);

/// The place of a link in the text, and which elements it has.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinkMark {
    pub at: Position,
    pub has_inertial: bool,
    /// Whether the link has a visual or a collision element.
    pub has_shape: bool,
}

/// The places of a joint in the text, and which attributes it has.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointMark {
    pub at: Position,
    pub axis_at: Position,
    pub parent_at: Position,
    pub child_at: Position,
    pub mimic_at: Position,
    pub has_limit: bool,
    pub has_velocity: bool,
    /// Whether both position limits are written in the file.
    pub has_range: bool,
    pub has_damping: bool,
    pub has_friction: bool,
}

/// A URDF text that was checked, with data that urdf-rs does not provide.
#[derive(Clone, Debug)]
pub(super) struct Checked {
    /// An XML text that contains only the elements of the mechanism.
    pub text: String,
    pub at: Position,
    pub links: BTreeMap<String, LinkMark>,
    pub joints: BTreeMap<String, JointMark>,
    /// The collision shapes of each link, by its name, in the frame of the link in the file.
    pub collisions: BTreeMap<String, Vec<Collision>>,
    /// The visual shapes of the links without a collision shape.
    pub visuals: Vec<Collision>,
    /// Notes on values that were changed, and on ignored elements.
    pub notes: Vec<Note>,
    /// Findings about suspicious texts, which lint reports.
    pub oddities: Vec<Finding>,
}

/// The message of the error that a URDF has macros.
pub(in crate::format) const IS_A_MACRO: &str = "is a macro, and a .urdf has none";

/// Largest absolute value of a joint limit, SI units.
const LARGEST_LIMIT: f64 = 1e100;

/// Checks a URDF text that is XML. `floats`: whether a floating base was requested; then a floating joint at the root is
/// omitted.
pub(super) fn check_xml(source: DescriptionFile, text: &str, floats: bool) -> Result<Checked, Error> {
    let document = document(source, text, "a URDF")?;
    let root = document.root_element();
    let base = if floats { floating_root(root) } else { None };
    let mut reader =
        UrdfChecker { source, document: &document, out: String::new(), notes: Vec::new(), left_out: Vec::new() };
    if let Some((joint, link)) = base {
        let text = "lets the base float, as is asked for: neither it nor its parent is a part of the robot";
        reader.notes.push(Note { subject: joint.attribute("name").unwrap_or("").to_string(), text: text.into() });
        reader.left_out = vec![joint, link];
    }
    reader.notes.extend(stated_loops(root));
    if root.tag_name().name() != "robot" {
        let message = format!("a URDF begins with <robot>, found <{}>", shown(root.tag_name().name()));
        return Err(reader.error(root, message));
    }
    if let Some(xacro) = root.descendants().find(|n| n.tag_name().namespace().is_some_and(|n| n.contains("xacro"))) {
        let message = format!("<xacro:{}> {IS_A_MACRO}", shown(xacro.tag_name().name()));
        return Err(reader.error(xacro, message));
    }
    for tag in ["link", "joint"] {
        if let Some(node) = root.children().filter(|n| n.has_tag_name(tag)).nth(MAX_LINKS) {
            return Err(reader.error(node, format!("more than {MAX_LINKS} {tag}s are no robot")));
        }
    }
    // `copy` refuses links and joints without a name, so `links` and `joints` may read a missing name as an empty text.
    reader.copy(root, "the robot")?;
    let of_links = || root.children().filter(|n| n.has_tag_name("link"));
    let named = |n: Node| (n.attribute("name").unwrap_or("").to_string(), shapes(n, "collision"));
    Ok(Checked {
        at: reader.at(root),
        links: reader.links(root)?,
        joints: reader.joints(root)?,
        text: reader.out,
        collisions: of_links().map(named).collect(),
        visuals: of_links().filter(|n| child(*n, "collision").is_none()).flat_map(|n| shapes(n, "visual")).collect(),
        notes: reader.notes,
        oddities: oddities(root),
    })
}

/// A hint for the error that a word is no number.
fn way_out(tag: &str, word: &str) -> &'static str {
    let lower = word.to_lowercase();
    match () {
        () if word.contains(',') => ": numbers have a point, and blanks between them",
        () if lower.contains("pi") => ": a URDF has numbers alone, a .xacro has expressions",
        () if tag == "limit" && lower.contains("inf") => ": leave out a limit that there is not",
        () => "",
    }
}

struct UrdfChecker<'a, 'i> {
    source: DescriptionFile<'a>,
    document: &'a Document<'i>,
    out: String,
    notes: Vec<Note>,
    /// Elements that are ignored because they describe the floating base.
    left_out: Vec<Node<'a, 'i>>,
}

/// The floating or planar joint that carries the base, and its parent link. `None` if there is no such joint, or if its parent
/// link has other joints.
fn floating_root<'a, 'i>(root: Node<'a, 'i>) -> Option<(Node<'a, 'i>, Node<'a, 'i>)> {
    let joints = || root.children().filter(|n| n.has_tag_name("joint"));
    let end = |joint: Node, tag: &str| child(joint, tag).and_then(|n| n.attribute("link")).map(str::to_string);
    let joint = joints().find(|j| matches!(j.attribute("type"), Some("floating" | "planar")))?;
    let parent = end(joint, "parent")?;
    let others = joints().filter(|j| *j != joint);
    let is_ground = others.into_iter().all(|j| ![end(j, "parent"), end(j, "child")].contains(&Some(parent.clone())));
    let link = root.children().find(|n| n.has_tag_name("link") && n.attribute("name") == Some(parent.as_str()))?;
    is_ground.then_some((joint, link))
}

impl<'a, 'i> UrdfChecker<'a, 'i> {
    fn error(&self, node: Node, message: String) -> Error {
        let at = self.at(node);
        self.source.error(at.0, at.1, message)
    }

    fn at(&self, node: Node) -> Position {
        let at = self.document.text_pos_at(node.range().start);
        (at.row as usize, at.col as usize)
    }

    /// Checks an element and its children, and writes them to `out`. `owner`: name of its link or joint in errors.
    fn copy(&mut self, node: Node<'a, 'i>, owner: &str) -> Result<(), Error> {
        if self.left_out.contains(&node) {
            return Ok(());
        }
        let tag = node.tag_name().name();
        let Some((_, children, attributes)) = KNOWN_ELEMENTS.iter().find(|e| e.0 == tag) else { return Ok(()) };
        let named = match (tag, node.attribute("name")) {
            ("link" | "joint", Some(name)) => format!("{tag} `{}`", shown(name)),
            _ => owner.to_string(),
        };
        if tag == "origin" && node.has_attribute("quat_xyzw") {
            return Err(self.error(node, format!("`quat_xyzw` of {named} is not read: give its orientation as rpy")));
        }
        // Writing to a `String` cannot fail, so the result is ignored.
        let _ = write!(self.out, "<{tag}");
        for &(attribute, count, required) in *attributes {
            match node.attribute(attribute) {
                Some(value) => {
                    let value = self.attribute(node, &named, attribute, value, count)?;
                    let _ = write!(self.out, " {attribute}=\"{value}\"");
                }
                // urdf-rs requires a velocity. read.rs treats a zero as no limit.
                None if (tag, attribute) == ("limit", "velocity") => self.out += " velocity=\"0\"",
                None if attribute == "k_velocity" => self.out += " k_velocity=\"0\"",
                None if required => {
                    return Err(self.error(node, format!("<{tag}> of {named} has no `{attribute}`")));
                }
                None => {}
            }
        }
        self.out.push('>');
        for inner in node.children().filter(Node::is_element) {
            let name = inner.tag_name().name();
            if !children.contains(&name) {
                // Unknown elements belong to other programs and are skipped. An element with a misspelt name is an error,
                // because it would be ignored without notice.
                let is_unused = UNUSED_ELEMENTS.split_whitespace().any(|unused| unused == name);
                if let Some(meant) = nearest(name, children.iter().copied()).filter(|_| !is_unused) {
                    let message = format!("unknown element <{}> of {named}: did you mean <{meant}>?", shown(name));
                    return Err(self.error(inner, message));
                }
                continue;
            }
            if tag != "robot" && child(node, name) != Some(inner) {
                let line = self.at(inner).0;
                let text =
                    format!("<{name}> stands twice, again on line {line}: the first is taken, as other readers do");
                self.notes.push(Note { subject: named.clone(), text });
                continue;
            }
            self.copy(inner, &named)?;
        }
        if tag == "inertial" && child(node, "inertia").is_none() {
            self.without_inertia(node, &named);
        }
        for (of, name) in REQUIRED_CHILDREN {
            if of == tag && child(node, name).is_none() {
                return Err(self.error(
                    node,
                    format!("{named} has no <{name}>{}", if tag == "inertial" { " in its <inertial>" } else { "" }),
                ));
            }
        }
        let _ = write!(self.out, "</{tag}>");
        Ok(())
    }

    /// Writes zero moments for an `<inertial>` without `<inertia>`, because urdfdom keeps its mass and sets the moments to
    /// zero.
    fn without_inertia(&mut self, node: Node, named: &str) {
        self.out += r#"<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>"#;
        let line = self.at(node).0;
        let text = format!(
            "its <inertial> on line {line} has no <inertia>: the mass is read as a point, as by urdfdom (Pinocchio)"
        );
        self.notes.push(Note { subject: named.to_string(), text });
    }

    /// The value of an attribute, escaped for XML. Fails if a number is not finite or if the count of numbers is wrong.
    fn attribute(&self, node: Node, named: &str, attribute: &str, value: &str, count: usize) -> Result<String, Error> {
        let place = format!("`{attribute}` in <{}> of {named}", node.tag_name().name());
        if count == 0 {
            if value.trim().is_empty() && node.tag_name().name() != "robot" {
                return Err(self.error(node, format!("{place} is empty")));
            }
            let escaped = value.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
            // An XML reader turns unescaped line breaks and tabs in an attribute into blanks, so they are escaped here.
            return Ok(escaped.replace('\n', "&#10;").replace('\r', "&#13;").replace('\t', "&#9;"));
        }
        let words: Vec<&str> = value.split_whitespace().collect();
        if words.len() != count {
            let wanted = if count == 1 { "one number".to_string() } else { format!("{count} numbers") };
            return Err(self.error(node, format!("{place} must be {wanted}, found `{}`", shown(value))));
        }
        // A limit may be very large on purpose: it then means that there is no limit.
        let largest = if node.tag_name().name() == "limit" { LARGEST_LIMIT } else { LARGEST_NUMBER };
        for word in &words {
            match word.parse::<f64>() {
                Ok(x) if x.abs() <= largest => {}
                Ok(x) if x.is_finite() => {
                    let message = format!("{place} is {x:e}: no robot has a number beyond {largest:e}");
                    return Err(self.error(node, message));
                }
                _ => {
                    let way = way_out(node.tag_name().name(), word);
                    return Err(self.error(node, format!("{place}: `{}` is not a finite number{way}", shown(word))));
                }
            }
        }
        Ok(words.join(" "))
    }

    fn links(&self, root: Node) -> Result<BTreeMap<String, LinkMark>, Error> {
        let mut links: BTreeMap<String, LinkMark> = BTreeMap::new();
        for node in root.children().filter(|n| n.has_tag_name("link") && !self.left_out.contains(n)) {
            let name = node.attribute("name").unwrap_or("").to_string();
            let has = |tag: &str| child(node, tag).is_some();
            let mark = LinkMark {
                at: self.at(node),
                has_inertial: has("inertial"),
                has_shape: has("visual") || has("collision"),
            };
            if let Some(first) = links.get(&name) {
                let message = format!("link `{}` stands twice, first on line {}", shown(&name), first.at.0);
                return Err(self.error(node, message));
            }
            links.insert(name, mark);
        }
        Ok(links)
    }

    fn joints(&self, root: Node) -> Result<BTreeMap<String, JointMark>, Error> {
        const KINDS: [&str; 7] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical"];
        let mut joints: BTreeMap<String, JointMark> = BTreeMap::new();
        for node in root.children().filter(|n| n.has_tag_name("joint") && !self.left_out.contains(n)) {
            let name = node.attribute("name").unwrap_or("").to_string();
            let kind = node.attribute("type").unwrap_or("");
            // Three checks with different messages: the type is unknown; the joint lets the base float; the type is not read.
            if !KINDS.contains(&kind) {
                let meant = did_you_mean(kind, KINDS[..4].iter().copied());
                let message = format!(
                    "joint `{}` is of the unknown type `{}`{meant}; there are revolute, continuous, prismatic and fixed ones",
                    shown(&name),
                    shown(kind)
                );
                return Err(self.error(node, message));
            }
            if !KINDS[..4].contains(&kind) && floating_root(root).is_some_and(|(joint, _)| joint == node) {
                let message = format!(
                    "joint `{}` is {kind}: the base floats, which is asked for by [floating_base=true]; for a base that \
                     stands make it fixed",
                    shown(&name)
                );
                return Err(self.error(node, message));
            }
            if !KINDS[..4].contains(&kind) {
                let message = format!(
                    "joint `{}` is {kind}: only revolute, continuous, prismatic and fixed joints are read; make it \
                     fixed, or a chain of revolute and prismatic ones",
                    shown(&name)
                );
                return Err(self.error(node, message));
            }
            let at = |tag: &str| self.at(child(node, tag).unwrap_or(node));
            let has = |tag: &str, a: &str| child(node, tag).is_some_and(|n| n.has_attribute(a));
            let mark = JointMark {
                at: self.at(node),
                axis_at: at("axis"),
                parent_at: at("parent"),
                child_at: at("child"),
                mimic_at: at("mimic"),
                has_limit: child(node, "limit").is_some(),
                has_velocity: has("limit", "velocity"),
                has_range: has("limit", "lower") && has("limit", "upper"),
                has_damping: has("dynamics", "damping"),
                has_friction: has("dynamics", "friction"),
            };
            if let Some(first) = joints.get(&name) {
                let message = format!("joint `{}` stands twice, first on line {}", shown(&name), first.at.0);
                return Err(self.error(node, message));
            }
            joints.insert(name, mark);
        }
        Ok(joints)
    }
}
