//! Requirements that a proof does not cover: assumptions with their source, and unchecked requirements with the reason.

use serde::{Deserialize, Serialize};

/// The topic of a requirement that is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftOutTopic {
    /// A limit that neither the description nor the user gives.
    Limit,
    /// Torques.
    Effort,
    /// Powers.
    Power,
    /// The distance of two links of the robot.
    Distance,
    /// The floor.
    Floor,
    /// A wall, or the side of a box.
    Region,
    /// The path to the first pose, and from the last pose.
    Approach,
    /// Errors of the robot for which the proof has no margin.
    Margin,
}

/// The reason why a requirement is left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftOutReason {
    /// It is assumed to hold.
    Assumed {
        /// The assumption, as a clause.
        what: String,
        /// Its source: `the user`, `default`.
        by: String,
    },
    /// It was not checked.
    NotLookedAt {
        /// The reason, as a clause.
        why: String,
        /// Data that would allow the check, as a noun.
        would_tell: String,
    },
}

/// A requirement that no proof covers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// Its topic.
    pub matter: LeftOutTopic,
    /// Pairs of links, links or coordinates by name; empty: all of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub of: Vec<String>,
    /// The reason.
    pub why: LeftOutReason,
    /// Whether the user asked for it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_asked: bool,
}

impl LeftOut {
    /// A requirement that is assumed to hold.
    pub fn assumed(matter: LeftOutTopic, of: Vec<String>, what: impl Into<String>, by: impl Into<String>) -> LeftOut {
        LeftOut { matter, of, why: LeftOutReason::Assumed { what: what.into(), by: by.into() }, is_asked: false }
    }

    /// A requirement that was not checked.
    pub fn not_looked_at(
        matter: LeftOutTopic,
        of: Vec<String>,
        why: impl Into<String>,
        would_tell: impl Into<String>,
    ) -> LeftOut {
        let why = LeftOutReason::NotLookedAt { why: why.into(), would_tell: would_tell.into() };
        LeftOut { matter, of, why, is_asked: false }
    }

    /// The path to the first pose and from the last pose, which is no part of a motion.
    pub fn approach() -> LeftOut {
        LeftOut::not_looked_at(
            LeftOutTopic::Approach,
            vec![],
            "the motion begins and ends at poses of its own",
            "a path from where the robot stands",
        )
    }

    /// Whether the user asked for it and it was not checked.
    pub fn is_owed(&self) -> bool {
        self.is_asked && matches!(self.why, LeftOutReason::NotLookedAt { .. })
    }
}
