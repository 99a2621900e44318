//! A robot described in URDF, re-framed to Khalil-Kleinfinger.
//!
//! text.rs checks the text with its line numbers, urdf-rs reads it, tree.rs orders it into a tree of moving links, and
//! reframe.rs gives every moving link a frame with z on its joint axis. Fixed links are lumped into the moving link
//! they hang on. [`Link::file_frame`] and [`Link::parts`] keep what leads back to the file. At the end the re-framed
//! robot is checked against the file: every joint frame of the URDF is where the file has it.
//!
//! Joints that mimic another follow it (mimic.rs).
//!
//! Collision geometry is kept as it stands (collision.rs).
//!
//! Not here: rotors (a URDF describes none), the files of meshes.

use urdf_rs::JointType;

use super::mimic::{Follows, followed};
use super::reframe::{Framed, Given, MadeParallel, NEARLY_PARALLEL_RAD, frames, make_parallel};
use super::shown::shown;
use super::text::{Checked, check};
use super::tree::{Moving, MovingLinks, moving_links};
use crate::agreement::make_one;
use crate::angle_snap::{self, Angles};
use crate::closure::{configurations, distance};
use crate::collision::Collision;
use crate::error::Error;
use crate::format::expression::no_symbol;
use crate::format::node::Source;
use crate::format::options::{Mimic, ReadOptions};
use crate::inertial::{Part, Pose};
use crate::kinematics::sin_cos;
use crate::robot::{
    Base, Coordinate, Drive, Friction, Joint, JointKind, Limits, Link, LinkId, Note, Robot, RotorInertia,
};
use crate::value::Affine;
use crate::value::{CoordinateId, Value};
use crate::vector::{rotation_about, scaled};

/// Distance, m, and angle, rad, between a joint frame of the file and the re-framed one.
const REFRAMING_TOLERANCE: f64 = 1e-9;

/// Reads a robot from URDF; `file` is the name errors carry.
///
/// Joints are labelled by their names, one coordinate each unless they mimic another, without rotor
/// inertia. Gravity is (0, 0, -9.81) in the root link. Fails, with the line, on anything but a tree
/// of revolute, continuous, prismatic and fixed joints with finite numbers.
pub fn read_urdf(text: &str, file: &str) -> Result<Robot, Error> {
    read_urdf_with(text, file, ReadOptions::default())
}

/// As [`read_urdf`], with options.
pub fn read_urdf_with(text: &str, file: &str, options: ReadOptions) -> Result<Robot, Error> {
    let source = Source { file };
    no_values(source, options.values)?;
    let checked = check(source, text)?;
    let model = urdf_rs::read_from_string(&checked.text)
        .map_err(|e| source.place(checked.at, format!("not a URDF: {}", shown(&e.to_string()))))?;
    let (mut notes, mut snapped) = (Vec::new(), Vec::new());
    let floating = options.floating_base;
    let links = moving_links(source, &checked, &model, options.angles, floating, &mut snapped)?;
    let MovingLinks { mut moving, rooted } = links;
    let made = make_parallel(moving.iter_mut().map(|m| &mut m.given), options.angles);
    let name = |at: usize| &model.joints[moving[at].joint].name;
    snapped.extend(made.iter().map(|made| taken_as_parallel(made, name(made.link), name(made.antecedent))));
    let given: Vec<Given> = moving.iter().map(|m| m.given.clone()).collect();
    let framed = frames(&given);

    let followed = followed(source, &checked, &model, options.mimic)?;
    let follows: Vec<Follows> = moving.iter().map(|m| followed[m.joint]).collect();
    // The joints that lead, in the order of the moving links.
    let leaders: Vec<usize> = moving.iter().map(|m| m.joint).filter(|&j| followed[j].leader == j).collect();
    let mut links = Vec::with_capacity(moving.len());
    let mut coordinates: Vec<Coordinate> = Vec::with_capacity(leaders.len());
    let mut narrower = Vec::new();
    for ((moving, mut framed), follows) in moving.iter().zip(framed).zip(&follows) {
        let joint = &model.joints[moving.joint];
        let limits = limits(joint, &checked, &mut notes);
        let k = leaders.iter().position(|&j| j == follows.leader).map(CoordinateId);
        if follows.leader == moving.joint {
            coordinates.push(Coordinate { name: joint.name.clone(), limits });
        } else {
            follows.shift(&mut framed.geometry, moving.given.prismatic);
            narrower.extend(k.map(|k| (k, *follows, limits)));
        }
        notes.extend(freed(joint, options.mimic));
        notes.extend(nearly_parallel(joint, &framed));
        links.push(link(&model, &checked, moving, framed, drive(moving, follows, k), &mut notes));
    }
    for (k, follows, limits) in narrower {
        follows.narrow(&mut coordinates[k.0], limits);
    }
    if coordinates.is_empty() && !floating {
        return Err(source.place(checked.at, "no joint of the robot moves by itself"));
    }
    let base = base(&model, &checked, &rooted);
    let mut robot = Robot {
        name: if model.name.trim().is_empty() { "robot".into() } else { model.name },
        source: None,
        symbols: Vec::new(),
        coordinates,
        passive: Vec::new(),
        links,
        base,
        massless: 0,
        loops: Vec::new(),
        gravity: [Value::ZERO, Value::ZERO, Value::Number(-9.81)],
        notes,
        snapped,
    };
    check_frames(source, &checked, &robot, &given, &follows)?;
    if options.angles == Angles::Meant {
        make_one(&mut robot);
    }
    Ok(robot)
}

/// Refuses values of symbols, since a URDF has none.
fn no_values(source: Source, values: &[(String, f64)]) -> Result<(), Error> {
    match values.first() {
        Some((name, _)) => Err(source.whole(no_symbol(name, &[]))),
        None => Ok(()),
    }
}

/// The note on a joint that no longer follows another.
fn freed(joint: &urdf_rs::Joint, mimic: Mimic) -> Option<Note> {
    let text = "mimics another joint in the file; read as a coordinate of its own, as was asked";
    let is_freed = joint.mimic.is_some() && mimic == Mimic::Independent;
    is_freed.then(|| Note { subject: joint.name.clone(), text: text.into() })
}

fn taken_as_parallel(made: &MadeParallel, link: &str, antecedent: &str) -> Note {
    let angle = made.angle;
    let text =
        format!("its axis is {angle:.1e} rad from parallel to that of {antecedent} and is taken as parallel to it");
    Note { subject: link.into(), text }
}

/// The drive of a joint, and its variable as a multiple of the coordinate k.
fn drive(moving: &Moving, follows: &Follows, k: Option<CoordinateId>) -> (Drive, Affine) {
    // A joint that follows a fixed one does not move.
    let terms = k.filter(|_| follows.multiplier != 0.0).map(|k| (k, follows.multiplier));
    let variable = Affine { terms: terms.into_iter().collect(), offset: Value::ZERO };
    let drive = match (follows.leader == moving.joint, variable.terms.is_empty()) {
        (true, _) => Drive::Actuated,
        (false, false) => Drive::Passive,
        (false, true) => Drive::Locked,
    };
    (drive, variable)
}

/// A note on an axis that is almost parallel to the one before it. Their common normal lies far away, and numbers in a
/// frame out there lose digits.
fn nearly_parallel(joint: &urdf_rs::Joint, framed: &Framed) -> Option<Note> {
    let sine = sin_cos(&framed.geometry.alpha, &[]).0.abs();
    let text = format!(
        "its axis is parallel to the one before it but for {sine:.1e} rad, so their common normal lies {:.3} m along \
         the axis; if they are meant to be parallel, say so in the file",
        framed.geometry.b.number(&[]).abs()
    );
    (sine > 0.0 && sine < NEARLY_PARALLEL_RAD).then(|| Note { subject: joint.name.clone(), text })
}

fn link(
    model: &urdf_rs::Robot,
    checked: &Checked,
    moving: &Moving,
    framed: Framed,
    (drive, variable): (Drive, Affine),
    notes: &mut Vec<Note>,
) -> Link {
    let joint = &model.joints[moving.joint];
    let (parts, inertial) = parts(model, checked, moving, &framed.file_frame, notes);
    // The link's own frame goes first, then those of the links that are fixed to it.
    let own = |carried: &(usize, Pose)| model.links[carried.0].name == joint.child.link;
    let mut carried: Vec<&(usize, Pose)> = moving.carried.iter().collect();
    carried.sort_by_key(|&carried| !own(carried));
    let frame = |(k, pose): &(usize, Pose)| (model.links[*k].name.clone(), framed.file_frame.compose(pose));
    let frames = carried.into_iter().map(frame).collect();
    let collisions = shapes(model, checked, &moving.carried, &framed.file_frame);
    // urdf-rs reads what is missing as zero; only what the text has is known.
    let mark = checked.joints.get(&joint.name);
    let given = |has: bool, x: f64| has.then_some(x);
    let (damping, friction) = joint.dynamics.as_ref().map_or((0.0, 0.0), |d| (d.damping, d.friction));
    Link {
        name: joint.child.link.clone(),
        label: joint.name.clone(),
        antecedent: moving.given.antecedent.map(LinkId),
        geometry: framed.geometry,
        joint: Joint {
            name: joint.name.clone(),
            kind: if moving.given.prismatic { JointKind::Prismatic } else { JointKind::Revolute },
            drive,
            variable,
            rotor_inertia: RotorInertia::Absent,
            friction: Friction {
                viscous: given(mark.is_some_and(|m| m.has_damping), damping),
                coulomb: given(mark.is_some_and(|m| m.has_friction), friction),
                offset: None,
            },
            drive_gain: None,
        },
        inertial,
        file_frame: framed.file_frame,
        parts,
        frames,
        collisions,
    }
}

/// The root and what is fixed to it, in the frame of the root.
fn base(model: &urdf_rs::Robot, checked: &Checked, rooted: &[(usize, Pose)]) -> Base {
    let (parts, _) = parts_of(model, checked, rooted, &Pose::IDENTITY);
    Base { inertial: sum(&parts), parts, collisions: shapes(model, checked, rooted, &Pose::IDENTITY) }
}

/// The shapes of some links, in the frame that `file_frame` stands in.
fn shapes(model: &urdf_rs::Robot, checked: &Checked, carried: &[(usize, Pose)], file_frame: &Pose) -> Vec<Collision> {
    let of = |(index, pose): &(usize, Pose)| {
        let place = file_frame.compose(pose);
        let own = checked.collisions.get(&model.links[*index].name).into_iter().flatten();
        own.map(move |shape| Collision { pose: place.compose(&shape.pose), ..shape.clone() }).collect::<Vec<_>>()
    };
    carried.iter().flat_map(of).collect()
}

/// The inertials lumped into a link, and their sum; without any, the sum is unknown.
fn parts(
    model: &urdf_rs::Robot,
    checked: &Checked,
    moving: &Moving,
    file_frame: &Pose,
    notes: &mut Vec<Note>,
) -> (Vec<Part>, Option<[f64; 10]>) {
    let (parts, massless) = parts_of(model, checked, &moving.carried, file_frame);
    let subject = &model.joints[moving.joint].child.link;
    let mut note = |text: String| notes.push(Note { subject: subject.clone(), text });
    if parts.is_empty() {
        note("has no inertial: its standard parameters are unknown".into());
    } else {
        for name in massless {
            note(format!("`{name}` has no inertial and counts as massless"));
        }
    }
    let inertial = sum(&parts);
    (parts, inertial)
}

fn sum(parts: &[Part]) -> Option<[f64; 10]> {
    let mut sum = [0.0; 10];
    for part in parts {
        for (sum, x) in sum.iter_mut().zip(part.parameters()) {
            *sum += x;
        }
    }
    (!parts.is_empty()).then_some(sum)
}

/// The parts among some links, and the names of those links that have a shape but no inertial. The places in `carried`
/// are given in the frame of the file; `file_frame` is that frame in the frame of the link.
fn parts_of<'a>(
    model: &'a urdf_rs::Robot,
    checked: &Checked,
    carried: &[(usize, Pose)],
    file_frame: &Pose,
) -> (Vec<Part>, Vec<&'a str>) {
    let mut parts = Vec::new();
    let mut massless = Vec::new();
    for (index, pose) in carried {
        let link = &model.links[*index];
        let Some(mark) = checked.links.get(&link.name) else { continue };
        // A link without an inertial weighs nothing; where it has a shape, the user is told.
        if !mark.has_inertial {
            if mark.has_shape {
                massless.push(link.name.as_str());
            }
            continue;
        }
        let origin = &link.inertial.origin;
        let inertial_frame =
            Pose { rotation: angle_snap::rotation(&origin.rpy.map(Value::Number)), position: *origin.xyz };
        let i = &link.inertial.inertia;
        parts.push(Part {
            name: link.name.clone(),
            pose: file_frame.compose(pose).compose(&inertial_frame),
            mass: link.inertial.mass.value,
            inertia: [i.ixx, i.ixy, i.ixz, i.iyy, i.iyz, i.izz],
        });
    }
    (parts, massless)
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
    let limit = &joint.limit;
    let magnitude = |x: f64| (x > 0.0 && x.is_finite()).then_some(x);
    // What is not written counts as zero: then nobody meant to hold the joint still.
    let is_written = checked.joints.get(&joint.name).is_some_and(|m| m.has_range);
    let position = (!turns && (is_written || limit.lower < limit.upper)).then_some((limit.lower, limit.upper));
    match position {
        None if !turns => note("has limits that leave no range: taken as unlimited"),
        Some((low, high)) if low == high => note("has the same lower and upper limit: it stands still"),
        Some((low, high)) if low > high => note("has a lower limit above its upper one: no motion keeps both"),
        _ => {}
    }
    Limits {
        position,
        velocity: magnitude(limit.velocity),
        acceleration: magnitude(limit.acceleration),
        effort: magnitude(limit.effort),
    }
}

/// The forward kinematics of the re-framed robot against that of the file.
fn check_frames(
    source: Source,
    checked: &Checked,
    robot: &Robot,
    given: &[Given],
    follows: &[Follows],
) -> Result<(), Error> {
    for q in configurations(robot.n_coordinates(), 4) {
        // Positions of the joints of the file.
        let position = |j: usize| robot.links[j].joint.variable.rate(&q) + follows[j].offset;
        let poses = robot.link_poses(&q);
        let mut file: Vec<Pose> = Vec::with_capacity(given.len());
        for (j, joint) in given.iter().enumerate() {
            let motion = match joint.prismatic {
                true => Pose { position: scaled(joint.axis, position(j)), ..Pose::IDENTITY },
                false => Pose { rotation: rotation_about(joint.axis, position(j)), ..Pose::IDENTITY },
            };
            let ahead = joint.pose.compose(&motion);
            let wanted = joint.antecedent.map_or(ahead, |i| file[i].compose(&ahead));
            let (position, angle) = distance(&poses[j].compose(&robot.links[j].file_frame), &wanted);
            if !(position <= REFRAMING_TOLERANCE && angle <= REFRAMING_TOLERANCE) {
                let name = &robot.links[j].joint.name;
                let message = format!(
                    "joint `{}` cannot be re-framed accurately: its frame comes out {position:.1e} m and {angle:.1e} rad \
                     from the file's; its axis is too nearly parallel to a neighbour's, or its lengths are not in m",
                    shown(name)
                );
                return Err(source.place(checked.joints.get(name).map_or((0, 0), |m| m.at), message));
            }
            file.push(wanted);
        }
    }
    Ok(())
}
