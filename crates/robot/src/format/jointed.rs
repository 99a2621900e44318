//! Converts a robot with arbitrary joint axes and origins to Khalil-Kleinfinger frames.
//!
//! The readers of URDF and MJCF list the joints, each with the bodies that it carries. An antecedent (parent) precedes its
//! successors. Every moving link gets a frame with z along its joint axis ([`super::reframe`]). [`Link::file_frame`] and
//! [`Link::parts`] store the relation to the frames of the file. Finally the result is checked: every joint frame must have the
//! pose that follows from the file.

use super::follows::Follows;
use super::loop_frames::{FileLoop, loops};
use super::node::DescriptionFile;
use super::reframe::{Framed, JointPlacement, MadeParallel, NEARLY_PARALLEL_RAD, frames, make_parallel};
use super::shown::shown;
use crate::agreement::make_one;
use crate::angle_snap::AngleSnapping;
use crate::closure::{self, configurations, distance};
use crate::collision::Collision;
use crate::error::Error;
use crate::inertial::{Part, Pose};
use crate::kinematics::sin_cos;
use crate::passive;
use crate::robot::{
    Base, Coordinate, Drive, Format, Friction, Joint, JointKind, Limits, Link, LinkId, Note, PassiveCoordinate, Robot,
    RotorInertia,
};
use crate::value::{Affine, CoordinateId, Value};
use crate::vector::{rotation_about, scaled};

/// The joint frame of the file and the frame computed from the result must agree. This is the tolerance of their distance (m)
/// and of their angle (rad).
const REFRAMING_TOLERANCE: f64 = 1e-9;

/// A joint of the file and the link that it moves, with the values of the file.
#[derive(Clone, Debug)]
pub(in crate::format) struct FileJoint {
    /// Index of the joint among all joints of the file, including fixed joints.
    pub id: usize,
    pub name: String,
    /// Line and column in the file.
    pub at: (usize, usize),
    pub given: JointPlacement,
    /// The joint that this joint follows, as a [`FileJoint::id`]; its own id if it follows no other joint.
    pub follows: Follows,
    /// Whether the joint has no motor and is moved only through a loop.
    pub is_passive: bool,
    pub limits: Limits,
    pub friction: Friction,
    pub rotor_inertia: RotorInertia,
    pub link: String,
    /// The bodies that the joint carries: its link and the bodies fixed to it, in the order of the file.
    pub carried: Vec<LumpedBody>,
    /// If the link has no inertial in the file: whether its mass counts as zero (true) or as unknown (false).
    pub is_massless: bool,
}

/// A body of the file that a joint carries: the link of the joint, or a body that is fixed to this link.
#[derive(Clone, Debug)]
pub(in crate::format) struct LumpedBody {
    pub name: String,
    /// Pose of the body's frame in the frame of the joint.
    pub pose: Pose,
    /// Inertial of the body, in the frame of the body; `None` if the file has none.
    pub part: Option<Part>,
    /// Collision shapes of the body, in the frame of the body.
    pub collisions: Vec<Collision>,
}

/// The data of a file except its joints.
pub(in crate::format) struct FileContext {
    pub name: String,
    pub base: Base,
    pub gravity: [Value; 3],
    pub loops: Vec<FileLoop>,
    pub notes: Vec<Note>,
    pub snapped: Vec<Note>,
}

/// Makes a robot of `joints`, in which an antecedent (parent) precedes its successors.
///
/// Fails if a frame cannot be converted accurately.
pub(in crate::format) fn robot(
    source: DescriptionFile,
    mut joints: Vec<FileJoint>,
    rest: FileContext,
    angles: AngleSnapping,
) -> Result<Robot, Error> {
    let FileContext { name, base, gravity, loops: file_loops, mut notes, mut snapped } = rest;
    let made = make_parallel(joints.iter_mut().map(|joint| &mut joint.given), angles);
    let called = |k: usize| &joints[k].name;
    snapped.extend(made.iter().map(|made| taken_as_parallel(made, called(made.link), called(made.antecedent))));
    let given: Vec<JointPlacement> = joints.iter().map(|joint| joint.given.clone()).collect();
    let follows: Vec<Follows> = joints.iter().map(|joint| joint.follows).collect();
    let places: Vec<(usize, usize)> = joints.iter().map(|joint| joint.at).collect();
    let framed = frames(&given);
    // A joint gets a coordinate if it follows no other joint and is not passive. Passive coordinates are numbered after these
    // coordinates.
    let leads = |joint: &&FileJoint| joint.follows.leader == joint.id && !joint.is_passive;
    let leaders: Vec<usize> = joints.iter().filter(leads).map(|joint| joint.id).collect();
    let mut coordinates: Vec<Coordinate> = Vec::with_capacity(leaders.len());
    let mut passive: Vec<PassiveCoordinate> = Vec::new();
    let mut narrower = Vec::new();
    let mut links = Vec::with_capacity(joints.len());
    for (joint, mut framed) in joints.into_iter().zip(framed) {
        joint.follows.shift(&mut framed.geometry, joint.given.prismatic);
        let mut k = leaders.iter().position(|&leader| leader == joint.follows.leader).map(CoordinateId);
        if joint.is_passive {
            k = Some(CoordinateId(leaders.len() + passive.len()));
            passive.push(PassiveCoordinate { name: joint.name.clone(), start: -joint.follows.offset });
        } else if joint.follows.leader == joint.id {
            coordinates.push(Coordinate { name: joint.name.clone(), limits: joint.limits });
        } else {
            narrower.extend(k.map(|k| (k, joint.follows, joint.limits)));
        }
        notes.extend(nearly_parallel(&joint.name, &framed));
        links.push(link(joint, framed, k));
    }
    // A follower may precede its leader in the file. So the limits are narrowed when all coordinates exist.
    for (k, follows, limits) in narrower {
        follows.narrow(&mut coordinates[k.0], limits);
    }
    let loops = loops(&file_loops, &links, leaders.len(), &mut passive);
    let mut robot = Robot {
        name,
        coordinates,
        passive,
        links,
        base,
        loops,
        gravity,
        notes,
        snapped,
        format: Format::Mjcf,
        ..Robot::default()
    };
    // The check is first, because `make_one` may change angles and lengths by more than the tolerance of the check.
    check_frames(source, &robot, &given, &follows, &places)?;
    if angles == AngleSnapping::Meant {
        make_one(&mut robot);
    }
    passive::resolve(&mut robot).map_err(|message| source.whole(message))?;
    closure::check(&robot).map_err(|(_, message)| source.whole(message))?;
    Ok(robot)
}

/// The base of the robot, made of the bodies that are fixed to it.
pub(in crate::format) fn base(rooted: &[LumpedBody]) -> Base {
    let parts = parts(rooted, &Pose::IDENTITY);
    Base { inertial: sum(&parts), parts, collisions: collisions(rooted, &Pose::IDENTITY) }
}

/// The inertials of the bodies that a joint carries. `frame`: pose of the joint's frame in the link frame.
fn parts(carried: &[LumpedBody], frame: &Pose) -> Vec<Part> {
    let placed = |one: &LumpedBody| {
        let part = one.part.clone()?;
        Some(Part { pose: frame.compose(&one.pose).compose(&part.pose), ..part })
    };
    carried.iter().filter_map(placed).collect()
}

fn collisions(carried: &[LumpedBody], frame: &Pose) -> Vec<Collision> {
    let of = |one: &LumpedBody| {
        let place = frame.compose(&one.pose);
        let placed = |shape: &Collision| Collision { pose: place.compose(&shape.pose), ..shape.clone() };
        one.collisions.iter().map(placed).collect::<Vec<_>>()
    };
    carried.iter().flat_map(of).collect()
}

/// The sum of inertials: XX .. M in their common frame. `None` (unknown) if there are none.
pub(in crate::format) fn sum(parts: &[Part]) -> Option<[f64; 10]> {
    let mut sum = [0.0; 10];
    for part in parts {
        for (sum, x) in sum.iter_mut().zip(part.parameters()) {
            *sum += x;
        }
    }
    (!parts.is_empty()).then_some(sum)
}

fn link(joint: FileJoint, framed: Framed, k: Option<CoordinateId>) -> Link {
    let frame = framed.file_frame;
    let (drive, variable) = drive(&joint, k);
    let parts = parts(&joint.carried, &frame);
    // The frames of the file, with the frame of the link itself first, then the frames of the bodies fixed to it.
    let mut named: Vec<&LumpedBody> = joint.carried.iter().collect();
    named.sort_by_key(|one| one.name != joint.link);
    Link {
        label: joint.name.clone(),
        antecedent: joint.given.antecedent.map(LinkId),
        geometry: framed.geometry,
        joint: Joint {
            name: joint.name,
            kind: if joint.given.prismatic { JointKind::Prismatic } else { JointKind::Revolute },
            drive,
            variable,
            rotor_inertia: joint.rotor_inertia,
            friction: joint.friction,
            drive_gain: None,
            follower_effort: joint.limits.effort.filter(|_| drive == Drive::Passive && !joint.is_passive),
        },
        inertial: sum(&parts).or(joint.is_massless.then_some([0.0; 10])),
        file_frame: frame,
        parts,
        frames: named.into_iter().map(|one| (one.name.clone(), frame.compose(&one.pose))).collect(),
        collisions: collisions(&joint.carried, &frame),
        name: joint.link,
    }
}

/// The drive type of a joint (actuated, passive, locked), and its variable as a multiple of coordinate k.
fn drive(joint: &FileJoint, k: Option<CoordinateId>) -> (Drive, Affine) {
    // A joint that follows a fixed joint, or has the multiplier zero, has no coordinate: it does not move.
    let terms = k.filter(|_| joint.follows.multiplier != 0.0).map(|k| (k, joint.follows.multiplier));
    let variable = Affine { terms: terms.into_iter().collect(), offset: Value::ZERO };
    let drive = match (joint.follows.leader == joint.id, variable.terms.is_empty()) {
        (true, _) if joint.is_passive => Drive::Passive,
        (true, _) => Drive::Actuated,
        (false, false) => Drive::Passive,
        (false, true) => Drive::Locked,
    };
    (drive, variable)
}

fn taken_as_parallel(made: &MadeParallel, link: &str, antecedent: &str) -> Note {
    let angle = made.angle;
    let text =
        format!("its axis is {angle:.1e} rad from parallel to that of {antecedent} and is taken as parallel to it");
    Note { subject: link.into(), text }
}

/// A note that two consecutive joint axes are almost parallel. Then their common normal is far away from the joint, and
/// coordinates in a frame at this distance lose digits.
fn nearly_parallel(joint: &str, framed: &Framed) -> Option<Note> {
    let sine = sin_cos(&framed.geometry.alpha, &[]).0.abs();
    let text = format!(
        "its axis is parallel to the one before it but for {sine:.1e} rad, so their common normal lies {:.3} m along \
         the axis; if they are meant to be parallel, say so in the file",
        framed.geometry.b.number(&[]).abs()
    );
    (sine > 0.0 && sine < NEARLY_PARALLEL_RAD).then(|| Note { subject: joint.into(), text })
}

/// Checks the converted robot: its forward kinematics must equal the forward kinematics of the file.
fn check_frames(
    source: DescriptionFile,
    robot: &Robot,
    given: &[JointPlacement],
    follows: &[Follows],
    places: &[(usize, usize)],
) -> Result<(), Error> {
    for q in configurations(robot.n_variables(), 4) {
        // Position of joint j as the file defines it.
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
                let message = format!(
                    "joint `{}` cannot be re-framed accurately: its frame comes out {position:.1e} m and {angle:.1e} rad \
                     from the file's; its axis is too nearly parallel to a neighbour's, or its lengths are not in m",
                    shown(&robot.links[j].joint.name)
                );
                return Err(source.place(places[j], message));
            }
            file.push(wanted);
        }
    }
    Ok(())
}
