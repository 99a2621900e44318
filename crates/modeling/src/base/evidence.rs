//! The evidence for a set of base parameters.

use std::fmt;

use crate::base::closed::reason::NoCertificate;
use crate::base::rank::Scan;

/// The evidence for a rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank {
    /// Number of base parameters.
    pub numeric: usize,
    /// The rank in a finite field, without a tolerance.
    pub exact: ExactRank,
    /// Smallest relative distance of a kept column from the span of those before it.
    pub smallest_kept: f64,
    /// Largest relative distance of a dropped one; zero columns count with their norm relative to
    /// the largest column's.
    pub largest_dropped: f64,
    /// The most that relations leave out of a column because others are too weak to be kept, relative to the largest
    /// column in the torque of the same joint: D_base X_base differs from D X by this part of that of an equal parameter.
    pub left_out: f64,
    /// How many relations are proven in the symbols.
    pub exact_relations: usize,
    /// How many relations hold at every value of the symbols, with coefficients that are known as numbers only.
    pub general_relations: usize,
    /// How many relations are only numeric.
    pub numeric_relations: usize,
}

/// What a finite field says of the rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExactRank {
    /// The rank where every coordinate is free.
    Free(usize),
    /// The rank at states that close the loops in the field (`base/closed`).
    Closed {
        /// The rank.
        rank: usize,
        /// Whether the loops have assemblies of another rank than the one of the start.
        other_assemblies: bool,
    },
    /// Nothing, and why.
    Unknown(NoCertificate),
}

impl ExactRank {
    /// The rank, where it is known.
    pub fn rank(self) -> Option<usize> {
        match self {
            ExactRank::Free(rank) | ExactRank::Closed { rank, .. } => Some(rank),
            ExactRank::Unknown(_) => None,
        }
    }

    /// Why it is not known.
    pub fn reason(self) -> Option<NoCertificate> {
        match self {
            ExactRank::Unknown(reason) => Some(reason),
            _ => None,
        }
    }
}

impl fmt::Display for ExactRank {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ExactRank::Free(_) => f.write_str("the same columns are independent in a finite field"),
            ExactRank::Closed { other_assemblies, .. } => {
                f.write_str(
                    "the same columns are independent in a finite field, at states that close the loops there",
                )?;
                if *other_assemblies {
                    f.write_str("; other assemblies of these loops have other base parameters")?;
                }
                Ok(())
            }
            ExactRank::Unknown(reason) => write!(f, "the loops are closed by a search, and {reason}"),
        }
    }
}

impl Rank {
    /// The evidence of the scan alone. The caller adds the exact evidence.
    pub(crate) fn of(scan: &Scan) -> Rank {
        let smallest_kept = scan.kept.iter().map(|&c| scan.distance[c]).fold(1.0, f64::min);
        let dropped = scan.zero.iter().copied().chain(scan.dependent.iter().map(|d| d.0));
        let largest_dropped = dropped.map(|c| scan.distance[c]).fold(0.0, f64::max);
        Rank {
            numeric: scan.kept.len(),
            // Replaced by whoever knows.
            exact: ExactRank::Unknown(NoCertificate::OtherForm),
            smallest_kept,
            largest_dropped,
            left_out: 0.0,
            exact_relations: 0,
            general_relations: 0,
            numeric_relations: 0,
        }
    }

    /// smallest_kept / largest_dropped, at least 1e3 for a clear-cut rank; infinite when nothing
    /// dropped leaves any distance.
    pub fn gap(&self) -> f64 {
        self.smallest_kept / self.largest_dropped
    }
}

/// Relative difference of an exact coefficient and a numeric one that rounding explains. The weakest kept column
/// amplifies rounding by the inverse of its distance, to 1e-16 / 1e-7 = 1e-9 at worst
/// ([`crate::base::rank::INDEPENDENT`]). A wrong coefficient differs by its own size.
const RULE_ROUNDING: f64 = 1e-6;

/// Whether rounding explains how an exact coefficient and a numeric one differ.
pub(crate) fn agree(exact: f64, numeric: f64) -> bool {
    (exact - numeric).abs() <= RULE_ROUNDING * (1.0 + exact.abs())
}
