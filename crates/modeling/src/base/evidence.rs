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
    /// Smallest relative distance of a kept column from the span of the columns before it.
    pub smallest_kept: f64,
    /// Largest relative distance of a dropped column. The distance of a zero column is its norm relative to the norm of the
    /// largest column.
    pub largest_dropped: f64,
    /// Largest component that a relation omits because columns are too weak to be kept, relative to the largest column in
    /// the torque of the same joint: the bound of |D_base X_base - D X| for one parameter, relative to the torque of an equal
    /// parameter with the largest column.
    pub left_out: f64,
    /// How many relations are proven in the symbols.
    pub exact_relations: usize,
    /// How many relations hold at every value of the symbols, with coefficients that are known as numbers only.
    pub general_relations: usize,
    /// How many relations are only numeric.
    pub numeric_relations: usize,
}

/// The rank in a finite field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExactRank {
    /// The rank where every coordinate is free.
    Free(usize),
    /// The rank at states that close the loops in the field (`base/closed`).
    Closed {
        /// The rank.
        rank: usize,
        /// Whether the loops have other assemblies, with another rank than the assembly of the start.
        other_assemblies: bool,
    },
    /// The rank is not known, for this reason.
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

    /// Why the rank is not known; `None` where it is known.
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
            // Replaced by the caller.
            exact: ExactRank::Unknown(NoCertificate::OtherForm),
            smallest_kept,
            largest_dropped,
            left_out: 0.0,
            exact_relations: 0,
            general_relations: 0,
            numeric_relations: 0,
        }
    }

    /// smallest_kept / largest_dropped, at least 1e3 for a clear-cut rank; infinite when every dropped column has the
    /// distance zero.
    pub fn gap(&self) -> f64 {
        self.smallest_kept / self.largest_dropped
    }
}

/// Relative difference of an exact coefficient and a numeric one that rounding explains. The weakest kept column
/// amplifies rounding by the inverse of its distance, to 1e-16 / 1e-7 = 1e-9 at worst
/// ([`crate::base::rank::INDEPENDENT`]). A wrong coefficient has a relative difference of about one.
const RULE_ROUNDING: f64 = 1e-6;

/// Whether rounding explains the difference of an exact coefficient and a numeric one.
pub(crate) fn agree(exact: f64, numeric: f64) -> bool {
    (exact - numeric).abs() <= RULE_ROUNDING * (1.0 + exact.abs())
}
