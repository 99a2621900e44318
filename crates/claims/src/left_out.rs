//! What a proof does not cover: what is assumed, by whom, and what nobody looked at, and why.

use serde::{Deserialize, Serialize};

/// What it would have been about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Matter {
    /// A limit that neither description nor user gives.
    Limit,
    /// Torques.
    Effort,
    /// Powers.
    Power,
    /// Two links of the robot.
    Distance,
    /// The floor.
    Floor,
    /// A wall, or the side of a box.
    Region,
    /// The way to the first pose, and from the last.
    Approach,
    /// Errors of the robot that the proof would have room for.
    Margin,
}

/// Why something is left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// It is taken for kept.
    Assumed {
        /// What is taken for true, as a clause.
        what: String,
        /// Who said so: `the user`, `default`.
        by: String,
    },
    /// Nobody looked.
    NotLookedAt {
        /// A clause.
        why: String,
        /// A noun.
        would_tell: String,
    },
}

/// Something that no proof is about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// What it would have been about.
    pub matter: Matter,
    /// Pairs of links, links or coordinates by name; none: all of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub of: Vec<String>,
    /// The reason.
    pub why: Why,
    /// Whether the user asked for it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_asked: bool,
}

impl LeftOut {
    /// Something that is taken for kept.
    pub fn assumed(matter: Matter, of: Vec<String>, what: impl Into<String>, by: impl Into<String>) -> LeftOut {
        LeftOut { matter, of, why: Why::Assumed { what: what.into(), by: by.into() }, is_asked: false }
    }

    /// Something at which nobody looked.
    pub fn not_looked_at(
        matter: Matter,
        of: Vec<String>,
        why: impl Into<String>,
        would_tell: impl Into<String>,
    ) -> LeftOut {
        let why = Why::NotLookedAt { why: why.into(), would_tell: would_tell.into() };
        LeftOut { matter, of, why, is_asked: false }
    }

    /// The way to the first pose and from the last, which is no part of a motion.
    pub fn approach() -> LeftOut {
        LeftOut::not_looked_at(
            Matter::Approach,
            vec![],
            "the motion begins and ends at poses of its own",
            "a path from where the robot stands",
        )
    }

    /// Whether the user asked for it and nobody looked.
    pub fn is_owed(&self) -> bool {
        self.is_asked && matches!(self.why, Why::NotLookedAt { .. })
    }
}
