//! The interface for packages that read other formats of descriptions: they list joints and bodies in the frames of the file,
//! and get a robot in Khalil-Kleinfinger frames.

use std::sync::OnceLock;

use super::expression::no_symbol;
use super::follows::{Follows, resolved};
use super::jointed::{self, FileContext, FileJoint, LumpedBody};
use super::node::DescriptionFile;
use super::options::{Mimic, ReadOptions};
use super::reframe::JointPlacement;
use super::shown::shown;
use crate::angle_snap::{self, AngleSnapping};
use crate::error::Error;
use crate::inertial::{Part, Pose};
use crate::robot::{Friction, Limits, Note, Robot, RotorInertia};
use crate::value::Value;
use crate::vector::{Vector3, norm};

/// A format of descriptions that another package reads.
#[derive(Clone, Copy)]
pub struct DescriptionReader {
    /// File extension of the format in lower case, which is also the tag of its first element.
    pub extension: &'static str,
    /// The function that reads a text; or the error text, if the reader was not built in.
    pub read: Result<ReadDescription, &'static str>,
}

/// Reads a robot from a text. The second argument is the name of the file in errors.
pub type ReadDescription = fn(&str, &str, ReadOptions) -> Result<Robot, Error>;

static READERS: OnceLock<Vec<DescriptionReader>> = OnceLock::new();

/// Registers readers of other formats. Only the first call has an effect.
pub fn register(readers: Vec<DescriptionReader>) {
    READERS.get_or_init(|| readers);
}

/// The reader for an extension or a first element; `None` if none is registered.
pub(super) fn reader(name: &str) -> Option<DescriptionReader> {
    READERS.get()?.iter().copied().find(|reader| reader.extension == name)
}

/// A joint of a file, and the bodies that it carries.
#[derive(Clone, Debug)]
pub struct DescriptionJoint {
    /// Name of the joint, which becomes the name of its coordinate.
    pub name: String,
    /// Line and column in the file; 0 if unknown.
    pub at: (usize, usize),
    /// Index of the joint that carries this joint. It is smaller than the index of this joint; `None` for the base.
    pub antecedent: Option<usize>,
    /// Pose of the joint frame at position 0 in the joint frame of the antecedent, m.
    pub pose: Pose,
    /// Direction of the axis in the joint frame, of any length above 0.
    pub axis: Vector3,
    /// Whether the joint slides along its axis; otherwise it turns about it.
    pub prismatic: bool,
    /// The joint that this joint follows: its index, a factor, and an offset, rad or m.
    pub follows: Option<(usize, f64, f64)>,
    /// Limits of position, velocity and effort.
    pub limits: Limits,
    /// Friction of the joint.
    pub friction: Friction,
    /// Name of the link that the joint moves.
    pub link: String,
    /// The link of the joint, and the links fixed to it.
    pub bodies: Vec<DescriptionBody>,
}

/// A link of a file that is fixed to the link of a joint, or to the base.
#[derive(Clone, Debug)]
pub struct DescriptionBody {
    /// Name of the link.
    pub name: String,
    /// Pose of the link frame in the frame of the joint, or of the base, m.
    pub pose: Pose,
    /// The inertial of the body, in the frame of the link; `None` if the file has none.
    pub part: Option<Part>,
}

/// A robot as a file describes it.
#[derive(Clone, Debug, Default)]
pub struct RobotDescription {
    /// Name of the robot.
    pub name: String,
    /// The joints that move, antecedents first.
    pub joints: Vec<DescriptionJoint>,
    /// The links that are fixed to the base, in the frame of the base.
    pub base: Vec<DescriptionBody>,
    /// Gravity in the frame of the base, m/s^2.
    pub gravity: Vector3,
    /// Notes on what was not read.
    pub notes: Vec<Note>,
    /// Notes on angles that were replaced by exact values.
    pub snapped: Vec<Note>,
}

impl RobotDescription {
    /// The pose of a frame from its position (m) and roll, pitch and yaw (rad). Rounded angles are replaced as the options say;
    /// for each replaced angle, a note on `subject` is added.
    pub fn pose(&mut self, subject: &str, position: Vector3, rpy: Vector3, angles: AngleSnapping) -> Pose {
        let taken = rpy.map(|angle| angle_snap::given_angle(angle, angles));
        for ((name, given), taken) in ["roll", "pitch", "yaw"].into_iter().zip(rpy).zip(&taken) {
            self.snapped.extend(angle_snap::note_of(subject, name, given, taken));
        }
        Pose { rotation: angle_snap::rotation(&taken), position }
    }

    /// The robot. `file`: name of the file in errors.
    ///
    /// Fails if symbols have values, if an axis is zero, if no joint moves by itself, or if frames cannot be converted
    /// accurately.
    pub fn robot(self, file: &str, options: ReadOptions) -> Result<Robot, Error> {
        let source = DescriptionFile { file };
        if let Some((name, _)) = options.values.first() {
            return Err(source.whole(no_symbol(name, &[])));
        }
        // A mimic joint follows its leader only with the option `Mimic::Constraint`. Otherwise it is a coordinate of its own.
        let follows = |joint: &DescriptionJoint| {
            let (leader, multiplier, offset) = joint.follows.filter(|_| options.mimic == Mimic::Constraint)?;
            Some(Follows { leader, multiplier, offset })
        };
        let next: Vec<Option<Follows>> = self.joints.iter().map(follows).collect();
        let names: Vec<String> = self.joints.iter().map(|joint| joint.name.clone()).collect();
        let follows =
            resolved(&next, |k| names[k].as_str()).map_err(|(k, message)| source.place(self.joints[k].at, message))?;
        let moves = follows.iter().enumerate().any(|(k, follows)| follows.leader == k);
        if !moves && !options.floating_base {
            return Err(source.whole("no joint of the robot moves by itself; its base may float: [floating_base=true]"));
        }
        let mut joints = Vec::with_capacity(self.joints.len());
        for (k, joint) in self.joints.into_iter().enumerate() {
            let axis = Some(joint.axis).filter(|axis| norm(*axis) > 0.0);
            let axis = axis.and_then(|axis| angle_snap::unit_axis(axis, options.angles)).ok_or_else(|| {
                let name = shown(&joint.name);
                source.place(joint.at, format!("the axis of joint `{name}` is zero: it needs a direction"))
            })?;
            joints.push(FileJoint {
                id: k,
                name: joint.name,
                at: joint.at,
                given: JointPlacement {
                    antecedent: joint.antecedent,
                    pose: placed(&joint.pose, options.angles),
                    axis,
                    prismatic: joint.prismatic,
                },
                follows: follows[k],
                is_passive: false,
                limits: joint.limits,
                friction: joint.friction,
                rotor_inertia: RotorInertia::Absent,
                link: joint.link,
                carried: joint.bodies.into_iter().map(lumped).collect(),
                is_massless: false,
            });
        }
        let rooted: Vec<LumpedBody> = self.base.into_iter().map(lumped).collect();
        let rest = FileContext {
            name: if self.name.trim().is_empty() { "robot".into() } else { self.name },
            base: jointed::base(&rooted),
            gravity: self.gravity.map(Value::Number),
            loops: Vec::new(),
            notes: self.notes,
            snapped: self.snapped,
        };
        jointed::robot(source, joints, rest, options.angles)
    }
}

/// A pose that was computed from poses of the file, without its rounding errors.
fn placed(pose: &Pose, angles: AngleSnapping) -> Pose {
    let length = |x: f64| angle_snap::given_length(angle_snap::computed_length(x).number(&[]), angles);
    Pose { rotation: angle_snap::exact(&pose.rotation), position: pose.position.map(length) }
}

fn lumped(body: DescriptionBody) -> LumpedBody {
    LumpedBody { name: body.name, pose: body.pose, part: body.part, collisions: Vec::new() }
}
