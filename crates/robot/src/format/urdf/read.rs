//! Reads a robot from URDF and converts it to Khalil-Kleinfinger frames.
//!
//! repair.rs and text.rs check the text and keep line numbers. The library urdf-rs reads the text, tree.rs builds the tree of
//! moving links, and [`jointed`] makes a robot of it. A link with a fixed joint is lumped into the moving link that carries it.
//!
//! Joints with `<mimic>` follow another joint (mimic.rs).
//!
//! Collision geometry is kept unchanged (collision.rs).
//!
//! Not read: rotors (a URDF has none), mesh files.

use urdf_rs::JointType;

use super::mimic::followed;
use super::repair::check;
use super::text::Checked;
use super::tree::{MovingLink, MovingLinks, moving_links};
use crate::angle_snap;
use crate::error::Error;
use crate::format::expression::no_symbol;
use crate::format::follows::Follows;
use crate::format::jointed::{self, FileContext, FileJoint, LumpedBody};
use crate::format::node::DescriptionFile;
use crate::format::options::{Mimic, ReadOptions};
use crate::format::shown::shown;
use crate::inertial::{Part, Pose};
use crate::robot::{Format, Friction, Limits, Note, Robot, RotorInertia};
use crate::value::Value;

/// Reads a robot from a URDF text. `file`: name of the file in errors.
///
/// Each joint has its own coordinate with the name of the joint, unless it mimics another joint. There is no rotor inertia.
/// Gravity is (0, 0, -9.81) m/s^2 in the root link. Fails, with the line, unless the description is a tree of revolute,
/// continuous, prismatic and fixed joints with finite numbers.
pub fn read_urdf(text: &str, file: &str) -> Result<Robot, Error> {
    read_urdf_with(text, file, ReadOptions::default())
}

/// Reads a robot from a URDF text as [`read_urdf`] does, with options.
pub fn read_urdf_with(text: &str, file: &str, options: ReadOptions) -> Result<Robot, Error> {
    let source = DescriptionFile { file };
    no_values(source, options.values)?;
    let checked = check(source, text, options.floating_base)?;
    let model = urdf_rs::read_from_string(&checked.text)
        .map_err(|e| source.place(checked.at, format!("not a URDF: {}", shown(&e.to_string()))))?;
    let (mut notes, mut snapped) = (checked.notes.clone(), Vec::new());
    let floating = options.floating_base;
    let links = moving_links(source, &checked, &model, options.angles, floating, &mut snapped)?;
    let MovingLinks { moving, rooted } = links;
    let followed = followed(source, &checked, &model, options.mimic)?;
    let mut joints = Vec::with_capacity(moving.len());
    for moving in &moving {
        let joint = &model.joints[moving.joint];
        let limits = limits(joint, &checked, &mut notes);
        notes.extend(freed(joint, options.mimic));
        joints.push(file_joint(&model, &checked, moving, followed[moving.joint], limits, &mut notes));
    }
    // A joint is a coordinate if it follows no other joint (it is its own leader). A fixed base needs at least one coordinate.
    if !floating && !joints.iter().any(|joint| joint.follows.leader == joint.id) {
        return Err(source.place(checked.at, "no joint of the robot moves by itself"));
    }
    let base = jointed::base(&carried(&model, &checked, &rooted));
    // A URDF does not state gravity. The z axis of the base frame points upwards by convention.
    let rest = FileContext {
        name: if model.name.trim().is_empty() { "robot".into() } else { model.name },
        base,
        gravity: [Value::ZERO, Value::ZERO, Value::Number(-9.81)],
        loops: Vec::new(),
        notes,
        snapped,
    };
    Ok(Robot {
        visuals: checked.visuals,
        oddities: checked.oddities,
        format: Format::Urdf,
        ..jointed::robot(source, joints, rest, options.angles)?
    })
}

/// Fails if values of symbols are given, because a URDF has no symbols.
fn no_values(source: DescriptionFile, values: &[(String, f64)]) -> Result<(), Error> {
    match values.first() {
        Some((name, _)) => Err(source.whole(no_symbol(name, &[]))),
        None => Ok(()),
    }
}

/// The note if a mimic joint is read as an independent coordinate; otherwise `None`.
fn freed(joint: &urdf_rs::Joint, mimic: Mimic) -> Option<Note> {
    let text = "mimics another joint in the file; read as a coordinate of its own, as was asked";
    let is_freed = joint.mimic.is_some() && mimic == Mimic::Independent;
    is_freed.then(|| Note { subject: joint.name.clone(), text: text.into() })
}

fn file_joint(
    model: &urdf_rs::Robot,
    checked: &Checked,
    moving: &MovingLink,
    follows: Follows,
    limits: Limits,
    notes: &mut Vec<Note>,
) -> FileJoint {
    let joint = &model.joints[moving.joint];
    let carried = carried(model, checked, &moving.carried);
    note_weightless(&joint.child.link, &carried, checked, notes);
    // urdf-rs reads a missing value as zero. So a value counts as known only if the text contains the attribute of this value.
    let mark = checked.joints.get(&joint.name);
    let given = |has: bool, x: f64| has.then_some(x);
    let (damping, friction) = joint.dynamics.as_ref().map_or((0.0, 0.0), |d| (d.damping, d.friction));
    FileJoint {
        id: moving.joint,
        name: joint.name.clone(),
        at: mark.map_or((0, 0), |m| m.at),
        given: moving.given.clone(),
        follows,
        is_passive: false,
        limits,
        friction: Friction {
            viscous: given(mark.is_some_and(|m| m.has_damping), damping),
            coulomb: given(mark.is_some_and(|m| m.has_friction), friction),
            offset: None,
        },
        rotor_inertia: RotorInertia::Absent,
        link: joint.child.link.clone(),
        carried,
        is_massless: false,
    }
}

/// The bodies for links of the file, with inertials and shapes. `places`: index of each link, and its pose.
fn carried(model: &urdf_rs::Robot, checked: &Checked, places: &[(usize, Pose)]) -> Vec<LumpedBody> {
    let of = |(index, pose): &(usize, Pose)| {
        let link = &model.links[*index];
        let has_inertial = checked.links.get(&link.name).is_some_and(|mark| mark.has_inertial);
        LumpedBody {
            name: link.name.clone(),
            pose: *pose,
            part: has_inertial.then(|| part(link)),
            collisions: checked.collisions.get(&link.name).cloned().unwrap_or_default(),
        }
    };
    places.iter().map(of).collect()
}

/// The inertial of a link, in the frame of the link in the file.
fn part(link: &urdf_rs::Link) -> Part {
    let origin = &link.inertial.origin;
    let i = &link.inertial.inertia;
    Part {
        name: link.name.clone(),
        pose: Pose { rotation: angle_snap::rotation(&origin.rpy.map(Value::Number)), position: *origin.xyz },
        mass: link.inertial.mass.value,
        inertia: [i.ixx, i.ixy, i.ixz, i.iyy, i.iyz, i.izz],
    }
}

/// Adds notes on links without an inertial.
fn note_weightless(link: &str, carried: &[LumpedBody], checked: &Checked, notes: &mut Vec<Note>) {
    let mut note = |text: String| notes.push(Note { subject: link.into(), text });
    if carried.iter().all(|one| one.part.is_none()) {
        note("has no inertial: its standard parameters are unknown".into());
        return;
    }
    // A link without an inertial counts as massless. If it has a shape, a note tells the user.
    for one in carried.iter().filter(|one| one.part.is_none()) {
        if checked.links.get(&one.name).is_some_and(|mark| mark.has_shape) {
            note(format!("`{}` has no inertial and counts as massless", one.name));
        }
    }
}

/// The position limits, narrowed by the soft limits of the safety controller. `None` if the soft limits do not narrow the
/// position limits, or if the controller has only gains and no range.
fn soft_limits(joint: &urdf_rs::Joint, (low, high): (f64, f64)) -> Option<(f64, f64)> {
    let soft = joint.safety_controller.as_ref()?;
    let both = (low.max(soft.soft_lower_limit), high.min(soft.soft_upper_limit));
    (soft.soft_lower_limit < soft.soft_upper_limit && both.0 < both.1 && both != (low, high)).then_some(both)
}

fn limits(joint: &urdf_rs::Joint, checked: &Checked, notes: &mut Vec<Note>) -> Limits {
    let turns = joint.joint_type == JointType::Continuous;
    let mut note = |text: &str| notes.push(Note { subject: joint.name.clone(), text: text.into() });
    if !checked.joints.get(&joint.name).is_some_and(|m| m.has_limit) {
        if !turns {
            note("has no limit, though a URDF should give it one: taken as unlimited");
        }
        return Limits::default();
    }
    if !checked.joints.get(&joint.name).is_some_and(|m| m.has_velocity) {
        note("has a <limit> without a velocity: taken as none");
    }
    let limit = &joint.limit;
    let magnitude = |x: f64| (x > 0.0 && x.is_finite()).then_some(x);
    // urdf-rs reads missing limits as zero. Such a range of zero must not lock the joint.
    let is_written = checked.joints.get(&joint.name).is_some_and(|m| m.has_range);
    // CAD exporters write zeros for unknown limits. An intentionally locked joint has a non-zero velocity or effort limit.
    let is_blank = [limit.lower, limit.upper, limit.velocity, limit.effort].iter().all(|x| *x == 0.0);
    let has_range = !is_blank && (is_written || limit.lower < limit.upper);
    let position = (!turns && has_range).then_some((limit.lower, limit.upper));
    let soft = position.and_then(|position| soft_limits(joint, position));
    if let Some((low, high)) = soft {
        note(&format!("has soft limits (<safety_controller>): held to positions from {low} to {high}"));
    }
    match position {
        None if !turns && is_blank => note("has a <limit> of zeros alone: taken as unlimited"),
        None if !turns => note("has an empty range of limits: taken as unlimited"),
        Some((low, high)) if low == high => note("has the same lower and upper limit: it stands still"),
        Some((low, high)) if low > high => note("has a lower limit above its upper one: no motion keeps both"),
        _ => {}
    }
    Limits {
        position: soft.or(position),
        velocity: magnitude(limit.velocity),
        acceleration: magnitude(limit.acceleration),
        effort: magnitude(limit.effort),
    }
}
