//! The torques that an experiment excites.
//!
//! [Vandanjon, Gautier, Desbats 1995, section 3.2]; the table of motions is in
//! [`crate::plan::exciting_trajectory`].

/// The purpose of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// The fast joint alone, at its greatest acceleration: its inertia.
    Inertial,
    /// The fast joint at its greatest velocity, and a slow one: centrifugal torques.
    Centrifugal,
    /// The fast joint at its greatest acceleration, and a slow one: inertia between them.
    Coupling,
    /// Between Centrifugal and Coupling, with all joints behind the fast one.
    Mixed,
    /// The fast joint alone, slowly there and back: gravity.
    Gravity,
}

impl MotionKind {
    /// All kinds, in the order of the paper.
    pub const ALL: [MotionKind; 5] =
        [MotionKind::Inertial, MotionKind::Centrifugal, MotionKind::Coupling, MotionKind::Mixed, MotionKind::Gravity];

    /// The name of the kind in the artefacts.
    pub fn word(self) -> &'static str {
        match self {
            MotionKind::Inertial => "inertial",
            MotionKind::Centrifugal => "centrifugal",
            MotionKind::Coupling => "coupling",
            MotionKind::Mixed => "mixed",
            MotionKind::Gravity => "gravity",
        }
    }

    /// The kind with this name.
    pub(crate) fn from_word(word: &str) -> Option<MotionKind> {
        MotionKind::ALL.into_iter().find(|k| k.word() == word)
    }
}
