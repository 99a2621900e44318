//! What the gaps of a robot do not cover, and why.

/// What a gap would have been about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Matter {
    /// Two links of the robot.
    Distance,
    /// The floor.
    Floor,
    /// A wall, or the side of a box.
    Region,
}

/// Why something is left out.
#[derive(Clone, Debug, PartialEq)]
pub enum Why {
    /// It is taken for kept.
    Assumed {
        /// What is taken for true, as a clause.
        what: String,
        /// `the user`, or `default`.
        by: &'static str,
    },
    /// Nobody looked.
    NotLookedAt {
        /// A clause.
        why: String,
        /// A noun.
        would_tell: String,
    },
}

/// Something that no gap covers.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Which kind of gap.
    pub matter: Matter,
    /// Pairs of links or links; none: all of them.
    pub of: Vec<String>,
    /// The reason.
    pub why: Why,
}

impl LeftOut {
    /// Something that is taken for kept.
    pub fn assumed(matter: Matter, of: Vec<String>, what: impl Into<String>, by: &'static str) -> LeftOut {
        LeftOut { matter, of, why: Why::Assumed { what: what.into(), by } }
    }

    /// Something at which nobody looked.
    pub fn not_looked_at(
        matter: Matter,
        of: Vec<String>,
        why: impl Into<String>,
        would_tell: impl Into<String>,
    ) -> LeftOut {
        LeftOut { matter, of, why: Why::NotLookedAt { why: why.into(), would_tell: would_tell.into() } }
    }
}
