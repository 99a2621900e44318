//! The evidence for a set of base parameters, and the refusal where it does not suffice.
//!
//! Base parameters are believed if these conditions hold; where one does not, nobody gets any:
//!
//! - every number is finite;
//! - the numbers leave a wide gap between what is kept and what is dropped;
//! - the rank is that in a finite field ([`crate::base::exact_rank`]), and the columns are those of the field, which may be
//!   others than the numbers alone would keep; each must stand out of the span of the others;
//! - the exact coefficients of the regrouping agree with the numeric ones.

use std::cmp::Ordering;
use std::fmt;

use crate::base::closed::reason::NoCertificate;
use crate::base::rank::{CLEAR_GAP, Scan};
use crate::base::regrouping::{Shares, agree};
use crate::derivation::NeverCloses;

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
    /// The rank at states that close the loops in the field ([`crate::base::closed`]).
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
    /// The torque of some parameters is no finite number: lengths or angles are beyond what f64 holds.
    NotFinite {
        /// Their names.
        parameters: Vec<String>,
    },
    /// Columns that the numbers keep although they are dependent for every robot of this structure.
    Exact {
        /// Columns that the numbers keep.
        numeric: usize,
        /// Columns that are independent in the field.
        exact: usize,
        /// Names of those that only the numbers keep.
        only_numeric: Vec<String>,
    },
    /// Columns that are dependent at these numbers alone: for almost every robot of this structure they are not.
    Coincident {
        /// Columns that the numbers keep.
        numeric: usize,
        /// Columns that are independent in the field.
        exact: usize,
        /// Names of those that only the field keeps.
        only_exact: Vec<String>,
    },
    /// Some columns that the field chooses hardly stand out of the span of the others at these numbers, or others do that it
    /// does not choose, although there are as many as the numbers keep.
    Weak {
        /// Their names, with their relative distances.
        weak: Vec<(String, f64)>,
        /// Largest relative distance of a column that is not chosen.
        largest_dropped: f64,
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

/// What to do about numbers that are almost special.
const REMEDY: &str =
    "Look for a length or an angle that is almost, but not quite, zero or a right angle, and write what is meant.";

/// What to do about numbers that are special by chance or on purpose.
const SAY_WHAT_IS_MEANT: &str = "If it is meant, write it so that it holds at every value: equal lengths or angles as one symbol, \
     a length that follows from others as their expression, gravity along an axis exactly so (in YAML, which `convert` \
     makes of other formats). If it is chance, no base parameters describe the robot as built: give the digits that were \
     measured.";

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
                listed(only_numeric)
            ),
            UnclearRank::NotFinite { parameters } => write!(
                f,
                "the torque per unit of {} is no finite number: look for a length or an angle beyond reason",
                listed(parameters)
            ),
            UnclearRank::Coincident { numeric, exact, only_exact } => write!(
                f,
                "the numeric rank is {numeric}, the exact one {exact}: almost every robot of this structure has {} as base \
                 parameters, at these numbers they are not. Two lengths or angles agree, or gravity is along an axis. \
                 {SAY_WHAT_IS_MEANT}",
                listed(only_exact)
            ),
            UnclearRank::Weak { weak, largest_dropped } => {
                write!(f, "rounding hides whether these stand out of the span of the others:")?;
                for (name, distance) in weak.iter().take(LISTED) {
                    write!(f, " {name} ({distance:.1e})")?;
                }
                write!(f, "; a dropped one stands out by {largest_dropped:.1e}. {REMEDY}")
            }
            UnclearRank::Disagreement { dropped, kept, exact, numeric } => write!(
                f,
                "rounding hides the base parameters: {kept} absorbs {exact} of {dropped} by the exact rule, {numeric} by \
                 the numbers. {REMEDY}"
            ),
        }
    }
}

impl std::error::Error for UnclearRank {}

/// How many names a message lists.
const LISTED: usize = 12;

fn listed(names: &[String]) -> String {
    let more = names.len().saturating_sub(LISTED);
    let first = names[..names.len() - more].join(" ");
    if more == 0 { first } else { format!("{first} and {more} more") }
}

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

/// Refuses a rank that the field does not have.
pub(crate) fn of_one_rank(scan: &Scan, exact: &[usize], name: impl Fn(usize) -> String) -> Result<(), UnclearRank> {
    let (numeric, only) = (&scan.kept, |these: &[usize], others: &[usize]| {
        these.iter().filter(|c| others.binary_search(c).is_err()).map(|&c| name(c)).collect()
    });
    match numeric.len().cmp(&exact.len()) {
        Ordering::Equal => Ok(()),
        Ordering::Greater => {
            Err(UnclearRank::Exact { numeric: numeric.len(), exact: exact.len(), only_numeric: only(numeric, exact) })
        }
        Ordering::Less => Err(UnclearRank::Coincident {
            numeric: numeric.len(),
            exact: exact.len(),
            only_exact: only(exact, numeric),
        }),
    }
}

/// Rounding of a column of unit norm in a scan, before weak columns amplify it.
const SCAN_ROUNDING: f64 = 1e-14;

/// Refuses chosen columns that do not stand out of the span of the others, and others that do. `scan` is the one that keeps
/// the chosen.
///
/// A kept column that stands out by d has a direction with an error of rounding / d, which all columns behind it see.
pub(crate) fn stand_out(scan: &Scan, chosen: &[usize], name: impl Fn(usize) -> String) -> Result<(), UnclearRank> {
    let (mut weak, mut smallest, mut largest_dropped) = (Vec::new(), 1.0_f64, 0.0_f64);
    for (c, &distance) in scan.distance.iter().enumerate() {
        let least = CLEAR_GAP * SCAN_ROUNDING / smallest;
        if chosen.binary_search(&c).is_ok() {
            if distance < least {
                weak.push((name(c), distance));
            }
            smallest = smallest.min(distance.max(SCAN_ROUNDING));
        } else {
            largest_dropped = largest_dropped.max(distance);
            if distance > least {
                weak.push((name(c), distance));
            }
        }
    }
    if weak.is_empty() { Ok(()) } else { Err(UnclearRank::Weak { weak, largest_dropped }) }
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
            if !agree(exact, x[place]) {
                let (dropped, kept) = (name(dropped), name(kept));
                return Err(UnclearRank::Disagreement { dropped, kept, exact, numeric: x[place] });
            }
        }
    }
    Ok(())
}
