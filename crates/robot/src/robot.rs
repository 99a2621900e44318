//! The robot: links, joints, coordinates, loops.

use crate::collision::Collision;
use crate::finding::Finding;
use crate::inertial::{Part, Pose};
use crate::value::{Affine, CoordinateId, Symbol, Value};

/// Index of a link, and of the joint that carries it, in [`Robot::links`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub usize);

/// A robot: a tree of links, each placed relative to a link before it, with loops closed by
/// pairs of cut frames.
#[derive(Clone, Debug, Default)]
pub struct Robot {
    /// Name in the file, or the file's own name.
    pub name: String,
    /// The source of the values, as given in the file.
    pub source: Option<String>,
    /// Named lengths and angles; a value contains only symbols before it.
    pub symbols: Vec<Symbol>,
    /// The generalised coordinates q, in the order of every vector.
    pub coordinates: Vec<Coordinate>,
    /// Joint variables that the loops determine and no affine function of the coordinates gives.
    /// `CoordinateId(n + p)` names the p-th of them, n the number of coordinates: they come after
    /// the coordinates in the q of the kinematics. Empty when every joint is affine.
    pub passive: Vec<PassiveCoordinate>,
    /// The links; antecedents come before the links that they carry.
    pub links: Vec<Link>,
    /// The body of the base, where the file has one. It has no effect while it is at rest, and becomes a link when it
    /// floats.
    pub base: Base,
    /// The number of massless links at the start of `links`: they have no inertial parameters.
    pub massless: usize,
    /// Pairs of frames that coincide; empty for a tree.
    pub loops: Vec<Loop>,
    /// Acceleration of gravity in the base frame, m/s^2.
    pub gravity: [Value; 3],
    /// Gravity in the file, m/s^2, where the base was rotated afterwards.
    pub file_gravity: Option<[f64; 3]>,
    /// Assumptions of the reader of the file, for the user.
    pub notes: Vec<Note>,
    /// Notes on angles and axes that the reader replaced, where the robot differs from its file in the last digits.
    pub snapped: Vec<Note>,
    /// Findings about the text of the file, which [`crate::lint`] includes in its findings.
    pub oddities: Vec<Finding>,
    /// The format that it was read from, independently of the file name.
    pub format: Format,
}

/// The properties of a robot that a format can express.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// All properties: YAML and .par.
    #[default]
    Complete,
    /// No rotor inertias: a URDF, also from a xacro.
    Urdf,
    /// Rotor inertias, which most files omit: an MJCF.
    Mjcf,
}

/// One generalised coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Name in the file: `q1`, or a URDF's joint.
    pub name: String,
    /// Its limits.
    pub limits: Limits,
}

/// The variable of a passive joint or of a cut, which the closure of the loops determines.
#[derive(Clone, Debug, PartialEq)]
pub struct PassiveCoordinate {
    /// Name of the joint or cut.
    pub name: String,
    /// The start of the search for the closed robot, rad or m: it selects one of several assemblies.
    pub start: f64,
}

/// Limits of a coordinate; `None` where the file gives none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Lowest and highest position, rad or m.
    pub position: Option<(f64, f64)>,
    /// Largest velocity, rad/s or m/s.
    pub velocity: Option<f64>,
    /// Largest acceleration, rad/s^2 or m/s^2.
    pub acceleration: Option<f64>,
    /// Largest effort, N m (N).
    pub effort: Option<f64>,
}

/// A rigid link and the joint that moves it.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name in the file.
    pub name: String,
    /// The suffix of the names of its parameters: the `4` of `XX4`.
    pub label: String,
    /// The link that carries it; `None`: the fixed base.
    pub antecedent: Option<LinkId>,
    /// Placement of the link frame in the frame of its antecedent; the joint variable is added to theta
    /// (revolute) or r (prismatic).
    pub geometry: ModifiedDh,
    /// The joint between the antecedent and the link.
    pub joint: Joint,
    /// XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the link frame, where known.
    pub inertial: Option<[f64; 10]>,
    /// The pose of the file's joint frame (a URDF's child link) in the link frame.
    pub file_frame: Pose,
    /// The rigid parts that are lumped into this link, in the order of the file.
    pub parts: Vec<Part>,
    /// The frames of the file that are fixed to this link, its own first, by name and with their poses in the link frame:
    /// the links of a URDF. Empty where the link frame is the file's frame.
    pub frames: Vec<(String, Pose)>,
    /// Its collision geometry, where the file has one.
    pub collisions: Vec<Collision>,
}

impl Link {
    /// A link with its label as name, in the file's own frame, without inertial parameters, parts and shapes.
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

/// The base of a robot as a body.
#[derive(Clone, Debug, Default)]
pub struct Base {
    /// XX .. M about the origin of the base frame, in the base frame, where known.
    pub inertial: Option<[f64; 10]>,
    /// The rigid parts that are lumped into it.
    pub parts: Vec<Part>,
    /// Its collision geometry, in the base frame.
    pub collisions: Vec<Collision>,
}

/// gamma, b, alpha, d, theta, r of Khalil-Kleinfinger: iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d)
/// Rz(theta) Tz(r). Angles in rad, lengths in m; free of coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct ModifiedDh {
    /// Angle about z of the antecedent, rad.
    pub gamma: Value,
    /// Distance along z of the antecedent, m.
    pub b: Value,
    /// Angle about the x axis after the rotation by gamma, rad.
    pub alpha: Value,
    /// Distance along this x axis, m.
    pub d: Value,
    /// Angle about z of the link, rad; the variable of a revolute joint is added.
    pub theta: Value,
    /// Distance along z of the link, m; the variable of a prismatic joint is added.
    pub r: Value,
}

impl ModifiedDh {
    /// The frame of the antecedent itself.
    pub const ZERO: ModifiedDh = ModifiedDh {
        gamma: Value::ZERO,
        b: Value::ZERO,
        alpha: Value::ZERO,
        d: Value::ZERO,
        theta: Value::ZERO,
        r: Value::ZERO,
    };
}

/// The joint that carries a link; its axis is z of the link frame.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name in the file.
    pub name: String,
    /// Revolute, prismatic or fixed.
    pub kind: JointKind,
    /// The source of its motion.
    pub drive: Drive,
    /// The joint variable; the constant part of the angle or length is in the geometry,
    /// so the offset here is zero.
    pub variable: Affine,
    /// The motor's inertia, seen from the joint.
    pub rotor_inertia: RotorInertia,
    /// The friction in the file.
    pub friction: Friction,
    /// Torque (force) per unit of measured current, N m/A (N/A).
    pub drive_gain: Option<f64>,
    /// Largest effort of a joint that follows another joint, N m (N).
    pub follower_effort: Option<f64>,
}

impl Joint {
    /// A joint without a rotor, with unknown friction, gain and effort.
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

/// The motion a joint allows, about or along z of its link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns; the variable is an angle, rad.
    Revolute,
    /// Slides; the variable is a length, m.
    Prismatic,
    /// Does not move.
    Fixed,
}

/// What determines the variable of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// A motor moves it.
    Actuated,
    /// It follows the coordinates, or is a passive coordinate.
    Passive,
    /// Locked at a constant value.
    Locked,
}

/// Whether the joint has a rotor inertia among its parameters, and its value where known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RotorInertia {
    /// Not a parameter of this joint.
    Absent,
    /// A parameter of unknown value.
    Unknown,
    /// A parameter with this value, kg m^2 (kg), seen from the joint.
    Known(f64),
}

impl RotorInertia {
    /// Whether IA is among the parameters of the joint.
    pub fn is_modelled(self) -> bool {
        self != RotorInertia::Absent
    }
}

/// Friction of a joint, where the file gives it: tau = viscous dq + coulomb sign(dq) + offset, a torque
/// of a revolute joint (a force of a prismatic one).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Friction {
    /// Viscous coefficient, N m s/rad (N s/m).
    pub viscous: Option<f64>,
    /// Coulomb friction, N m (N).
    pub coulomb: Option<f64>,
    /// Offset, N m (N).
    pub offset: Option<f64>,
}

/// Two frames, one on each side of a cut, that coincide in every reachable configuration.
#[derive(Clone, Debug)]
pub struct Loop {
    /// The frame at the end of one branch; its variable moves it like a joint.
    pub cut: LoopFrame,
    /// The frame on the link at the end of the other branch.
    pub twin: LoopFrame,
}

/// A frame placed relative to a link; `variable` moves it like a joint of this kind.
#[derive(Clone, Debug)]
pub struct LoopFrame {
    /// The link that carries it; `None`: the fixed base.
    pub antecedent: Option<LinkId>,
    /// Its placement in the frame of that link.
    pub geometry: ModifiedDh,
    /// The kind of joint of its variable.
    pub kind: JointKind,
    /// The variable as a function of the coordinates.
    pub variable: Affine,
}

/// Information for the user on how the file was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Joint, link or key concerned.
    pub subject: String,
    /// One sentence without the subject.
    pub text: String,
}

impl Robot {
    /// Link j; `j` must be a link of this robot.
    pub fn link(&self, j: LinkId) -> &Link {
        &self.links[j.0]
    }

    /// All links, antecedents before the links that they carry.
    pub fn link_ids(&self) -> impl DoubleEndedIterator<Item = LinkId> + use<> {
        (0..self.links.len()).map(LinkId)
    }

    /// Number of generalised coordinates: the length of dq, ddq and tau.
    pub fn n_coordinates(&self) -> usize {
        self.coordinates.len()
    }

    /// Number of coordinates and passive coordinates: the length of the q of
    /// [`Robot::link_poses`].
    pub fn n_variables(&self) -> usize {
        self.coordinates.len() + self.passive.len()
    }

    /// Name of a coordinate or of a passive coordinate.
    pub fn coordinate_name(&self, k: CoordinateId) -> &str {
        match k.0.checked_sub(self.coordinates.len()) {
            None => &self.coordinates[k.0].name,
            Some(p) => &self.passive[p].name,
        }
    }

    /// Whether the loop depends on passive coordinates: a link or loop frame in one of its branches moves with one.
    pub fn is_implicit(&self, one: &Loop) -> bool {
        let n = self.coordinates.len();
        let passive = |terms: &[(CoordinateId, f64)]| terms.iter().any(|(k, _)| k.0 >= n);
        [&one.cut, &one.twin].into_iter().any(|frame| {
            let above = std::iter::successors(frame.antecedent, |&j| self.link(j).antecedent);
            passive(&frame.variable.terms) || above.into_iter().any(|j| passive(&self.link(j).joint.variable.terms))
        })
    }

    /// Gravity in f64, m/s^2, in the base frame.
    pub fn gravity_number(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| self.gravity[i].number(&self.symbols))
    }

    /// The actuated joint whose variable is this coordinate alone; `None` where there is none.
    pub fn joint_of(&self, k: CoordinateId) -> Option<LinkId> {
        self.link_ids().find(|&j| {
            let joint = &self.link(j).joint;
            joint.drive == Drive::Actuated && joint.variable.terms == [(k, 1.0)]
        })
    }
}
