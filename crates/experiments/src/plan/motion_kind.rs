//! The kinds of experiments in a plan, named by the torques that they excite.
//!
//! [Vandanjon, Gautier, Desbats 1995, section 3.2]; the table of motions is in
//! [`crate::plan::exciting_trajectory`].

/// The kind of an experiment, named by the torques that it excites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// The fast joint moves alone, at its greatest acceleration: excites its inertia.
    Inertial,
    /// The fast joint moves at its greatest velocity, with one slow joint: excites centrifugal torques.
    Centrifugal,
    /// The fast joint moves at its greatest acceleration, with one slow joint: excites the inertia that couples them.
    Coupling,
    /// The fast joint moves at intermediate velocity and acceleration, with all joints after it in the chain: Centrifugal and
    /// Coupling in one motion.
    Mixed,
    /// The fast joint moves alone, slowly there and back: excites gravity torques.
    Gravity,
}

impl MotionKind {
    /// All kinds of experiments, in the order of the paper.
    pub const ALL: [MotionKind; 5] =
        [MotionKind::Inertial, MotionKind::Centrifugal, MotionKind::Coupling, MotionKind::Mixed, MotionKind::Gravity];

    /// The name of the kind in files.
    pub fn word(self) -> &'static str {
        match self {
            MotionKind::Inertial => "inertial",
            MotionKind::Centrifugal => "centrifugal",
            MotionKind::Coupling => "coupling",
            MotionKind::Mixed => "mixed",
            MotionKind::Gravity => "gravity",
        }
    }

    /// The kind with this name; `None` if there is no such kind.
    pub(crate) fn from_word(word: &str) -> Option<MotionKind> {
        MotionKind::ALL.into_iter().find(|k| k.word() == word)
    }
}
