//! Removes the dynamics of actuators whose joints have identified values.
//!
//! MuJoCo adds the armature and damping of an actuator to the armature and damping of its joint. The identified values of the
//! joint already include the actuator. So armature and damping become 0 in actuators.

use gate::shown;
use roxmltree::{Document, Node};

use crate::write_back::body::JointDynamics;
use crate::write_back::text_edit::Edits;

/// Sets the armature and damping of actuators to zero, because the identified values of their joints include them. Returns a
/// sentence on this change; `None` if no actuator and no default has armature or damping.
pub(super) fn empty_actuators(document: &Document, joints: &[JointDynamics], edits: &mut Edits) -> Option<String> {
    const EMPTIED: [&str; 2] = ["armature", "damping"];
    let is_inside = |node: &Node, tag: &str| node.ancestors().skip(1).any(|above| above.has_tag_name(tag));
    let is_joint = |node: &Node| node.has_tag_name("joint") || node.has_tag_name("tendon");
    let has = |node: Node| {
        (is_inside(&node, "actuator") || is_inside(&node, "default") && !is_joint(&node))
            && EMPTIED.iter().any(|key| node.has_attribute(*key))
    };
    if !document.descendants().any(has) {
        return None;
    }
    let mut names = Vec::new();
    for actuator in document.descendants().filter(|node| node.is_element() && is_inside(node, "actuator")) {
        let driven = actuator.attribute("joint").or(actuator.attribute("jointinparent")).map(shown::line);
        if joints.iter().any(|joint| driven.as_ref().is_some_and(|name| *name == joint.joint)) {
            edits.set_attributes(&actuator, &EMPTIED.map(|key| (key, "0".to_string())));
            names.push(actuator.attribute("name").or(actuator.attribute("joint")).unwrap_or("an actuator"));
        }
    }
    (!names.is_empty()).then(|| {
        format!("armature and damping of actuators are in those of their joints now, and 0 in {}", names.join(", "))
    })
}
