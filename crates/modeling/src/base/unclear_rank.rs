//! The reasons why a robot has no base parameters, each with its remedy, as a claim (statement with its evidence).
//!
//! Each column of the regressor is kept (it gives a base parameter) or dropped (it is a combination of kept columns). The
//! distance of a column is its distance from the span of the columns kept before it.

use std::fmt;

use claims::{Claim, Outcome, Remedy, Subject, Topic, Trial};

use crate::base::evidence::Rank;
use crate::base::rank::CLEAR_GAP;
use crate::derivation::NeverCloses;

/// The topic of the claim about a refused rank.
const BASE_PARAMETERS: Topic = Topic("base parameters");

/// The reason why there are no base parameters, with the evidence.
#[derive(Clone, Debug)]
pub enum UnclearRank {
    /// The columns of some parameters are neither clearly independent nor clearly dependent.
    Gap {
        /// The numeric rank and its distances.
        rank: Rank,
        /// Names of the columns within the gap between kept and dropped columns, with their relative distances.
        doubtful: Vec<(String, f64)>,
    },
    /// No configuration was found in which the loops of the robot close.
    NeverCloses(NeverCloses),
    /// The torque per unit of some parameters is not finite, because lengths or angles exceed the range of f64.
    NotFinite {
        /// The names of the parameters whose torque is not finite.
        parameters: Vec<String>,
    },
    /// Some columns are numerically independent, although these columns are dependent for every robot of this structure. The
    /// cause is rounding.
    Exact {
        /// Number of numerically independent columns.
        numeric: usize,
        /// Number of columns that are independent in the finite field.
        exact: usize,
        /// Names of the columns that are independent only numerically.
        only_numeric: Vec<String>,
    },
    /// Some columns are dependent with the numbers of this robot, although these columns are independent for almost every robot
    /// of this structure.
    Coincident {
        /// Number of numerically independent columns.
        numeric: usize,
        /// Number of columns that are independent in the finite field.
        exact: usize,
        /// Names of the columns that are independent only in the finite field.
        only_exact: Vec<String>,
    },
    /// The numeric rank equals the rank in the finite field. But with the numbers of this robot, some columns that the field
    /// chooses are almost in the span of the others, or some columns that the field does not choose are too far from the span
    /// of the chosen columns.
    Weak {
        /// The names of the chosen columns that are almost in the span of the others, with their relative distances.
        weak: Vec<(String, f64)>,
        /// Largest relative distance of a column that is not chosen from the span of the chosen columns.
        largest_dropped: f64,
    },
    /// An exact coefficient of a regrouping differs from the numeric coefficient.
    Disagreement {
        /// Name of the parameter that is absorbed.
        dropped: String,
        /// Name of the base parameter that absorbs this parameter.
        kept: String,
        /// The exact coefficient, at the robot's values of its symbols.
        exact: f64,
        /// The coefficient from the numeric scan.
        numeric: f64,
    },
}

/// The remedy if a number is almost, but not exactly, special (such as a right angle, or the equality of two lengths).
const WRITE_WHAT_IS_MEANT: &str =
    "Look for a length or an angle that is almost, but not quite, zero or a right angle, and write what is meant.";

/// The remedy if numbers are special, by chance or on purpose.
const SAY_WHAT_IS_MEANT: &str = "If it is meant, write it so that it holds at every value: equal lengths or angles as one symbol, \
     a length that follows from others as their expression, gravity along an axis exactly so (in YAML, which `convert` \
     makes of other formats). If it is chance, no base parameters describe the robot as built: give the digits that were \
     measured.";

/// The remedy if a length or an angle is too large.
const LOOK_FOR_A_LARGE_ONE: &str = "Look for a length or an angle beyond reason.";

/// The remedy if the loops do not close.
const CHECK_LOOPS: &str = "Check the lengths around each loop, and where the search for its passive joints starts.";

/// Largest number of names that a message lists.
const LISTED_NAMES: usize = 12;

impl UnclearRank {
    /// The refusal of base parameters as a claim, with its evidence. The outcome is "contradicted" if the finite field has
    /// another rank, otherwise "cannot tell".
    pub fn claim(&self) -> Claim {
        let subject = Subject::of(BASE_PARAMETERS, self.doubtful());
        let outcome = match self {
            UnclearRank::Exact { .. } | UnclearRank::Coincident { .. } => Outcome::Contradicted {
                fault: self.fault(),
                remedy: Remedy::new("description", self.remedy()),
                trial: Trial::NotTried { why: "what is meant is the user's to say".into() },
            },
            _ => Outcome::CannotTell { why: self.fault(), would_tell: "a description with other digits".into() },
        };
        Claim::new(subject, outcome)
    }

    /// Names of the parameters that are neither clearly base parameters nor clearly dependent.
    fn doubtful(&self) -> Vec<String> {
        let names = |of: &[(String, f64)]| of.iter().map(|(name, _)| name.clone()).collect();
        match self {
            UnclearRank::Gap { doubtful, .. } => names(doubtful),
            UnclearRank::NeverCloses(_) => Vec::new(),
            UnclearRank::NotFinite { parameters } => parameters.clone(),
            UnclearRank::Exact { only_numeric, .. } => only_numeric.clone(),
            UnclearRank::Coincident { only_exact, .. } => only_exact.clone(),
            UnclearRank::Weak { weak, .. } => names(weak),
            UnclearRank::Disagreement { dropped, kept, .. } => vec![kept.clone(), dropped.clone()],
        }
    }

    /// The reason in words, as a clause.
    fn fault(&self) -> String {
        // Each clause names the parameters in doubt. Only `NeverCloses` concerns no single parameter, so its clause is the text
        // of its error.
        match self {
            UnclearRank::Gap { rank, doubtful } => format!(
                "the rank is not clear-cut: {} columns are independent, the weakest of them by {:.1e}, but a dropped one \
                 stands out by {:.1e} (a factor of {:.0e}; {CLEAR_GAP:.0e} is clear). In doubt: {}",
                rank.numeric,
                rank.smallest_kept,
                rank.largest_dropped,
                rank.gap(),
                with_distances(doubtful)
            ),
            UnclearRank::NeverCloses(e) => e.to_string(),
            UnclearRank::NotFinite { parameters } => {
                format!("the torque per unit of {} is no finite number", listed(parameters))
            }
            UnclearRank::Exact { numeric, exact, only_numeric } => format!(
                "the numeric rank is {numeric}, the exact one {exact}: rounding makes these look independent, which they \
                 are not: {}",
                listed(only_numeric)
            ),
            UnclearRank::Coincident { numeric, exact, only_exact } => format!(
                "the numeric rank is {numeric}, the exact one {exact}: almost every robot of this structure has {} as base \
                 parameters, at these numbers they are not. Two lengths or angles agree, or gravity is along an axis",
                listed(only_exact)
            ),
            UnclearRank::Weak { weak, largest_dropped } => format!(
                "rounding hides whether these stand out of the span of the others: {}; a dropped one stands out by \
                 {largest_dropped:.1e}",
                with_distances(weak)
            ),
            UnclearRank::Disagreement { dropped, kept, exact, numeric } => format!(
                "rounding hides the base parameters: {kept} absorbs {exact} of {dropped} by the exact rule, {numeric} by \
                 the numbers"
            ),
        }
    }

    /// The remedy in words, as a sentence.
    fn remedy(&self) -> &'static str {
        match self {
            UnclearRank::Coincident { .. } => SAY_WHAT_IS_MEANT,
            UnclearRank::NotFinite { .. } => LOOK_FOR_A_LARGE_ONE,
            UnclearRank::NeverCloses(_) => CHECK_LOOPS,
            _ => WRITE_WHAT_IS_MEANT,
        }
    }
}

impl fmt::Display for UnclearRank {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // This error contains its own remedy.
            UnclearRank::NeverCloses(e) => e.fmt(f),
            _ => write!(f, "{}. {}", self.fault(), self.remedy()),
        }
    }
}

impl std::error::Error for UnclearRank {}

impl From<NeverCloses> for UnclearRank {
    fn from(e: NeverCloses) -> UnclearRank {
        UnclearRank::NeverCloses(e)
    }
}

/// The first [`LISTED_NAMES`] names as text, and the number of the other names.
fn listed(names: &[String]) -> String {
    let more = names.len().saturating_sub(LISTED_NAMES);
    let first = names[..names.len() - more].join(" ");
    if more == 0 { first } else { format!("{first} and {more} more") }
}

fn with_distances(columns: &[(String, f64)]) -> String {
    let names: Vec<String> = columns.iter().map(|(name, distance)| format!("{name} ({distance:.1e})")).collect();
    listed(&names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_a_claim_with_its_evidence() {
        let by_chance = UnclearRank::Coincident { numeric: 3, exact: 8, only_exact: vec!["ZZ2".into(), "MX2".into()] };
        let text = by_chance.claim().to_string();
        assert!(text.contains("ZZ2") && text.contains("one symbol") && text.contains("contradicted"), "{text}");
        let many = UnclearRank::NotFinite { parameters: (0..40).map(|k| format!("M{k}")).collect() };
        assert!(many.to_string().contains("and 28 more"), "{many}");
        assert!(many.claim().to_string().contains("cannot tell"), "{}", many.claim());
    }
}
