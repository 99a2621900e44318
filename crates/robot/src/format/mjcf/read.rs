//! A robot described in MJCF, re-framed to Khalil-Kleinfinger.
//!
//! element.rs reads the elements and included files, defaults.rs the attributes of their classes. bodies.rs and
//! joints.rs order them into a tree of joints, and [`jointed`] makes a robot of them. Coordinates and their order are the
//! ones of MuJoCo. The mass of a body is from its `<inertial>` or its shapes (inertials.rs). `armature` of a joint and
//! of its actuators is a rotor inertia, `damping` and `frictionloss` are friction.
//!
//! Not read: tendons, contacts, springs, muscles; ball joints (refused); soft bodies and bodies created by rules
//! (refused, with the call that writes them out).

use std::path::Path;

use super::actuators::{MjcfActuator, drives, gears};
use super::bodies::{MjcfBody, bodies};
use super::compiler::Compiler;
use super::defaults::{Defaults, View};
use super::element::{self, MjcfElement};
use super::equalities::{Equalities, equalities};
use super::inertials::part;
use super::joints::{Moved, moved};
use super::left_out;
use super::meshes::Meshes;
use crate::error::Error;
use crate::format::expression::no_symbol;
use crate::format::jointed::{self, FileContext, FileJoint, LumpedBody};
use crate::format::node::DescriptionFile;
use crate::format::options::ReadOptions;
use crate::robot::{Limits, Note, Robot};
use crate::value::Value;

/// Reads a robot from MJCF; `file` is the name in errors, `folder` the folder of its includes and meshes.
///
/// Fails, with the file and the line, on a model that is not a tree of hinges and slides with finite numbers and a base,
/// fixed or floating, as in `options`.
pub(in crate::format) fn read_mjcf_with(
    text: &str,
    file: &str,
    folder: Option<&Path>,
    options: ReadOptions,
) -> Result<Robot, Error> {
    let source = DescriptionFile { file };
    if let Some((name, _)) = options.values.first() {
        return Err(source.whole(no_symbol(name, &[])));
    }
    let root = element::read(text, file, folder)?;
    let defaults = Defaults::new(&root)?;
    let compiler = Compiler::new(&root, options.angles)?;
    let meshes = Meshes::new(&root, &defaults, &compiler, folder)?;
    let (mut notes, mut snapped) = (Vec::new(), Vec::new());
    let bodies = bodies(&root, &defaults, &compiler, &mut snapped)?;
    let mut moved = moved(&bodies, &compiler, options.floating_base, &mut notes)?;
    let drives = drives(&root, &defaults, &mut moved.joints, &mut notes)?;
    let tied = equalities(&root, &defaults, &bodies, &moved, &drives, options.mimic, &mut notes)?;
    let mut carried = carried(&bodies, &moved, &compiler, &meshes, &mut snapped)?;
    if let Some(total) = compiler.total_mass {
        scale_to(&mut carried, total);
    }
    let rooted = carried.pop().unwrap_or_default();
    let joints = file_joints(&bodies, &moved, &drives, &tied, carried, &mut notes);
    if !options.floating_base && !joints.iter().any(|joint| joint.follows.leader == joint.id && !joint.is_passive) {
        return Err(root.error("no joint of the robot moves by itself; its base may float: [floating_base=true]"));
    }
    let leads = |k: &usize| joints[*k].follows.leader == *k && !joints[*k].is_passive;
    notes.extend(gears((0..joints.len()).filter(leads).map(|k| (joints[k].name.as_str(), &drives[k]))));
    left_out::note(&root, &bodies, &moved.joints, &mut notes)?;
    let rest = FileContext {
        name: root.attribute("model").map(str::trim).filter(|n| !n.is_empty()).unwrap_or("robot").to_string(),
        base: jointed::base(&rooted),
        gravity: gravity(&root)?,
        loops: tied.loops,
        notes,
        snapped,
    };
    jointed::robot(source, joints, rest, options.angles)
}

/// The bodies that each joint carries, and as the last entry the bodies fixed to the base.
fn carried(
    bodies: &[MjcfBody],
    moved: &Moved,
    compiler: &Compiler,
    meshes: &Meshes,
    snapped: &mut Vec<Note>,
) -> Result<Vec<Vec<LumpedBody>>, Error> {
    let mut carried = vec![Vec::new(); moved.joints.len() + 1];
    for (b, body) in bodies.iter().enumerate().filter(|(b, _)| moved.is_part[*b]) {
        let (carrier, pose) = moved.carriers[b];
        // The shapes of the world have no mass.
        let part = match b {
            0 => None,
            _ => part(&body.name, body.inertial, &body.shapes, compiler, meshes, snapped)?,
        };
        let mut collisions = Vec::new();
        for shape in &body.shapes {
            collisions.extend(shape.collision(&body.name, meshes)?);
        }
        let one = LumpedBody { name: body.name.clone(), pose, part, collisions };
        carried[carrier.unwrap_or(moved.joints.len())].push(one);
    }
    Ok(carried)
}

/// Scales all masses so that they add up to a total.
fn scale_to(carried: &mut [Vec<LumpedBody>], total: f64) {
    let mass: f64 = carried.iter().flatten().filter_map(|one| one.part.as_ref()).map(|part| part.mass).sum();
    if mass <= 0.0 {
        return;
    }
    for part in carried.iter_mut().flatten().filter_map(|one| one.part.as_mut()) {
        part.mass *= total / mass;
        part.inertia = part.inertia.map(|i| i * total / mass);
    }
}

fn file_joints(
    bodies: &[MjcfBody],
    moved: &Moved,
    drives: &[MjcfActuator],
    tied: &Equalities,
    carried: Vec<Vec<LumpedBody>>,
    notes: &mut Vec<Note>,
) -> Vec<FileJoint> {
    let mut joints = Vec::with_capacity(moved.joints.len());
    for (k, (joint, carried)) in moved.joints.iter().zip(carried).enumerate() {
        let body = &bodies[joint.body];
        let is_last = moved.carriers[joint.body].0 == Some(k);
        if is_last && carried.iter().all(|one| one.part.is_none()) {
            let text = "has neither an inertial nor shapes that weigh: it counts as massless";
            notes.push(Note { subject: body.name.clone(), text: text.into() });
        }
        let follows = tied.follows[k];
        // The limits of a following joint narrow the range of its leader: relative to the position in the file.
        let shift = if follows.leader == k { 0.0 } else { joint.reference };
        let limits = Limits {
            position: joint.limits.position.map(|(low, high)| (low - shift, high - shift)),
            effort: [joint.limits.effort, drives[k].effort].into_iter().flatten().reduce(f64::min),
            ..joint.limits
        };
        joints.push(FileJoint {
            id: k,
            name: joint.name.clone(),
            at: joint.view.element.at(),
            given: joint.given.clone(),
            follows,
            is_passive: tied.passive.contains(&k),
            limits,
            friction: joint.friction,
            rotor_inertia: joint.rotor_inertia(),
            link: if is_last { body.name.clone() } else { between(&body.name, &joint.name, bodies) },
            carried,
            is_massless: true,
        });
    }
    joints
}

/// The name of the massless link between two joints of a body.
fn between(body: &str, joint: &str, bodies: &[MjcfBody]) -> String {
    let mut name = format!("{body}_{joint}");
    while bodies.iter().any(|body| body.name == name) {
        name.push('_');
    }
    name
}

/// Gravity of a model that gives none, m/s^2.
const DEFAULT_GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// Gravity in the world frame, m/s^2.
fn gravity(root: &MjcfElement) -> Result<[Value; 3], Error> {
    let mut gravity = DEFAULT_GRAVITY;
    for element in root.children("option") {
        gravity = View::bare(element).vector("gravity")?.unwrap_or(gravity);
    }
    Ok(if root.disables("gravity") { [0.0; 3] } else { gravity }.map(Value::Number))
}
