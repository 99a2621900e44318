//! The evidence for a set of base parameters, and the refusal where it does not suffice.
//!
//! A rank is believed if three conditions hold. The numbers leave a wide gap between what they keep and
//! what they drop. They keep no more columns than are independent in a finite field. The exact
//! coefficients of the regrouping agree with the numeric ones.

use std::fmt;

use crate::base::rank::{CLEAR_GAP, Scan};
use crate::base::regrouping::Shares;
use crate::derivation::NeverCloses;

/// Relative difference of an exact coefficient and a numeric one that rounding explains. The weakest kept column
/// amplifies rounding by the inverse of its distance, to 1e-16 / 1e-7 = 1e-9 at worst
/// ([`crate::base::rank::INDEPENDENT`]). A wrong coefficient differs by its own size.
const ROUNDING: f64 = 1e-6;

/// The evidence for a rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank {
    /// Number of base parameters.
    pub numeric: usize,
    /// The rank in a finite field, without a tolerance; `None` where loops are closed numerically,
    /// since their passive coordinates are no free elements of a field.
    pub exact: Option<usize>,
    /// Smallest relative distance of a kept column from the span of those before it.
    pub smallest_kept: f64,
    /// Largest relative distance of a dropped one; zero columns count with their norm relative to
    /// the largest column's.
    pub largest_dropped: f64,
    /// How many relations are proven in the symbols.
    pub exact_relations: usize,
    /// How many relations are only numeric.
    pub numeric_relations: usize,
}

impl Rank {
    /// The evidence of the scan alone. The caller adds the exact evidence.
    pub(crate) fn of(scan: &Scan) -> Rank {
        let smallest_kept = scan.kept.iter().map(|&c| scan.distance[c]).fold(1.0, f64::min);
        let dropped = scan.zero.iter().copied().chain(scan.dependent.iter().map(|d| d.0));
        let largest_dropped = dropped.map(|c| scan.distance[c]).fold(0.0, f64::max);
        Rank {
            numeric: scan.kept.len(),
            exact: None,
            smallest_kept,
            largest_dropped,
            exact_relations: 0,
            numeric_relations: 0,
        }
    }

    /// smallest_kept / largest_dropped, at least 1e3 for a clear-cut rank; infinite when nothing
    /// dropped leaves any distance.
    pub fn gap(&self) -> f64 {
        self.smallest_kept / self.largest_dropped
    }
}

/// Why no base parameters are given: the evidence, for the caller to show.
#[derive(Clone, Debug)]
pub enum UnclearRank {
    /// Some columns are neither clearly independent nor clearly dependent.
    Gap {
        /// The rank by the numbers alone.
        rank: Rank,
        /// Columns within the gap, with their relative distances.
        doubtful: Vec<(String, f64)>,
    },
    /// The loops were never found closed.
    NeverCloses(NeverCloses),
    /// Columns that the numbers keep although they are dependent for every robot of this structure.
    Exact {
        /// Columns that the numbers keep.
        numeric: usize,
        /// Columns that are independent in the field.
        exact: usize,
        /// Names of those that only the numbers keep.
        only_numeric: Vec<String>,
    },
    /// The exact coefficient and the numeric one of a regrouping differ.
    Disagreement {
        /// The parameter that is absorbed.
        dropped: String,
        /// The base parameter that absorbs it.
        kept: String,
        /// The exact coefficient at the robot's values.
        exact: f64,
        /// The coefficient by the numbers.
        numeric: f64,
    },
}

/// What to do about any of them.
const REMEDY: &str =
    "Look for a length or an angle that is almost, but not quite, zero or a right angle, and write what is meant.";

impl fmt::Display for UnclearRank {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UnclearRank::Gap { rank, doubtful } => {
                write!(
                    f,
                    "the rank is not clear-cut: {} columns are independent, the weakest of them by {:.1e}, but a \
                     dropped one stands out by {:.1e} (a factor of {:.0e}; {:.0e} is clear). In doubt:",
                    rank.numeric,
                    rank.smallest_kept,
                    rank.largest_dropped,
                    rank.gap(),
                    CLEAR_GAP
                )?;
                for (name, distance) in doubtful {
                    write!(f, " {name} ({distance:.1e})")?;
                }
                write!(f, ". {REMEDY}")
            }
            UnclearRank::NeverCloses(e) => e.fmt(f),
            UnclearRank::Exact { numeric, exact, only_numeric } => write!(
                f,
                "the numeric rank is {numeric}, the exact one {exact}: rounding makes these look independent, which \
                 they are not: {}. {REMEDY}",
                only_numeric.join(" ")
            ),
            UnclearRank::Disagreement { dropped, kept, exact, numeric } => write!(
                f,
                "rounding hides the base parameters: {kept} absorbs {exact} of {dropped} by the exact rule, {numeric} by \
                 the numbers. {REMEDY}"
            ),
        }
    }
}

impl std::error::Error for UnclearRank {}

impl From<NeverCloses> for UnclearRank {
    fn from(e: NeverCloses) -> UnclearRank {
        UnclearRank::NeverCloses(e)
    }
}

/// Refuses a rank without a clear gap, with the columns that are in doubt.
pub(crate) fn clear_cut(scan: &Scan, rank: &Rank, name: impl Fn(usize) -> String) -> Result<(), UnclearRank> {
    if rank.gap() < CLEAR_GAP {
        let in_doubt = |&c: &usize| {
            let d = scan.distance[c];
            d >= rank.largest_dropped && d <= rank.smallest_kept
        };
        let doubtful = (0..scan.distance.len()).filter(in_doubt).map(|c| (name(c), scan.distance[c])).collect();
        return Err(UnclearRank::Gap { rank: *rank, doubtful });
    }
    Ok(())
}

/// Refuses more columns than are independent in the field, because rounding alone makes the surplus independent.
pub(crate) fn no_more_than_exact(
    scan: &Scan,
    exact: &[usize],
    name: impl Fn(usize) -> String,
) -> Result<(), UnclearRank> {
    if scan.kept.len() > exact.len() {
        let only_numeric = scan.kept.iter().filter(|c| !exact.contains(c)).map(|&c| name(c)).collect();
        return Err(UnclearRank::Exact { numeric: scan.kept.len(), exact: exact.len(), only_numeric });
    }
    Ok(())
}

/// Refuses exact coefficients that differ from the numeric ones by more than the accuracy of the latter.
pub(crate) fn held_against_numbers(
    scan: &Scan,
    shares: &Shares,
    name: impl Fn(usize) -> String,
) -> Result<(), UnclearRank> {
    let nothing = vec![0.0; scan.kept.len()];
    let rows = scan.dependent.iter().map(|(c, x)| (*c, x)).chain(scan.zero.iter().map(|&c| (c, &nothing)));
    for (dropped, x) in rows {
        for (place, &kept) in scan.kept.iter().enumerate() {
            let share = shares[&dropped].iter().find(|(k, _)| *k == kept);
            let exact = share.map_or(0.0, |(_, share)| share.number);
            if (exact - x[place]).abs() > ROUNDING * (1.0 + exact.abs()) {
                let (dropped, kept) = (name(dropped), name(kept));
                return Err(UnclearRank::Disagreement { dropped, kept, exact, numeric: x[place] });
            }
        }
    }
    Ok(())
}
