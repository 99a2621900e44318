//! Requirements that a proof does not cover. Each requirement is either assumed to hold, with the source of the assumption, or
//! unchecked, with the reason.

use serde::{Deserialize, Serialize};

/// The topic of a requirement that a proof does not cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftOutTopic {
    /// A limit that neither the description nor the user gives.
    Limit,
    /// Torques of the joints.
    Effort,
    /// Powers of the joints.
    Power,
    /// The distance between two links of the robot.
    Distance,
    /// The distance of links from the floor.
    Floor,
    /// The distance of links from a wall or a side of a box.
    Region,
    /// The paths of the robot to the first pose and from the last pose of a motion.
    Approach,
    /// Errors of the robot for which the proof has no margin.
    Margin,
}

/// The reason why the proof does not cover a requirement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftOutReason {
    /// The requirement is assumed to hold.
    Assumed {
        /// The assumption, as a clause.
        what: String,
        /// The source of the assumption: `the user`, `default`.
        by: String,
    },
    /// The requirement was not checked.
    NotLookedAt {
        /// The reason, as a clause.
        why: String,
        /// Data that would allow the check, as a noun: `a path from where the robot stands`.
        would_tell: String,
    },
}

/// A requirement that the proof does not cover, with its reason.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// The topic of the requirement.
    pub matter: LeftOutTopic,
    /// Names of the coordinates, links or pairs of links that the requirement concerns. If the list is empty, the requirement
    /// concerns all coordinates, links or pairs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub of: Vec<String>,
    /// The reason why the requirement is not covered.
    pub why: LeftOutReason,
    /// Whether the user requested the check of this requirement.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_asked: bool,
}

impl LeftOut {
    /// Makes a requirement that is assumed to hold. `what`: the assumption as a clause; `by`: the source of the assumption.
    pub fn assumed(matter: LeftOutTopic, of: Vec<String>, what: impl Into<String>, by: impl Into<String>) -> LeftOut {
        LeftOut { matter, of, why: LeftOutReason::Assumed { what: what.into(), by: by.into() }, is_asked: false }
    }

    /// Makes a requirement that was not checked. `why`: the reason as a clause; `would_tell`: data that would allow the check.
    pub fn not_looked_at(
        matter: LeftOutTopic,
        of: Vec<String>,
        why: impl Into<String>,
        would_tell: impl Into<String>,
    ) -> LeftOut {
        let why = LeftOutReason::NotLookedAt { why: why.into(), would_tell: would_tell.into() };
        LeftOut { matter, of, why, is_asked: false }
    }

    /// Makes the unchecked requirement of the paths to the first pose and from the last pose. These paths are not part of the
    /// proven motion.
    pub fn approach() -> LeftOut {
        LeftOut::not_looked_at(
            LeftOutTopic::Approach,
            vec![],
            "the motion begins and ends at poses of its own",
            "a path from where the robot stands",
        )
    }

    /// Whether the user requested the check of this requirement, but the check was not done.
    pub fn is_owed(&self) -> bool {
        self.is_asked && matches!(self.why, LeftOutReason::NotLookedAt { .. })
    }
}
