//! Reads `<actuator>`: the driven joints, their gear ratios and largest efforts.
//!
//! An actuator with gear g, `armature` J (kg m^2) and `damping` d (N m s/rad) adds g^2 J to the rotor inertia of its joint
//! and g^2 d to the viscous friction of its joint, as in MuJoCo.

use super::defaults::{Defaults, View};
use super::element::MjcfElement;
use super::joints::{MjcfJoint, POLYNOMIAL_DAMPING};
use crate::error::Error;
use crate::format::shown::shown;
use crate::robot::Note;
use gate::suggestion::did_you_mean;

/// The actuators of a joint: whether there is one, the gear ratio, and the largest effort.
#[derive(Clone, Debug)]
pub(super) struct MjcfActuator {
    pub is_driven: bool,
    /// Gear ratio: angle of the actuator per angle of the joint.
    pub gear: f64,
    /// Largest effort of the actuators at the joint, N m or N; `None` without a limit.
    pub effort: Option<f64>,
}

/// The actuator data of each joint, in the order of `joints`. Armature and damping of the actuators are added to the joints.
pub(super) fn drives(
    root: &MjcfElement,
    defaults: &Defaults,
    joints: &mut [MjcfJoint],
    notes: &mut Vec<Note>,
) -> Result<Vec<MjcfActuator>, Error> {
    let mut drives = vec![MjcfActuator { is_driven: false, gear: 1.0, effort: None }; joints.len()];
    for element in root.children("actuator").flat_map(|actuators| &actuators.children) {
        let view = defaults.view(element, None)?;
        let armature = view.number("armature")?.unwrap_or(0.0);
        let damping = view.numbers("damping", 1, 9)?.unwrap_or_default();
        let mut left_out = |what: &str| notes.push(Note { subject: element.called(), text: what.into() });
        let name = view.get("joint").or(view.get("jointinparent"));
        let Some(k) = name.and_then(|name| joints.iter().position(|joint| joint.name == name)) else {
            if let Some(name) = name
                && !root_has_joint(root, name)
            {
                let meant = did_you_mean(name, joints.iter().map(|joint| joint.name.as_str()));
                return Err(element.error(format!(
                    "{} drives `{}`, which is no joint{meant}",
                    element.called(),
                    shown(name)
                )));
            }
            // The actuator drives a free joint: its torque is not measured, so its data are not used.
            if armature != 0.0 || damping.iter().any(|d| *d != 0.0) {
                left_out("moves no hinge and no slide: its `armature` and `damping` are not read");
            }
            continue;
        };
        if damping.iter().skip(1).any(|d| *d != 0.0) {
            left_out(POLYNOMIAL_DAMPING);
        }
        drives[k].is_driven = true;
        let gear = view.numbers("gear", 1, 6)?.map_or(1.0, |gear| gear[0]);
        let effort = most(view, gear)?;
        drives[k].effort = match (drives[k].effort, effort) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
        if gear != 0.0 {
            drives[k].gear = gear;
        }
        joints[k].armature += gear * gear * armature;
        if let Some(d) = damping.first().filter(|d| **d != 0.0) {
            *joints[k].friction.viscous.get_or_insert(0.0) += gear * gear * d;
        }
    }
    Ok(drives)
}

/// A note on gear ratios other than one. It shows the line that the user adds to the options of a log if the log has positions
/// and torques of the motors.
pub(super) fn gears<'a>(coordinates: impl Iterator<Item = (&'a str, &'a MjcfActuator)>) -> Option<Note> {
    let all: Vec<(&str, f64)> = coordinates.map(|(name, drives)| (name, drives.gear)).collect();
    let geared: Vec<String> =
        all.iter().filter(|(_, gear)| *gear != 1.0).map(|(name, gear)| format!("{name} {gear}")).collect();
    let ratios: Vec<String> = all.iter().map(|(_, gear)| gear.to_string()).collect();
    let text = format!(
        "have gears in the file ({}): of a log with positions and torques of the motors say `transmission: {{ratios: \
         [{}]}}`",
        geared.join(", "),
        ratios.join(", ")
    );
    (!geared.is_empty()).then(|| Note { subject: "actuators".into(), text })
}

/// The largest effort of an actuator at its joint, N m or N; `None` without a limit.
fn most(view: View, gear: f64) -> Result<Option<f64>, Error> {
    let within = |range: &str, limited: &str| -> Result<Option<f64>, Error> {
        let given = view.vector::<2>(range)?.filter(|[low, high]| low < high);
        let is_limited = view.flag(limited)?.unwrap_or(true);
        Ok(given.filter(|_| is_limited).map(|[low, high]| low.abs().max(high.abs())))
    };
    let force = within("forcerange", "forcelimited")?;
    // The force of a `motor` equals its control signal, so the control range also limits the force.
    let control = if view.element.tag == "motor" { within("ctrlrange", "ctrllimited")? } else { None };
    let least = match (force, control) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    };
    Ok(least.map(|force| force * gear.abs()).filter(|force| *force > 0.0))
}

/// Whether a joint or free joint with this name exists, outside of `<actuator>`.
fn root_has_joint(element: &MjcfElement, name: &str) -> bool {
    let is_it = |e: &MjcfElement| ["joint", "freejoint"].contains(&e.tag.as_str()) && e.attribute("name") == Some(name);
    element.children.iter().filter(|e| e.tag != "actuator").any(|e| is_it(e) || root_has_joint(e, name))
}
