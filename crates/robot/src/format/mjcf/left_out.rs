//! Notes on the elements of a model that are ignored because they are not part of the mechanism.

use super::bodies::MjcfBody;
use super::element::MjcfElement;
use super::joints::MjcfJoint;
use crate::error::Error;
use crate::robot::Note;

/// Sections of the file that get no note: other functions read them, or they do not change the mechanism.
const SILENT: &str = "compiler option size visual statistic default asset worldbody custom keyframe equality actuator";

/// Adds notes on data of the model that are not read: unknown sections, `gravcomp` of bodies, and springs of joints.
pub(super) fn note(
    root: &MjcfElement,
    bodies: &[MjcfBody],
    joints: &[MjcfJoint],
    notes: &mut Vec<Note>,
) -> Result<(), Error> {
    // A section may stand several times in a file. Each kind of section is listed once.
    let mut sections: Vec<&str> = Vec::new();
    let is_silent = |tag: &str| SILENT.split(' ').any(|silent| silent == tag);
    for section in root.children.iter().filter(|s| !s.children.is_empty() && !is_silent(&s.tag)) {
        if !sections.contains(&section.tag.as_str()) {
            sections.push(&section.tag);
        }
    }
    let subject = || "model".to_string();
    if !sections.is_empty() {
        let mut text = format!("{} in the file: not read, a robot has no place for it", sections.join(", "));
        if sections.contains(&"tendon") {
            text += "; what tendons pull is missing in its torques";
        }
        notes.push(Note { subject: subject(), text });
    }
    // An attribute with the value 0 changes nothing, so it needs no note.
    let has = |name: &str| bodies.iter().filter(|b| b.element.attribute(name).is_some_and(|x| x.trim() != "0")).count();
    if has("gravcomp") > 0 {
        let text = "`gravcomp` of bodies is not read: the torques here are those against all of gravity";
        notes.push(Note { subject: subject(), text: text.into() });
    }
    let mut springs = Vec::new();
    for joint in joints {
        if joint.view.number("stiffness")?.is_some_and(|k| k != 0.0) {
            springs.push(joint.name.as_str());
        }
    }
    if !springs.is_empty() {
        let text = format!(
            "{} have springs (`stiffness`), which are not read: theirs is no torque of the robot",
            springs.join(", ")
        );
        notes.push(Note { subject: subject(), text });
    }
    Ok(())
}
