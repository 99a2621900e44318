//! Findings of `rist lint`: suspicious values of a robot description, the kinds of mistakes that they indicate, and their
//! repairs.

use std::fmt;

use crate::inertial::Pose;

/// One fact that is true of one or several links or joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Names of the links, of the bodies that are fixed to them, or of the joints.
    pub subjects: Vec<String>,
    /// The probable kind of mistake.
    pub mistake: Mistake,
    /// The fact, which is true of every subject.
    pub fact: String,
    /// The numbers of the first subject; may be empty.
    pub evidence: String,
    /// The only repair that makes every subject plausible; otherwise plausible values to be used in their place. `None` if there
    /// are none.
    pub repair: Option<Repair>,
}

/// A change of values that was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Repair {
    /// The change as a clause.
    pub text: String,
    /// The bodies after the change. Empty if the numbers of the file do not determine all new values.
    pub bodies: Vec<RepairedBody>,
}

/// The inertial parameters of a body after a repair.
#[derive(Clone, Debug, PartialEq)]
pub struct RepairedBody {
    /// Name of the body in the file (in a URDF: the link).
    pub name: String,
    /// Mass, kg.
    pub mass: f64,
    /// Pose of the inertial frame in the frame that the file gives the body.
    pub pose: Pose,
    /// Whether the pose differs from the pose in the file.
    pub is_moved: bool,
    /// Inertia about the centre of mass, in the axes of the inertial frame, kg m^2: xx xy xz yy yz zz.
    pub inertia: [f64; 6],
}

/// How much a finding says against a description, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// No robot can have the values, or the whole file is useless for dynamics.
    Error,
    /// The values are possible, but probably not intended.
    Warning,
    /// The values may be right, but the user should know them.
    Note,
}

/// Number of subjects that a sentence lists.
const LISTED_SUBJECTS: usize = 12;

impl Finding {
    /// A finding on one subject, without a repair.
    pub fn new(subject: &str, mistake: Mistake, fact: impl Into<String>, evidence: impl Into<String>) -> Finding {
        let (fact, evidence) = (fact.into(), evidence.into());
        Finding { subjects: vec![subject.into()], mistake, fact, evidence, repair: None }
    }

    /// The sentence on all subjects: the fact, the numbers of the first subject, and the repair.
    pub fn text(&self) -> String {
        let evidence = match &self.subjects[..] {
            _ if self.evidence.is_empty() => String::new(),
            [first, _, ..] => format!(" ({first}: {})", self.evidence),
            _ => format!(": {}", self.evidence),
        };
        let repair = match (&self.repair, self.mistake) {
            (Some(repair), _) => format!("; {}", repair.text),
            (None, Mistake::Impossible | Mistake::Size) => "; the values alone do not determine the cause".into(),
            (None, Mistake::MassWithoutInertia) => {
                "; export the moments with more digits: small ones are rounded to 0".into()
            }
            _ => String::new(),
        };
        format!("{}{evidence}{repair}", self.fact)
    }

    /// How much the finding says against the description.
    pub fn severity(&self) -> Severity {
        self.mistake.severity()
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let listed = self.subjects.iter().take(LISTED_SUBJECTS).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = match self.subjects.len().saturating_sub(LISTED_SUBJECTS) {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        let note = if self.severity() == Severity::Note { "note: " } else { "" };
        write!(f, "{note}{listed}{more}: {}", self.text())
    }
}

/// The usual mistakes in robot descriptions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mistake {
    /// The mass is negative.
    NegativeMass,
    /// The inertia is not zero, but the mass is zero.
    InertiaWithoutMass,
    /// A principal moment of inertia is negative, or larger than the sum of the two others.
    Impossible,
    /// The inertial frame is rotated (rpy), so a program that ignores rpy reads a different inertia.
    TurnedInertialFrame,
    /// The values seem to be in g or mm instead of kg or m.
    Units,
    /// No body of the robot has a mass.
    NoMassAtAll,
    /// The link has a shape or ends a branch, but has no mass.
    NoMass,
    /// The base has no mass.
    MasslessBase,
    /// The radius of gyration does not fit the shapes of the body, or the size of the robot.
    Size,
    /// The mass does not fit the masses of the other bodies.
    MassBesideOthers,
    /// The total mass of all bodies differs from the mass in the data sheet.
    TotalMass,
    /// The left body and the right body are not mirror images.
    NotMirrored,
    /// In some posture, the torque against gravity is larger than the effort limit.
    Effort,
    /// Gravity causes no torque about this joint in any posture.
    NoGravity,
    /// The file gives an entry of the symmetric inertia matrix twice, with two values.
    NotSymmetric,
    /// The link has a mass, but no inertia.
    MassWithoutInertia,
    /// The value is a default that an exporter writes if the true value is unknown.
    Placeholder,
    /// Most links have the same inertial parameters, so they are probably copies.
    Copied,
    /// The mass does not fit the volume of the collision shapes.
    Density,
    /// The centre of mass lies far outside the collision shapes.
    CentreOutside,
    /// The joint limits have no effect, are zero, or are in degrees.
    Limits,
    /// Angles exceed a full turn, so they are probably in degrees.
    Degrees,
    /// Other programs interpret the text of the file differently, or refuse it.
    OtherReaders,
}

impl Mistake {
    /// How much a mistake of this kind says against a description.
    pub fn severity(self) -> Severity {
        use Mistake::*;
        match self {
            NegativeMass | InertiaWithoutMass | Impossible | MassWithoutInertia | NoMassAtAll | NotSymmetric => {
                Severity::Error
            }
            TurnedInertialFrame | MasslessBase | NoGravity => Severity::Note,
            _ => Severity::Warning,
        }
    }
}
