//! The independent columns of a regressor with loops, at closed points of a finite field.
//!
//! The loops of a robot may be assembled in several ways, and those may have several ranks: the crossed four-bar has 8 base
//! parameters where the parallelogram of the same lengths has 3. So points are looked at until the columns of two stand out
//! by the numbers too. Where all agree with each other and not with the numbers, the numbers are special. Where they differ,
//! and none agrees with the numbers, nothing is said.

use expr::Function;

use crate::base::angles::Angles;
use crate::base::closed::closed_point::{ClosedPoint, ClosedPoints};
use crate::base::closed::curve::{curve, regressor_rows};
use crate::base::closed::reason::NoCertificate;
use crate::base::exact_rank::Echelon;
use crate::base::field::{Residue, solve};
use crate::derivation::Derivation;
use random::SplitMix;

/// Points looked at: in pairs of the same draws, the second with the other root of each equation.
const MAX_CLOSED_POINTS: u64 = 12;
/// Points looked at in any case: two assemblies of one robot, and one of another.
const FEWEST_CLOSED_POINTS: u64 = 3;
/// Points that must agree with each other, and with the numbers.
const AGREEING_RANKS: usize = 2;
/// Curves through each point. With one coordinate, three rows of each order may be independent: those of its acceleration,
/// of its squared rate, and of gravity.
const CURVES_PER_POINT: usize = 4;
/// Orders at the end that must bring no new row.
const SETTLED_ORDERS: usize = 2;
/// The longest series.
const MOST_ORDERS: usize = 200;

/// The rank at closed points.
pub(crate) struct ClosedRank {
    /// The columns that are independent of those before them.
    pub columns: Vec<usize>,
    /// Whether other assemblies have another rank.
    pub other_assemblies: bool,
    /// Where they are from.
    pub points: ClosedPoints,
    /// Rows of the points that have this rank, a list per point.
    rows: Vec<Vec<Vec<Residue>>>,
}

impl ClosedRank {
    /// Whether a column is a combination of these at every point, with one set of coefficients each.
    pub(crate) fn is_spanned(&self, column: usize, support: &[usize]) -> bool {
        let picked = |row: &Vec<Residue>| support.iter().chain([&column]).map(|&c| row[c]).collect();
        self.rows.iter().all(|rows| solve(rows.iter().map(picked).collect(), support.len()).is_some())
    }
}

/// The columns of those assemblies that the numbers agree with, else of all that were looked at. About
/// `expected` columns are expected.
pub(crate) fn closed_rank(
    derivation: &mut Derivation,
    regressor: &Function,
    agrees: &dyn Fn(&[usize]) -> bool,
    expected: usize,
) -> Result<ClosedRank, NoCertificate> {
    let Some(closure) = derivation.closure_function() else { return Err(NoCertificate::OtherForm) };
    let points = ClosedPoints::new(derivation, closure)?;
    let angles = Angles::of(regressor.graph());
    let (mut found, mut failure): (Vec<At>, _) = (Vec::new(), NoCertificate::OtherForm);
    // The first assembly that the numbers agree with.
    let mut chosen: Option<Vec<usize>> = None;
    for k in 0..MAX_CLOSED_POINTS {
        let mut random = SplitMix(1979 + k / 2);
        let point = points.point(&mut random, k % 2 == 1)?;
        match columns_at(&points, regressor, &angles, expected, &point, &mut random) {
            Ok(at) => {
                if chosen.is_none() && agrees(&at.columns) {
                    chosen = Some(at.columns.clone());
                }
                found.push(at);
            }
            Err(reason) => failure = reason,
        }
        let n_agree = found.iter().filter(|at| chosen.as_ref() == Some(&at.columns)).count();
        if k + 1 >= FEWEST_CLOSED_POINTS && n_agree >= AGREEING_RANKS {
            break;
        }
        // Another assembly may not be singular; one that does not move will not move at other lengths.
        if found.is_empty() && k >= 1 && failure != NoCertificate::Singular {
            break;
        }
    }
    let Some(first) = found.first() else { return Err(failure) };
    let columns = chosen.clone().unwrap_or(first.columns.clone());
    let (same, others): (Vec<At>, Vec<At>) = found.into_iter().partition(|at| at.columns == columns);
    if same.len() < AGREEING_RANKS || (chosen.is_none() && !others.is_empty()) {
        return Err(NoCertificate::OtherAssemblies);
    }
    let rows = same.into_iter().map(|at| at.rows).collect();
    Ok(ClosedRank { columns, other_assemblies: !others.is_empty(), points, rows })
}

/// The columns at one point, and the rows that tell.
struct At {
    columns: Vec<usize>,
    rows: Vec<Vec<Residue>>,
}

fn columns_at(
    points: &ClosedPoints,
    regressor: &Function,
    angles: &Angles,
    expected: usize,
    point: &ClosedPoint,
    random: &mut SplitMix,
) -> Result<At, NoCertificate> {
    let n = regressor.outputs[0].rows.max(1);
    // Orders enough for `expected` independent rows and some to spare, from all curves together.
    let mut order =
        (expected + expected / 3 + 8).div_ceil(n * (CURVES_PER_POINT - 1)).max(SETTLED_ORDERS + 1) + SETTLED_ORDERS;
    loop {
        let mut by_order: Vec<Vec<Vec<Residue>>> = vec![Vec::new(); order + 1];
        for _ in 0..CURVES_PER_POINT {
            let along = curve(points, point, order, random)?;
            let rows = regressor_rows(regressor, angles, point, along, order, random)?;
            by_order.iter_mut().zip(rows).for_each(|(all, rows)| all.extend(rows));
        }
        // The rows of low order go in first: the last order that brings a new row is remembered.
        let mut echelon = Echelon::default();
        let mut settled_since = 0;
        for (k, rows) in by_order.iter().enumerate() {
            for row in rows {
                if echelon.add(row.clone()) {
                    settled_since = k;
                }
            }
        }
        // Settled: the last orders brought no new row. Else the curves are followed further.
        if order - settled_since >= SETTLED_ORDERS {
            return Ok(At { columns: echelon.columns(), rows: by_order.concat() });
        }
        if order >= MOST_ORDERS {
            return Err(NoCertificate::OtherForm);
        }
        order *= 2;
    }
}
