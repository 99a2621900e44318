//! Functions of the library that write identified parameters into URDF and MJCF files.
//!
//! Bodies are the identified ten inertial parameters of each link. If the verdict on them is no, nothing is written. Friction
//! terms that a format cannot express are listed in notes.

use std::path::Path;

use linear_model::parameter::FrictionParameter::*;
use linear_model::parameter::ParameterId;

use crate::write_back::body::JointDynamics;
use crate::write_back::mjcf::mjcf;
use crate::write_back::mjcf_into::mjcf_into;
use crate::write_back::repairs::write_repairs;
use crate::write_back::urdf::{WrittenBack, write_back};

use crate::describe::description::{ModelOptions, parse_robot, without_macros};
use crate::describe::linting::{Lint, lint_with_meshes};
use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::samples::Bodies;
use identification::estimate::artefact::Estimate;
use robot::lint::{Finding, RepairedBody, Severity};
use robot::{Format, Link, Part, Pose, Robot};

/// The URDF with identified inertials, joint damping and friction; all other text stays. The notes name identified parameters
/// that a URDF cannot express.
///
/// Fails if the text is no URDF. Fails with a verdict error if the identified bodies must not be used.
pub fn write_urdf(model: &Model, urdf: &str, bodies: &Bodies, estimate: &Estimate) -> Result<WrittenBack, Error> {
    let file = model.path.display().to_string();
    if !urdf.contains("<robot") {
        let other = "; into an MJCF writes [write_mjcf], with [into]";
        let other = if urdf.contains("<mujoco") { other } else { "" };
        return Err(Error::new(format_args!("{file}: [write_urdf] needs a model that is a URDF{other}")));
    }
    usable(bodies)?;
    let dynamics = joint_dynamics(model, bodies, estimate).unwrap_or_default();
    let mut written = write_back(urdf, &file, &model.robot, &bodies.links, &dynamics)?;
    let mut notes = missing_in_a_urdf(model, bodies, estimate);
    notes.append(&mut written.notes);
    Ok(WrittenBack { notes, ..written })
}

/// The description `text` (URDF, MJCF or YAML) with the repairs of a search for mistakes, and the names of the bodies that they
/// change; all other text is unchanged, but macros are expanded. The result is read and searched again.
///
/// Fails with a verdict if no finding has a repair whose numbers are determined, or if a repaired body still has a finding.
pub fn write_repaired(
    found: &Lint,
    text: &str,
    path: &Path,
    options: &ModelOptions,
) -> Result<(String, Vec<String>), Error> {
    let repaired = |f: &Finding| f.repair.as_ref().is_some_and(|repair| !repair.bodies.is_empty());
    let bodies: Vec<&RepairedBody> =
        found.findings.iter().filter_map(|f| f.repair.as_ref()).flat_map(|repair| &repair.bodies).collect();
    if bodies.is_empty() {
        return Err(Error::verdict("nothing is written: no finding has a repair that alone is plausible"));
    }
    let (text, file) = (without_macros(text, path, options)?, path.display().to_string());
    let read = |text: &str| parse_robot(text, path, options);
    let written = write_repairs(&text, &file, &read(&text)?, &bodies)?;
    let robot = read(&written)?;
    // Findings that were known before and have no repair are allowed to remain.
    let is_known =
        |g: &Finding| found.findings.iter().any(|f| !repaired(f) && (f.mistake, &f.fact) == (g.mistake, &g.fact));
    let is_repaired = |name: &String| bodies.iter().any(|body| body.name == *name);
    let again = lint_with_meshes(&robot, path.parent().unwrap_or(Path::new("")), None).findings;
    let left =
        again.iter().find(|f| f.severity() != Severity::Note && f.subjects.iter().any(is_repaired) && !is_known(f));
    if let Some(finding) = left {
        return Err(Error::verdict(format_args!(
            "nothing is written: the file with the repair has a finding: {finding}"
        )));
    }
    if let Some(body) = bodies.iter().find(|body| !is_in(&robot, body)) {
        return Err(Error::verdict(format_args!(
            "nothing is written: {file} would not give {} the repaired numbers",
            body.name
        )));
    }
    Ok((written, bodies.iter().map(|body| body.name.clone()).collect()))
}

/// Largest rounding error of a number that is written and read, as a fraction of the largest number of the body.
const ROUNDING: f64 = 1e-9;

/// Whether the robot has this body: compares the ten parameters about the origin of the frame that the file gives the body.
fn is_in(robot: &Robot, body: &RepairedBody) -> bool {
    let RepairedBody { ref name, mass, pose, inertia, .. } = *body;
    let wanted = Part { name: name.clone(), pose, mass, inertia }.parameters();
    let largest = wanted.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let near = |x: &[f64; 10]| x.iter().zip(wanted).all(|(x, wanted)| (x - wanted).abs() <= ROUNDING * largest);
    let of_file =
        |part: &Part, to_file: Pose| near(&Part { pose: to_file.compose(&part.pose), ..part.clone() }.parameters());
    let frame =
        |link: &Link| link.frames.iter().find(|frame| frame.0 == *name).map_or(link.file_frame, |frame| frame.1);
    let in_base = robot.base.parts.iter().any(|part| part.name == *name && of_file(part, Pose::IDENTITY));
    in_base
        || robot.links.iter().any(|link| match link.inertial {
            Some(x) if link.parts.is_empty() => link.name == *name && near(&x),
            _ => link.parts.iter().any(|part| part.name == *name && of_file(part, frame(link).inverse())),
        })
}

/// A MuJoCo model with the identified bodies, joint damping, friction loss and armature. It is a new model without shapes, or
/// the existing model `into` (name and text).
///
/// Fails if an included file cannot be read.
pub fn own_mjcf(model: &Model, text: &str, options: &ModelOptions) -> Result<Option<String>, Error> {
    if model.robot.format != Format::Mjcf || !text.contains("<mujoco") {
        return Ok(None);
    }
    without_macros(text, &model.path, options).map(Some)
}

/// A MuJoCo model with the identified bodies, joint damping, friction loss and armature. It is a new model without shapes, or
/// the existing model `into` (name and text); if this is the file of `model`, its frames need no check.
///
/// Fails if the friction terms of the estimate cannot be written as damping and friction loss, if `into` is `None` and the robot
/// floats or has loops, or if frames of `into` differ from the description. Fails with a verdict error if the identified bodies
/// must not be used.
pub fn write_mjcf(
    model: &Model,
    bodies: &Bodies,
    estimate: &Estimate,
    into: Option<(&str, &str)>,
) -> Result<WrittenBack, Error> {
    usable(bodies)?;
    let Some(joints) = joint_dynamics(model, bodies, estimate) else {
        return Err(Error::new("[write_mjcf] needs [friction=viscous,coulomb] or asymmetric"));
    };
    let mut written = match into {
        Some((file, text)) => {
            let is_own = *file == *model.path.display().to_string();
            mjcf_into(text, file, &model.robot, &bodies.links, &joints, is_own)?
        }
        None => WrittenBack { text: mjcf(&model.robot, &bodies.links, &joints)?, notes: Vec::new() },
    };
    if has_offsets(estimate) {
        written.notes.push("MuJoCo has no offset of friction: OFF is not in the file".into());
    }
    written.notes.extend(other_friction(estimate, "MuJoCo"));
    Ok(written)
}

fn usable(bodies: &Bodies) -> Result<(), Error> {
    match &bodies.refusal {
        Some(reason) => Err(Error::verdict(format_args!("nothing is written for a simulator: {reason}"))),
        None => Ok(()),
    }
}

/// Viscous friction, Coulomb friction and rotor inertia of every joint. If friction is asymmetric, the mean of both directions
/// is taken. `None` if a joint lacks viscous or Coulomb friction.
fn joint_dynamics(model: &Model, bodies: &Bodies, estimate: &Estimate) -> Option<Vec<JointDynamics>> {
    let friction = |(coordinate, armature): (&String, &f64)| {
        let value = |parameter| estimate.value(&ParameterId::friction(parameter, coordinate));
        let mean = |forward, backward, sign: f64| Some(0.5 * (value(forward)? + sign * value(backward)?));
        // Negative friction becomes zero, because simulators refuse negative friction.
        let damping = value(Viscous).or_else(|| mean(ViscousForward, ViscousBackward, 1.0))?.max(0.0);
        let friction = value(Coulomb).or_else(|| mean(CoulombForward, CoulombBackward, -1.0))?.max(0.0);
        Some(JointDynamics { joint: coordinate.clone(), damping, friction, armature: *armature })
    };
    model.regressor().coordinates().iter().zip(&bodies.armatures).map(friction).collect()
}

/// Sentences for the user on identified parameters that a URDF cannot express.
fn missing_in_a_urdf(model: &Model, bodies: &Bodies, estimate: &Estimate) -> Vec<String> {
    let mut notes = Vec::new();
    if joint_dynamics(model, bodies, estimate).is_none() {
        notes.push(
            "no friction is written: every joint needs a value of viscous and coulomb, or of asymmetric friction"
                .into(),
        );
    }
    let rotors = model.regressor().coordinates().iter().zip(&bodies.armatures).filter(|(_, a)| **a > 0.0);
    let rotors: Vec<String> = rotors.map(|(c, a)| format!("{c} {a:.4}")).collect();
    if !rotors.is_empty() {
        notes.push(format!(
            "a URDF has no rotor inertia; what the file lacks, kg m^2 ([write_mjcf] writes it as armature): {}",
            rotors.join(", ")
        ));
    }
    if has_offsets(estimate) {
        notes.push("a URDF has no offset of friction: OFF is not in the file".into());
    }
    notes.extend(other_friction(estimate, "a URDF"));
    notes
}

/// A sentence on identified friction that is neither viscous nor Coulomb friction; `None` if there is no such friction.
fn other_friction(estimate: &Estimate, format: &str) -> Option<String> {
    let is_other = |id: &ParameterId| matches!(id, ParameterId::Friction(friction, _) if friction.is_other_friction());
    let ids = estimate.parameters.iter().map(|p| &p.id).filter(|id| is_other(id));
    let names: Vec<String> = ids.map(ParameterId::to_string).collect();
    (!names.is_empty()).then(|| {
        format!(
            "{format} has viscous and Coulomb friction alone: {} are not in the file, and FV and FS without them are not \
             those of [friction=viscous,coulomb]",
            names.join(" ")
        )
    })
}

fn has_offsets(estimate: &Estimate) -> bool {
    estimate.parameters.iter().any(|p| matches!(p.id, ParameterId::Friction(Offset, _)))
}
