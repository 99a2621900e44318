//! Checks the evidence for base parameters. If the evidence does not suffice, there are no base parameters.
//!
//! Base parameters are accepted if these conditions hold:
//!
//! - every number is finite;
//! - the numeric distances of kept and dropped columns have a wide gap;
//! - the rank equals the rank in a finite field ([`crate::base::exact_rank`]), and the kept columns are the independent columns
//!   of the field. These may differ from the numerically chosen columns; each of them must have a clear distance from the span
//!   of the columns before it;
//! - the exact coefficients of the regrouping agree with the numeric ones.

use std::cmp::Ordering;

use crate::base::evidence::{Rank, agree};
use crate::base::rank::{CLEAR_GAP, Scan};
use crate::base::regrouping::Regrouping;
use crate::base::unclear_rank::UnclearRank;

/// Refuses a rank without a clear gap between the distances of kept and dropped columns. The error lists the columns in between,
/// with their distances. `name`: name of the parameter of a column.
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

/// Refuses a numeric rank that differs from the rank in the finite field. The error lists the columns that are independent in
/// only one of the two. `exact`: independent columns in the field.
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

/// Rounding error of a column of unit norm in the numeric scan, before weak columns amplify it.
pub(crate) const SCAN_ROUNDING: f64 = 1e-14;

/// Refuses chosen columns that are too near to the span of the columns before them, and dropped columns that are too far from it.
/// `scan`: the scan that keeps the chosen columns.
///
/// A kept column with the distance d has a direction error of rounding / d. This error affects all columns after the kept
/// column.
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

/// Refuses exact coefficients of relations that differ from the numeric coefficients by more than the accuracy of the numeric
/// coefficients. Relations with weak columns are not compared: they omit the contribution of these columns, so their
/// coefficients differ from a numeric fit.
pub(crate) fn compared_with_numbers(
    scan: &Scan,
    regrouping: &Regrouping,
    weak: &[usize],
    name: impl Fn(usize) -> String,
) -> Result<(), UnclearRank> {
    let nothing = vec![0.0; scan.kept.len()];
    let rows = scan.dependent.iter().map(|(c, x)| (*c, x)).chain(scan.zero.iter().map(|&c| (c, &nothing)));
    let built = regrouping.built_on(weak);
    for (dropped, x) in rows.filter(|row| !built.contains(&row.0)) {
        for (place, &kept) in scan.kept.iter().enumerate() {
            let share = regrouping.shares[&dropped].iter().find(|(k, _)| *k == kept);
            let exact = share.map_or(0.0, |(_, share)| share.number);
            if !agree(exact, x[place]) {
                let (dropped, kept) = (name(dropped), name(kept));
                return Err(UnclearRank::Disagreement { dropped, kept, exact, numeric: x[place] });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rank_of_the_numbers_is_that_of_the_field_or_refused() {
        let scan = Scan { kept: vec![0, 2, 5], ..Scan::default() };
        let refused = |exact: &[usize]| of_one_rank(&scan, exact, |c| format!("X{c}")).err();
        assert!(refused(&[0, 2, 5]).is_none());
        let Some(UnclearRank::Exact { numeric: 3, exact: 2, only_numeric }) = refused(&[0, 2]) else { panic!() };
        assert_eq!(only_numeric, ["X5"]);
        let Some(UnclearRank::Coincident { only_exact, .. }) = refused(&[0, 2, 5, 7]) else { panic!() };
        assert_eq!(only_exact, ["X7"]);
    }
}
