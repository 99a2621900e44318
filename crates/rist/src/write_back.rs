//! Writes identified parameters into the files that simulators read.

use identification::model::parameter::FrictionParameter::*;
use identification::model::parameter::ParameterId;
use identification::write::write_back::{JointDynamics, WrittenBack, mjcf_joints};

use crate::Estimate;
use crate::error::Error;
use crate::model::Model;
use crate::samples::Bodies;

/// A URDF with the identified bodies, joint damping and friction; the rest of the text as it was. Its notes say what a
/// URDF has no place for.
///
/// Fails where the text is no URDF, and with a verdict where the bodies are not to be used.
pub fn write_urdf(model: &Model, urdf: &str, bodies: &Bodies, estimate: &Estimate) -> Result<WrittenBack, Error> {
    let file = model.path.display().to_string();
    if !urdf.trim_start().starts_with('<') {
        return Err(Error::new(format_args!("{file}: --write-urdf needs a model that is a URDF")));
    }
    usable(bodies)?;
    let dynamics = joint_dynamics(model, estimate).unwrap_or_default();
    let write_back = identification::write::write_back::write_back;
    let mut written = write_back(urdf, &file, &model.robot, &bodies.links, &dynamics)?;
    let mut notes = missing_in_a_urdf(model, bodies, estimate);
    notes.append(&mut written.notes);
    Ok(WrittenBack { notes, ..written })
}

/// MuJoCo's `<joint>` elements with damping, friction loss and armature.
///
/// Fails where the friction of the estimate has no damping and friction loss, and with a verdict where the bodies are
/// not to be used.
pub fn write_mjcf_joints(model: &Model, bodies: &Bodies, estimate: &Estimate) -> Result<String, Error> {
    usable(bodies)?;
    match joint_dynamics(model, estimate) {
        Some(dynamics) => Ok(mjcf_joints(&dynamics, &bodies.armatures)),
        None => Err(Error::new("--write-mjcf needs --friction viscous,coulomb or asymmetric")),
    }
}

fn usable(bodies: &Bodies) -> Result<(), Error> {
    match &bodies.refusal {
        Some(reason) => Err(Error::verdict(format_args!("nothing is written for a simulator: {reason}"))),
        None => Ok(()),
    }
}

/// Viscous and Coulomb friction of every joint, asymmetric friction by the mean of its directions; `None` where the
/// estimate has neither.
fn joint_dynamics(model: &Model, estimate: &Estimate) -> Option<Vec<JointDynamics>> {
    let friction = |coordinate: &String| {
        let value = |parameter| estimate.value(&ParameterId::friction(parameter, coordinate));
        let mean = |forward, backward, sign: f64| Some(0.5 * (value(forward)? + sign * value(backward)?));
        // Simulators refuse friction that drives.
        let damping = value(Viscous).or_else(|| mean(ViscousForward, ViscousBackward, 1.0))?.max(0.0);
        let friction = value(Coulomb).or_else(|| mean(CoulombForward, CoulombBackward, -1.0))?.max(0.0);
        Some(JointDynamics { joint: coordinate.clone(), damping, friction })
    };
    model.regressor().coordinates().iter().map(friction).collect()
}

/// Sentences on what a URDF has no place for.
fn missing_in_a_urdf(model: &Model, bodies: &Bodies, estimate: &Estimate) -> Vec<String> {
    let mut notes = Vec::new();
    if joint_dynamics(model, estimate).is_none() {
        notes.push("no friction is written: viscous and coulomb, or asymmetric, are not both in the model".into());
    }
    let rotors = model.regressor().coordinates().iter().zip(&bodies.armatures).filter(|(_, a)| **a > 0.0);
    let rotors: Vec<String> = rotors.map(|(c, a)| format!("{c} {a:.4}")).collect();
    if !rotors.is_empty() {
        notes.push(format!(
            "a URDF has no rotor inertia; what the file lacks, kg m^2 (--write-mjcf writes it as armature): {}",
            rotors.join(", ")
        ));
    }
    let is_offset = |id: &ParameterId| matches!(id, ParameterId::Friction(Offset, _));
    if estimate.parameters.iter().any(|p| is_offset(&p.id)) {
        notes.push("a URDF has no offset of friction: OFF is not in the file".into());
    }
    notes
}
