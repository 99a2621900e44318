//! The model of a robot: its links, joints, coordinates and loops. The readers of all file formats make it.
//!
//! The antecedent of a link is its parent. A loop is cut at one place: the cut and its twin are the two frames at this place.
//! Bodies that are fixed to a link are lumped into it: together they are one link here.

use crate::collision::Collision;
use crate::finding::Finding;
use crate::inertial::{Part, Pose};
use crate::value::{Affine, CoordinateId, Symbol, Value};

/// Index of a link in [`Robot::links`]. It is also the index of the joint that moves this link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub usize);

/// A robot: a tree of links, each placed relative to an earlier link or the base. A loop is closed by a pair of frames
/// at its cut.
#[derive(Clone, Debug, Default)]
pub struct Robot {
    /// Name of the robot in the file; if there is none, the name of the file.
    pub name: String,
    /// Source of the numbers, as stated in the file; `None` if it states none.
    pub source: Option<String>,
    /// Named lengths and angles. The value of a symbol contains only symbols before it.
    pub symbols: Vec<Symbol>,
    /// The generalised coordinates q. All vectors over coordinates have this order.
    pub coordinates: Vec<Coordinate>,
    /// The variables of passive joints that the loops determine and that are no affine functions of the coordinates. With n
    /// coordinates, `CoordinateId(n + p)` is the passive coordinate p: in the vector q of the kinematics, the passive coordinates
    /// follow the coordinates. Empty if every joint variable is affine.
    pub passive: Vec<PassiveCoordinate>,
    /// The links of the robot. The antecedent (parent) of a link comes before the link.
    pub links: Vec<Link>,
    /// The body of the base. It has no effect while the base is at rest. It becomes a link if the base floats.
    pub base: Base,
    /// Number of massless links at the start of `links`. They have no inertial parameters.
    pub massless: usize,
    /// The loops of the robot, each as a pair of frames that coincide. Empty for a tree.
    pub loops: Vec<Loop>,
    /// Acceleration of gravity in the base frame, m/s^2.
    pub gravity: [Value; 3],
    /// Gravity in the file (m/s^2) if the base was rotated after reading; otherwise `None`.
    pub file_gravity: Option<[f64; 3]>,
    /// Notes for the user on assumptions that were made when the file was read.
    pub notes: Vec<Note>,
    /// Notes on angles and axes that were replaced by exact values when the file was read. In these values, the robot differs
    /// from the file in the last digits.
    pub snapped: Vec<Note>,
    /// The visual shapes of links without a collision shape. The pose is in the frame that the file gives the link.
    pub visuals: Vec<Collision>,
    /// Findings on the text of the file. [`crate::lint`] includes them in its findings.
    pub oddities: Vec<Finding>,
    /// The kind of file that the robot was read from, independently of the file name.
    pub format: Format,
}

/// The kind of file that a robot was read from. It says which properties of a robot the file can express.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// YAML or .par: all properties.
    #[default]
    Complete,
    /// URDF, also expanded from a xacro: no rotor inertias.
    Urdf,
    /// MJCF: rotor inertias are possible, but most files omit them.
    Mjcf,
}

/// A generalised coordinate of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Name in the file: `q1`, or the name of a joint in a URDF.
    pub name: String,
    /// Limits of the coordinate in the file.
    pub limits: Limits,
}

/// The variable of a passive joint or of a cut. The closure of the loops determines its value.
#[derive(Clone, Debug, PartialEq)]
pub struct PassiveCoordinate {
    /// Name of the passive joint or the cut.
    pub name: String,
    /// Start value when the loops are closed numerically, rad or m. It selects one of several possible assemblies.
    pub start: f64,
}

/// Limits of a coordinate. `None`: the file gives no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Lowest and highest position of the coordinate, rad or m.
    pub position: Option<(f64, f64)>,
    /// Largest speed of the coordinate, rad/s or m/s.
    pub velocity: Option<f64>,
    /// Largest acceleration of the coordinate, rad/s^2 or m/s^2.
    pub acceleration: Option<f64>,
    /// Largest torque (N m) or largest force of a prismatic joint (N).
    pub effort: Option<f64>,
}

/// A rigid link and the joint that moves it.
#[derive(Clone, Debug)]
pub struct Link {
    /// Name of the link in the file.
    pub name: String,
    /// Suffix of the names of its parameters: the `4` of `XX4`.
    pub label: String,
    /// The link that carries this link; `None`: the fixed base.
    pub antecedent: Option<LinkId>,
    /// Pose of the link frame in the frame of its antecedent. The joint variable is added to theta (revolute joint) or
    /// r (prismatic joint).
    pub geometry: ModifiedDh,
    /// The joint between the antecedent and the link.
    pub joint: Joint,
    /// XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the link frame; `None` if they are unknown.
    pub inertial: Option<[f64; 10]>,
    /// Pose of the file's joint frame (in a URDF: of the child link) in the link frame.
    pub file_frame: Pose,
    /// The rigid bodies that are lumped into this link, in the order of the file.
    pub parts: Vec<Part>,
    /// The frames of the file that are fixed to this link (in a URDF: the links), with name and pose in the link frame. The
    /// frame of the link itself comes first. Empty if the link frame equals the frame of the file.
    pub frames: Vec<(String, Pose)>,
    /// The collision shapes of the link; empty if the file has none.
    pub collisions: Vec<Collision>,
}

impl Link {
    /// A link whose name is its label. Its frame equals the frame in the file; it has no inertial parameters, bodies or shapes.
    pub fn bare(label: String, antecedent: Option<LinkId>, geometry: ModifiedDh, joint: Joint) -> Link {
        Link {
            name: label.clone(),
            label,
            antecedent,
            geometry,
            joint,
            inertial: None,
            file_frame: Pose::IDENTITY,
            parts: Vec::new(),
            frames: Vec::new(),
            collisions: Vec::new(),
        }
    }
}

/// The base of a robot as a rigid body.
#[derive(Clone, Debug, Default)]
pub struct Base {
    /// XX .. M about the origin of the base frame, in its axes; `None` if they are unknown.
    pub inertial: Option<[f64; 10]>,
    /// The rigid bodies that are lumped into the base.
    pub parts: Vec<Part>,
    /// The collision shapes of the base, in the base frame.
    pub collisions: Vec<Collision>,
}

/// The parameters gamma, b, alpha, d, theta, r of Khalil and Kleinfinger: iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta)
/// Tz(r). Angles are in rad and lengths in m. They do not contain coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct ModifiedDh {
    /// Rotation angle about the z axis of the antecedent, rad.
    pub gamma: Value,
    /// Distance along the z axis of the antecedent, m.
    pub b: Value,
    /// Rotation angle about the x axis after the rotation by gamma, rad.
    pub alpha: Value,
    /// Distance along the same x axis, m.
    pub d: Value,
    /// Rotation angle about the z axis of the link, rad. The variable of a revolute joint is added to it.
    pub theta: Value,
    /// Distance along the z axis of the link, m. The variable of a prismatic joint is added to it.
    pub r: Value,
}

impl ModifiedDh {
    /// All parameters zero: the frame equals the frame of the antecedent.
    pub const ZERO: ModifiedDh = ModifiedDh {
        gamma: Value::ZERO,
        b: Value::ZERO,
        alpha: Value::ZERO,
        d: Value::ZERO,
        theta: Value::ZERO,
        r: Value::ZERO,
    };
}

/// The joint that moves a link. Its axis is the z axis of the link frame.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name of the joint in the file.
    pub name: String,
    /// Type of the joint: revolute, prismatic or fixed.
    pub kind: JointKind,
    /// Whether a motor moves the joint, or it is passive or locked.
    pub drive: Drive,
    /// The joint variable as a function of the coordinates, without its constant part. The constant part is in the geometry,
    /// so the offset here is zero.
    pub variable: Affine,
    /// Inertia of the motor as seen from the joint.
    pub rotor_inertia: RotorInertia,
    /// Friction of the joint as given in the file.
    pub friction: Friction,
    /// Torque (force) per unit of measured motor current, N m/A (N/A); `None` if it is unknown.
    pub drive_gain: Option<f64>,
    /// Largest torque, N m (or force, N), of a joint that follows another joint; `None` for all other joints.
    pub follower_effort: Option<f64>,
}

impl Joint {
    /// A joint without a rotor inertia. Its friction, drive gain and largest effort are unknown.
    pub fn bare(name: String, kind: JointKind, drive: Drive, variable: Affine) -> Joint {
        Joint {
            name,
            kind,
            drive,
            variable,
            rotor_inertia: RotorInertia::Absent,
            friction: Friction::default(),
            drive_gain: None,
            follower_effort: None,
        }
    }
}

/// The type of a joint: the motion that it allows about or along the z axis of its link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// The joint rotates about z; its variable is an angle, rad.
    Revolute,
    /// The joint slides along z; its variable is a length, m.
    Prismatic,
    /// The joint does not move.
    Fixed,
}

/// The source of the motion of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// A motor moves the joint.
    Actuated,
    /// No motor moves the joint: its variable follows from the coordinates, or is a passive coordinate.
    Passive,
    /// The joint is locked at a constant position.
    Locked,
}

/// Whether a joint has the rotor inertia IA as a parameter, and the value of IA if it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RotorInertia {
    /// The joint has no rotor inertia as a parameter.
    Absent,
    /// The rotor inertia is a parameter, but its value is unknown.
    Unknown,
    /// The rotor inertia has this value, as seen from the joint, kg m^2 (kg).
    Known(f64),
}

impl RotorInertia {
    /// Whether the rotor inertia IA is a parameter of the joint.
    pub fn is_modelled(self) -> bool {
        self != RotorInertia::Absent
    }
}

/// Friction of a joint as given in the file: tau = viscous dq + coulomb sign(dq) + offset. tau is a torque (a force for a
/// prismatic joint). `None`: the file gives no value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Friction {
    /// Viscous friction coefficient, N m s/rad (N s/m).
    pub viscous: Option<f64>,
    /// Coulomb friction torque, N m (force, N).
    pub coulomb: Option<f64>,
    /// Offset of the friction torque, N m (N).
    pub offset: Option<f64>,
}

/// A closed loop of the robot: two frames, one on each side of the cut, that coincide in every reachable configuration.
#[derive(Clone, Debug)]
pub struct Loop {
    /// The frame at the end of the first branch. Its variable moves it like a joint.
    pub cut: LoopFrame,
    /// The frame at the end of the second branch.
    pub twin: LoopFrame,
}

/// A frame at the cut of a loop. It is placed relative to a link, and `variable` moves it like a joint of type `kind`.
#[derive(Clone, Debug)]
pub struct LoopFrame {
    /// The link that carries the frame; `None`: the fixed base.
    pub antecedent: Option<LinkId>,
    /// Pose of the frame in the frame of that link, at variable zero.
    pub geometry: ModifiedDh,
    /// Type of joint by which the variable moves the frame.
    pub kind: JointKind,
    /// The variable of the frame as a function of the coordinates.
    pub variable: Affine,
}

/// A note for the user on how the file was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Name of the joint, link or key that the note is about.
    pub subject: String,
    /// The note as one sentence; the subject is not included.
    pub text: String,
}

impl Robot {
    /// The link with index j. It panics if the robot has no such link.
    pub fn link(&self, j: LinkId) -> &Link {
        &self.links[j.0]
    }

    /// The indices of all links. The antecedent (parent) of a link comes before the link.
    pub fn link_ids(&self) -> impl DoubleEndedIterator<Item = LinkId> + use<> {
        (0..self.links.len()).map(LinkId)
    }

    /// Number of generalised coordinates: the length of dq, ddq and tau.
    pub fn n_coordinates(&self) -> usize {
        self.coordinates.len()
    }

    /// Number of coordinates plus number of passive coordinates: the length of the vector q of [`Robot::link_poses`].
    pub fn n_variables(&self) -> usize {
        self.coordinates.len() + self.passive.len()
    }

    /// Name of a coordinate or a passive coordinate.
    pub fn coordinate_name(&self, k: CoordinateId) -> &str {
        match k.0.checked_sub(self.coordinates.len()) {
            None => &self.coordinates[k.0].name,
            Some(p) => &self.passive[p].name,
        }
    }

    /// Whether a loop depends on passive coordinates: some link or loop frame in its branches moves with a passive coordinate.
    pub fn is_implicit(&self, one: &Loop) -> bool {
        let n = self.coordinates.len();
        let passive = |terms: &[(CoordinateId, f64)]| terms.iter().any(|(k, _)| k.0 >= n);
        [&one.cut, &one.twin].into_iter().any(|frame| {
            let above = std::iter::successors(frame.antecedent, |&j| self.link(j).antecedent);
            passive(&frame.variable.terms) || above.into_iter().any(|j| passive(&self.link(j).joint.variable.terms))
        })
    }

    /// Acceleration of gravity as numbers (m/s^2) in the base frame.
    pub fn gravity_number(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| self.gravity[i].number(&self.symbols))
    }

    /// The actuated joint whose variable equals coordinate k; `None` if there is no such joint.
    pub fn joint_of(&self, k: CoordinateId) -> Option<LinkId> {
        self.link_ids().find(|&j| {
            let joint = &self.link(j).joint;
            joint.drive == Drive::Actuated && joint.variable.terms == [(k, 1.0)]
        })
    }
}
