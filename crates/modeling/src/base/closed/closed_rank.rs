//! Determines the independent columns of the regressor of a robot with loops, at closed points of a finite field.
//!
//! The loops of a robot may have several assemblies with different ranks: the crossed four-bar has 8 base parameters, the
//! parallelogram with the same lengths has 3. So points are evaluated until two of them have independent columns that are also
//! clearly independent numerically. If all points have the same independent columns, but these columns are numerically
//! dependent, the lengths in the robot's file are a special case. If the columns of the points differ, and no point has the
//! numeric columns, there is no result.

use expr::Function;

use crate::base::angles::GraphAngles;
use crate::base::closed::closed_point::{ClosedPoint, ClosedPoints};
use crate::base::closed::curve::{curve, regressor_rows};
use crate::base::closed::reason::NoCertificate;
use crate::base::exact_rank::Echelon;
use crate::base::field::{Residue, solve};
use crate::derivation::Derivation;
use random::SplitMix;

/// Largest number of closed points that are evaluated. The points form pairs with equal draws; the second point of a pair takes
/// the other root of each equation.
const MAX_CLOSED_POINTS: u64 = 12;
/// Smallest number of closed points: two assemblies of one set of constants, and one of another set.
const FEWEST_CLOSED_POINTS: u64 = 3;
/// The search can end when this many closed points have the same independent columns.
const AGREEING_RANKS: usize = 2;
/// Number of curves through each closed point. With one coordinate, up to three rows of each order are independent: the rows of
/// the acceleration, of the squared rate of this coordinate, and of gravity.
const CURVES_PER_POINT: usize = 4;
/// The order of a power series is large enough if this many of its last orders give no new independent row.
const SETTLED_ORDERS: usize = 2;
/// Largest order of a power series along a curve.
const MAX_SERIES_ORDER: usize = 200;
/// Number of rows that the first series gives in addition to 4/3 of the expected rank.
const SPARE_ROWS: usize = 8;
/// Seed of the random draws for the first pair of closed points.
const FIRST_SEED: u64 = 1979;

/// The independent columns of a regressor at closed points, with the evidence.
pub(crate) struct ClosedRank {
    /// The regressor columns that are independent of the columns before them.
    pub columns: Vec<usize>,
    /// Whether other assemblies of the loops have other independent columns.
    pub other_assemblies: bool,
    /// The data with which further closed points can be found.
    pub points: ClosedPoints,
    /// The rows of the regressor at each point with the independent columns `columns`, as `[point][row][column]`.
    rows: Vec<Vec<Vec<Residue>>>,
}

impl ClosedRank {
    /// Whether a column is a linear combination of the columns `support` at every point. The coefficients may differ between
    /// points.
    pub(crate) fn is_spanned(&self, column: usize, support: &[usize]) -> bool {
        let picked = |row: &Vec<Residue>| support.iter().chain([&column]).map(|&c| row[c]).collect();
        self.rows.iter().all(|rows| solve(rows.iter().map(picked).collect(), support.len()).is_some())
    }
}

/// Determines the independent columns of a regressor at closed points. `agrees(columns)`: whether given columns are also
/// independent numerically. Only assemblies of the loops with numerically independent columns are used. If there is no such
/// assembly, all points must have the same independent columns. `expected`: about how many columns are expected.
pub(crate) fn closed_rank(
    derivation: &mut Derivation,
    regressor: &Function,
    agrees: &dyn Fn(&[usize]) -> bool,
    expected: usize,
) -> Result<ClosedRank, NoCertificate> {
    let Some(closure) = derivation.closure_function() else { return Err(NoCertificate::OtherForm) };
    let points = ClosedPoints::new(derivation, closure)?;
    let angles = GraphAngles::of(regressor.graph());
    let (mut found, mut failure): (Vec<ColumnsAtPoint>, _) = (Vec::new(), NoCertificate::OtherForm);
    // The columns of the first point at which `agrees` holds.
    let mut chosen: Option<Vec<usize>> = None;
    for k in 0..MAX_CLOSED_POINTS {
        let mut random = SplitMix(FIRST_SEED + k / 2);
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
        // If a point is singular, another assembly may be regular. For other reasons more points do not help: loops that do not
        // move stay fixed at other lengths too.
        if found.is_empty() && k >= 1 && failure != NoCertificate::Singular {
            break;
        }
    }
    let Some(first) = found.first() else { return Err(failure) };
    let columns = chosen.clone().unwrap_or(first.columns.clone());
    let (same, others): (Vec<ColumnsAtPoint>, Vec<ColumnsAtPoint>) =
        found.into_iter().partition(|at| at.columns == columns);
    if same.len() < AGREEING_RANKS || (chosen.is_none() && !others.is_empty()) {
        return Err(NoCertificate::OtherAssemblies);
    }
    let rows = same.into_iter().map(|at| at.rows).collect();
    Ok(ClosedRank { columns, other_assemblies: !others.is_empty(), points, rows })
}

/// The independent columns at one closed point, and the rows of the regressor from which they were found.
struct ColumnsAtPoint {
    columns: Vec<usize>,
    rows: Vec<Vec<Residue>>,
}

fn columns_at(
    points: &ClosedPoints,
    regressor: &Function,
    angles: &GraphAngles,
    expected: usize,
    point: &ClosedPoint,
    random: &mut SplitMix,
) -> Result<ColumnsAtPoint, NoCertificate> {
    let n = regressor.outputs[0].rows.max(1);
    // The order for which all curves together give `expected` independent rows and some spare rows.
    let mut order = (expected + expected / 3 + SPARE_ROWS).div_ceil(n * (CURVES_PER_POINT - 1)).max(SETTLED_ORDERS + 1)
        + SETTLED_ORDERS;
    loop {
        let mut by_order: Vec<Vec<Vec<Residue>>> = vec![Vec::new(); order + 1];
        for _ in 0..CURVES_PER_POINT {
            let along = curve(points, point, order, random)?;
            let rows = regressor_rows(regressor, angles, point, along, order, random)?;
            by_order.iter_mut().zip(rows).for_each(|(all, rows)| all.extend(rows));
        }
        // The rows of low order are added first, to find the last order that gives a new independent row.
        let mut echelon = Echelon::default();
        let mut settled_since = 0;
        for (k, rows) in by_order.iter().enumerate() {
            for row in rows {
                if echelon.add(row.clone()) {
                    settled_since = k;
                }
            }
        }
        // If the last orders gave no new row, the columns are complete. Otherwise the order is doubled.
        if order - settled_since >= SETTLED_ORDERS {
            return Ok(ColumnsAtPoint { columns: echelon.columns(), rows: by_order.concat() });
        }
        if order >= MAX_SERIES_ORDER {
            return Err(NoCertificate::OtherForm);
        }
        order *= 2;
    }
}
