//! Finds suspicious texts in a URDF that cannot be seen in the robot after reading: angles in degrees, limits of zero, and texts
//! that urdfdom (the reader of ROS and Pinocchio) interprets differently or refuses. [`crate::lint`] reports them. Loops of URDF
//! extensions get notes.
//!
//! The behaviour of urdfdom was tested with Pinocchio 4.1. For example, it does not accept a number with a trailing blank.

use std::f64::consts::TAU;

use roxmltree::Node;

use crate::finding::{Finding, Mistake};
use crate::format::shown::shown;
use crate::format::xml::child;
use crate::robot::Note;

/// A full turn plus an allowance for values rounded to four digits, rad.
const A_TURN_RAD: f64 = TAU + 1e-3;

/// The findings for all links and joints, in the order of the text.
pub(super) fn oddities(root: Node) -> Vec<Finding> {
    let mut findings = Vec::new();
    for owner in root.children().filter(|n| n.has_tag_name("link") || n.has_tag_name("joint")) {
        let name = owner.attribute("name").unwrap_or("");
        let mut find = |mistake, text| findings.push(Finding::new(name, mistake, text, ""));
        turned_by_degrees(owner, &mut find);
        if owner.has_tag_name("joint") {
            zeros(owner, &mut find);
            refused_elsewhere(owner, &mut find);
        }
        below_the_diagonal(owner, &mut find);
        blanks(owner, &mut find);
    }
    findings
}

/// Notes on elements of URDF extensions that close a loop. Such a loop is not read, because the elements do not state which of
/// its joints are driven.
pub(super) fn stated_loops(root: Node) -> Vec<Note> {
    let is_loop = |n: &Node| {
        let tag = n.tag_name().name();
        let in_extension = n.parent().is_some_and(|p| p.has_tag_name("gazebo"));
        matches!(
            tag,
            "constraint" | "loop_joint" | "loop" | "linear_bushing_rpy" | "ball_constraint" | "weld_constraint"
        ) || (tag == "joint" && in_extension)
    };
    let note = |n: Node| {
        let name = n.attribute("name").map_or_else(|| format!("<{}>", n.tag_name().name()), str::to_string);
        let line = n.document().text_pos_at(n.range().start).row;
        let text = format!(
            "<{}> on line {line} closes a loop, which is not read: the robot is taken cut open there; a description in YAML \
             has loops and says which joints are driven",
            n.tag_name().name()
        );
        Note { subject: name, text }
    };
    root.descendants().filter(Node::is_element).filter(is_loop).map(note).collect()
}

fn number(node: Node, attribute: &str) -> Option<f64> {
    node.attribute(attribute)?.trim().parse().ok()
}

/// Finds rpy angles of more than a turn, in all elements except visuals.
fn turned_by_degrees(owner: Node, find: &mut impl FnMut(Mistake, String)) {
    let origins =
        owner.descendants().filter(|n| n.has_tag_name("origin") && !n.ancestors().any(|a| a.has_tag_name("visual")));
    for origin in origins {
        let Some(rpy) = origin.attribute("rpy") else { continue };
        let far = rpy.split_whitespace().filter_map(|x| x.parse::<f64>().ok()).find(|x| x.abs() > A_TURN_RAD);
        if let Some(x) = far {
            find(
                Mistake::Degrees,
                format!("its rpy is `{}`, in rad: {x} is more than a turn; are degrees meant?", shown(rpy)),
            );
        }
    }
}

/// Finds limits of zero. CAD exporters write zero if a limit is unknown.
fn zeros(joint: Node, find: &mut impl FnMut(Mistake, String)) {
    let Some(limit) = child(joint, "limit") else { return };
    let all = ["lower", "upper", "effort", "velocity"].map(|key| number(limit, key).unwrap_or(0.0));
    // If all four limits are zero, the reader of the URDF (read.rs) adds a note instead of a finding.
    if all == [0.0; 4] || joint.attribute("type") == Some("fixed") {
        return;
    }
    for (key, consequence) in [("effort", "applies no torque"), ("velocity", "never moves the joint")] {
        if number(limit, key) == Some(0.0) {
            let text = format!("its limit of the {key} is 0: taken for none here, but who believes it {consequence}");
            find(Mistake::Limits, text);
        }
    }
}

/// Finds joints that lack an attribute without which urdfdom (the reader of ROS and Pinocchio) refuses the whole file.
fn refused_elsewhere(joint: Node, find: &mut impl FnMut(Mistake, String)) {
    let limited = matches!(joint.attribute("type"), Some("revolute" | "prismatic"));
    let mut refused =
        |what: &str| find(Mistake::OtherReaders, format!("{what}: urdfdom (ROS, Pinocchio) refuses the file"));
    match child(joint, "limit") {
        None if limited => refused("it has no <limit>"),
        None => {}
        Some(limit) => {
            for key in ["effort", "velocity"] {
                if !limit.has_attribute(key) {
                    refused(&format!("its <limit> has no {key}"));
                }
            }
        }
    }
    if child(joint, "dynamics").is_some_and(|n| !n.has_attribute("damping") && !n.has_attribute("friction")) {
        refused("its <dynamics> has neither damping nor friction");
    }
}

/// Finds entries below the diagonal of the inertia that differ from the entries above the diagonal. The reader uses only the
/// entries above it.
fn below_the_diagonal(owner: Node, find: &mut impl FnMut(Mistake, String)) {
    let Some(inertia) = child(owner, "inertial").and_then(|n| child(n, "inertia")) else { return };
    let differs =
        |(above, below): &(&str, &str)| number(inertia, below).is_some_and(|x| number(inertia, above) != Some(x));
    let entries: Vec<String> = [("ixy", "iyx"), ("ixz", "izx"), ("iyz", "izy")]
        .into_iter()
        .filter(differs)
        .map(|(above, below)| {
            let value = |key| shown(inertia.attribute(key).unwrap_or("absent"));
            format!("{above} {}, {below} {}", value(above), value(below))
        })
        .collect();
    if !entries.is_empty() {
        let text = format!(
            "the inertia is not symmetric ({}): ixy, ixz and iyz are read, as by urdfdom; correct them if needed, and \
             delete the entries below the diagonal, which a URDF does not have",
            entries.join("; ")
        );
        find(Mistake::NotSymmetric, text);
    }
}

/// Finds numbers with a blank or a line break at the end.
fn blanks(owner: Node, find: &mut impl FnMut(Mistake, String)) {
    let elements = ["mass", "inertia", "limit", "dynamics", "mimic"];
    let scalars =
        || "value ixx ixy ixz iyy iyz izz lower upper effort velocity damping friction multiplier offset".split(' ');
    for node in owner.descendants().filter(|n| elements.contains(&n.tag_name().name())) {
        let blank = |key: &&str| node.attribute(*key).is_some_and(|x| x.ends_with(char::is_whitespace));
        let Some(key) = scalars().find(blank) else { continue };
        let tag = node.tag_name().name();
        let does = match tag {
            "mass" => "takes the link for massless",
            "inertia" => "takes the inertia for 0",
            _ => "refuses the file",
        };
        find(
            Mistake::OtherReaders,
            format!("`{key}` of its <{tag}> ends with a blank or a line break: urdfdom (ROS, Pinocchio) {does}"),
        );
    }
}

#[cfg(test)]
mod tests {
    use crate::format::read_urdf;
    use crate::lint::{Mistake, lint};

    /// The findings for joint j and link l of a small URDF, in which `old` was replaced by `new`.
    fn found(old: &str, new: &str) -> Vec<(String, Mistake)> {
        let text = "<robot name=\"r\"><link name=\"b\"/><link name=\"l\"><inertial><origin xyz=\"0 0 0.1\" rpy=\"0 0 0\"/><mass \
                    value=\"1.5\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial>\
                    <visual><origin rpy=\"0 0 90\"/></visual></link><joint name=\"j\" type=\"revolute\"><origin xyz=\"0 0 1\" \
                    rpy=\"0 0 6.2832\"/><parent link=\"b\"/><child link=\"l\"/><axis xyz=\"0 1 0\"/><limit lower=\"-2\" upper=\"2\" \
                    effort=\"50\" velocity=\"3\"/><dynamics damping=\"0.1\"/></joint></robot>";
        assert!(text.contains(old), "{old}");
        let robot = read_urdf(&text.replacen(old, new, 1), "r.urdf").unwrap_or_else(|e| panic!("{e}"));
        lint(&robot).into_iter().map(|f| (f.subjects.join(", "), f.mistake)).collect()
    }

    #[test]
    fn each_oddity_is_told_of_its_link_or_joint() {
        let of = |name: &str, mistake| vec![(name.to_string(), mistake)];
        for (old, new, wanted) in [
            ("6.2832", "90", of("j", Mistake::Degrees)),
            ("rpy=\"0 0 0\"", "rpy=\"0 -90 0\"", of("l", Mistake::Degrees)),
            ("effort=\"50\"", "effort=\"0\"", of("j", Mistake::Limits)),
            ("velocity=\"3\"", "velocity=\"0.0\"", of("j", Mistake::Limits)),
            ("velocity=\"3\"", "", of("j", Mistake::OtherReaders)),
            ("damping=\"0.1\"", "", of("j", Mistake::OtherReaders)),
            ("value=\"1.5\"", "value=\"1.5\n\"", of("l", Mistake::OtherReaders)),
            ("ixx=\"0.01\"", "ixx=\"0.01 \"", of("l", Mistake::OtherReaders)),
            ("upper=\"2\"", "upper=\"2 \"", of("j", Mistake::OtherReaders)),
            ("ixz=\"0\"", "ixz=\"0\" izx=\"0.007\"", of("l", Mistake::NotSymmetric)),
            ("<limit lower=\"-2\" upper=\"2\" effort=\"50\" velocity=\"3\"/>", "", of("j", Mistake::OtherReaders)),
        ] {
            assert_eq!(found(old, new), wanted, "{new}");
        }
    }

    /// These texts give no findings: a full turn, leading blanks, a continuous joint, and limits that are all zero (the reader
    /// adds a note on such limits).
    #[test]
    fn what_is_usual_is_not_told() {
        for (old, new) in [
            ("6.2832", "-3.1416"),
            ("value=\"1.5\"", "value=\" 1.5\""),
            ("ixz=\"0\"", "ixz=\"0\" izx=\"0.0\" iyx=\"0\""),
            ("xyz=\"0 0 1\"", "xyz=\"0 0 1 \""),
            ("damping=\"0.1\"", "friction=\"0.1\""),
            (
                "lower=\"-2\" upper=\"2\" effort=\"50\" velocity=\"3\"",
                "lower=\"0\" upper=\"0\" effort=\"0\" velocity=\"0\"",
            ),
            ("\"revolute\"", "\"continuous\""),
        ] {
            assert_eq!(found(old, new), [], "{new}");
        }
    }
}
