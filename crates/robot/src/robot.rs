//! The robot: links, joints, coordinates, loops.

use crate::collision::Collision;
use crate::finding::Finding;
use crate::inertial::{Part, Pose};
use crate::value::{Affine, CoordinateId, Symbol, Value};

/// Index of a link, and of the joint that carries it, in [`Robot::links`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub usize);

/// A robot: a tree of links, each placed from one that stands before it, with loops closed by
/// pairs of cut frames.
#[derive(Clone, Debug, Default)]
pub struct Robot {
    /// Name in the file, or the file's own name.
    pub name: String,
    /// Where the figures come from, in the words of the file.
    pub source: Option<String>,
    /// Named lengths and angles; a value names only symbols before it.
    pub symbols: Vec<Symbol>,
    /// The generalised coordinates q, in the order of every vector.
    pub coordinates: Vec<Coordinate>,
    /// Joint variables that the loops determine and no affine function of the coordinates gives.
    /// `CoordinateId(n + p)` names the p-th of them, n the number of coordinates: they come after
    /// the coordinates in the q of the kinematics. Empty when every joint is affine.
    pub passive: Vec<PassiveCoordinate>,
    /// Antecedents come before what they carry.
    pub links: Vec<Link>,
    /// The body that the links hang on, where the file describes one. It has no effect while it is at rest, and becomes
    /// a link when it floats.
    pub base: Base,
    /// How many of the first links only carry others: they have no inertial parameters.
    pub massless: usize,
    /// Pairs of frames that coincide; empty for a tree.
    pub loops: Vec<Loop>,
    /// Acceleration of gravity in the base frame, m/s^2.
    pub gravity: [Value; 3],
    /// The same as the file has it, where the base was turned since.
    pub file_gravity: Option<[f64; 3]>,
    /// What the reader of the file guessed, to be told to the user.
    pub notes: Vec<Note>,
    /// Notes on the angles and axes that the reader took for others, where the robot differs from its file in the last
    /// digits.
    pub snapped: Vec<Note>,
    /// What is odd in the text that it was read from: [`crate::lint`] tells it with the rest.
    pub oddities: Vec<Finding>,
    /// The format that it was read from, whatever its file is called.
    pub format: Format,
}

/// What a format can say of a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Everything that is known here: YAML and .par.
    #[default]
    Complete,
    /// No rotor inertias: a URDF, whether written as such or as xacro.
    Urdf,
    /// Rotor inertias, which most files leave out: an MJCF.
    Mjcf,
}

/// One generalised coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Name in the file: `q1`, or a URDF's joint.
    pub name: String,
    /// Where the motor may take it.
    pub limits: Limits,
}

/// The variable of a passive joint or of a cut, left to the closure of the loops.
#[derive(Clone, Debug, PartialEq)]
pub struct PassiveCoordinate {
    /// Name of the joint or cut.
    pub name: String,
    /// Where a search for the closed robot begins, rad or m: it chooses among several assemblies.
    pub start: f64,
}

/// Limits of a coordinate; `None` where the file gives none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// rad or m.
    pub position: Option<(f64, f64)>,
    /// rad/s or m/s.
    pub velocity: Option<f64>,
    /// rad/s^2 or m/s^2.
    pub acceleration: Option<f64>,
    /// N m (N).
    pub effort: Option<f64>,
}

/// A rigid link and the joint that moves it.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name in the file.
    pub name: String,
    /// The part of its parameters' names behind the letters: the `4` of `XX4`.
    pub label: String,
    /// `None`: the fixed base.
    pub antecedent: Option<LinkId>,
    /// Placement of the link frame in its antecedent's; the joint variable is added to theta
    /// (revolute) or r (prismatic).
    pub geometry: ModifiedDh,
    /// What moves the link against its antecedent.
    pub joint: Joint,
    /// XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the link frame, where known.
    pub inertial: Option<[f64; 10]>,
    /// Frame of the joint as the file has it (a URDF's child link), in the link frame.
    pub file_frame: Pose,
    /// The rigid parts the file lumps into this link, in the order of the file.
    pub parts: Vec<Part>,
    /// The frames that the file fixes to this link, its own first, by name and with their place in the link frame: the
    /// links of a URDF. Empty where the link frame is the file's.
    pub frames: Vec<(String, Pose)>,
    /// Its collision geometry, where the file describes one.
    pub collisions: Vec<Collision>,
}

impl Link {
    /// A link that is named by its label, in the file's own frame, without inertial parameters, parts and shapes.
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
    /// XX .. M about the origin of the base frame, in it, where known.
    pub inertial: Option<[f64; 10]>,
    /// The rigid parts that the file lumps into it.
    pub parts: Vec<Part>,
    /// Its collision geometry, in the base frame.
    pub collisions: Vec<Collision>,
}

/// gamma, b, alpha, d, theta, r of Khalil-Kleinfinger: iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d)
/// Rz(theta) Tz(r). Angles in rad, lengths in m; free of coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct ModifiedDh {
    /// About z of the antecedent, rad.
    pub gamma: Value,
    /// Along z of the antecedent, m.
    pub b: Value,
    /// About the x so turned, rad.
    pub alpha: Value,
    /// Along that x, m.
    pub d: Value,
    /// About z of the link, rad; the variable of a revolute joint is added.
    pub theta: Value,
    /// Along z of the link, m; the variable of a prismatic joint is added.
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
    /// Whether it turns, slides or does neither.
    pub kind: JointKind,
    /// Who moves it.
    pub drive: Drive,
    /// The joint variable's motion; the constant part of the angle or length is in the geometry,
    /// so the offset here is zero.
    pub variable: Affine,
    /// The motor's inertia, seen from the joint.
    pub rotor_inertia: RotorInertia,
    /// What the file says of its friction.
    pub friction: Friction,
    /// Torque (force) per unit of measured current, N m/A (N/A).
    pub drive_gain: Option<f64>,
    /// What a joint that follows another may bear itself, N m (N).
    pub follower_effort: Option<f64>,
}

impl Joint {
    /// A joint without a rotor, of which no friction, gain or effort is known.
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
    /// Neither.
    Fixed,
}

/// What determines the variable of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// A motor moves it.
    Actuated,
    /// It follows the coordinates, or is a passive coordinate.
    Passive,
    /// Held at a constant value.
    Locked,
}

/// Whether the joint has a rotor inertia among its parameters, and its value where known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RotorInertia {
    /// Not a parameter of this joint.
    Absent,
    /// A parameter of unknown value.
    Unknown,
    /// kg m^2 (kg), seen from the joint.
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
    /// N m s/rad (N s/m).
    pub viscous: Option<f64>,
    /// N m (N).
    pub coulomb: Option<f64>,
    /// N m (N).
    pub offset: Option<f64>,
}

/// Two frames, one on each side of a cut, that coincide in every reachable configuration.
#[derive(Clone, Debug)]
pub struct Loop {
    /// The frame at the end of one branch; its variable moves it as a joint would.
    pub cut: LoopFrame,
    /// The frame on the link that the loop returns to.
    pub twin: LoopFrame,
}

/// A frame placed from a link; `variable` moves it as a joint of its own kind would.
#[derive(Clone, Debug)]
pub struct LoopFrame {
    /// The link that carries it; `None`: the fixed base.
    pub antecedent: Option<LinkId>,
    /// Its placement in the frame of that link.
    pub geometry: ModifiedDh,
    /// How its variable moves it.
    pub kind: JointKind,
    /// The variable as a function of the coordinates.
    pub variable: Affine,
}

/// Something the user should know about how the file was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Joint, link or key concerned.
    pub subject: String,
    /// One sentence, the subject left out.
    pub text: String,
}

impl Robot {
    /// Link j; `j` is one of this robot's.
    pub fn link(&self, j: LinkId) -> &Link {
        &self.links[j.0]
    }

    /// All links, antecedents before what they carry.
    pub fn link_ids(&self) -> impl DoubleEndedIterator<Item = LinkId> + use<> {
        (0..self.links.len()).map(LinkId)
    }

    /// Number of generalised coordinates: the length of dq, ddq and tau.
    pub fn n_coordinates(&self) -> usize {
        self.coordinates.len()
    }

    /// The coordinates and, after them, the passive coordinates: the length of the q that
    /// [`Robot::link_poses`] takes.
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

    /// Whether the loop closes only where its passive coordinates say so: a link or cut frame on
    /// its way moves with one of them.
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

    /// The actuated joint whose variable is this coordinate alone, when there is one.
    pub fn joint_of(&self, k: CoordinateId) -> Option<LinkId> {
        self.link_ids().find(|&j| {
            let joint = &self.link(j).joint;
            joint.drive == Drive::Actuated && joint.variable.terms == [(k, 1.0)]
        })
    }
}
