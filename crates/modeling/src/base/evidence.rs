//! The rank of a regressor with its evidence: numeric, and from a finite field, whose arithmetic has no rounding.
//!
//! Each column of the regressor is kept (it gives a base parameter) or dropped (it is a combination of kept columns: a
//! relation). The distance of a column is its distance from the span of the columns kept before it.

use std::fmt;

use crate::base::closed::reason::NoCertificate;
use crate::base::rank::Scan;

/// The rank of a standard regressor (number of base parameters), and the evidence for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank {
    /// Number of base parameters.
    pub numeric: usize,
    /// The rank of the regressor in a finite field, where no tolerance is needed.
    pub exact: ExactRank,
    /// Smallest distance of a kept column from the span of the columns before it, divided by the norm of the kept column.
    pub smallest_kept: f64,
    /// Largest distance of a dropped column from the span of the kept columns, relative to the norm of this column. For a zero
    /// column: the norm of the column, relative to the norm of the largest column.
    pub largest_dropped: f64,
    /// Bound of the torque error |D_base X_base - D X| that one parameter causes because weak columns are not kept. The
    /// relation of a dropped column to the kept columns omits a component of the column. The bound is the largest such
    /// component, divided by the largest column in the torque of the same joint.
    pub left_out: f64,
    /// Number of relations between columns that are proven in the robot's symbols.
    pub exact_relations: usize,
    /// Number of relations between columns that hold at every value of the symbols, but whose coefficients are known only as
    /// numbers.
    pub general_relations: usize,
    /// Number of relations between columns that are only numeric.
    pub numeric_relations: usize,
}

/// The rank of a regressor in a finite field, or the reason why this rank is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExactRank {
    /// The rank of a robot without passive joints, whose coordinates are all free.
    Free(usize),
    /// The rank of a robot with loops, at states that close the loops in the finite field (`base/closed`).
    Closed {
        /// The rank at these closed states.
        rank: usize,
        /// Whether other assemblies of the loops have other independent columns.
        other_assemblies: bool,
    },
    /// The rank is not known. The reason is given.
    Unknown(NoCertificate),
}

impl ExactRank {
    /// The rank in the finite field; `None` if this rank is not known.
    pub fn rank(self) -> Option<usize> {
        match self {
            ExactRank::Free(rank) | ExactRank::Closed { rank, .. } => Some(rank),
            ExactRank::Unknown(_) => None,
        }
    }

    /// The reason why the rank in the finite field is not known; `None` if the rank is known.
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
    /// The rank and distances of a numeric scan of columns. The caller adds the evidence from the finite field.
    pub(crate) fn of(scan: &Scan) -> Rank {
        let smallest_kept = scan.kept.iter().map(|&c| scan.distance[c]).fold(1.0, f64::min);
        let dropped = scan.zero.iter().copied().chain(scan.dependent.iter().map(|d| d.0));
        let largest_dropped = dropped.map(|c| scan.distance[c]).fold(0.0, f64::max);
        Rank {
            numeric: scan.kept.len(),
            // The caller replaces this value.
            exact: ExactRank::Unknown(NoCertificate::OtherForm),
            smallest_kept,
            largest_dropped,
            left_out: 0.0,
            exact_relations: 0,
            general_relations: 0,
            numeric_relations: 0,
        }
    }

    /// The ratio smallest_kept / largest_dropped of distances. It is at least 1e3 for a clear-cut rank, and infinite if every
    /// dropped column has the distance zero.
    pub fn gap(&self) -> f64 {
        self.smallest_kept / self.largest_dropped
    }
}

/// Exact and numeric coefficients of a relation agree up to rounding if their relative difference is at most this value. The
/// weakest kept column amplifies rounding by the inverse of its distance, to 1e-16 / 1e-7 = 1e-9 at worst
/// ([`crate::base::rank::INDEPENDENT`]). A wrong coefficient has a relative difference of about one.
const RULE_ROUNDING: f64 = 1e-6;

/// Whether the difference between an exact and a numeric coefficient of a relation is small enough to be rounding.
pub(crate) fn agree(exact: f64, numeric: f64) -> bool {
    (exact - numeric).abs() <= RULE_ROUNDING * (1.0 + exact.abs())
}
