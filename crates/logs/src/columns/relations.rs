//! Finds which columns are derivatives of others, if the headers do not determine the quantities.
//!
//! A column b is the velocity of a column a if the squared correlation of b with da/dt is above [`MIN_SQUARED_CORRELATION`], and
//! larger than for every other column. da/dt is computed by central differences over the clock.

use crate::columns::slope::Slope;
use crate::table::Table;

/// Smallest squared correlation of a velocity with the derivative of its position.
const MIN_SQUARED_CORRELATION: f64 = 0.9;
/// Largest number of columns that are compared with each other.
const MAX_COLUMNS: usize = 64;
/// Number of rows that are compared.
const MAX_ROWS: usize = 4000;

/// The columns of the joints, in the order of the file, as indices in the table.
pub(crate) struct Relations {
    pub positions: Vec<usize>,
    /// The velocity columns, one per position.
    pub velocities: Vec<usize>,
    /// The remaining columns if there is exactly one per joint; otherwise `None`.
    pub others: Option<Vec<usize>>,
}

/// The positions and velocities of `n` joints; `None` unless exactly `n` pairs are found. `clock`: its column; without one, the
/// rows count as equally spaced.
pub(crate) fn relations(table: &Table, clock: Option<usize>, n: usize) -> Option<Relations> {
    let columns: Vec<usize> =
        (0..table.header.len()).filter(|c| Some(*c) != clock && !table.columns[*c].is_empty()).collect();
    if columns.len() > MAX_COLUMNS {
        return None;
    }
    let rows = table.rows().min(MAX_ROWS);
    let t = clock.map(|clock| &table.columns[clock][..rows]);
    let squared_correlation = |a: usize, b: usize| {
        let slope = Slope::of(&table.columns[a][..rows], &table.columns[b][..rows], t);
        // A negative correlation does not count: the column is not the velocity of this position.
        slope.positive_ratio(0.0).map_or(0.0, |_| slope.squared_correlation)
    };
    let velocity = |&a: &usize| {
        let others = columns.iter().filter(|b| **b != a).map(|&b| (squared_correlation(a, b), b));
        let best = others.filter(|(r, _)| *r > MIN_SQUARED_CORRELATION).max_by(|x, y| x.0.total_cmp(&y.0));
        best.map(|(_, b)| (a, b))
    };
    let pairs: Vec<(usize, usize)> = columns.iter().filter_map(velocity).collect();
    let (positions, velocities): (Vec<usize>, Vec<usize>) = pairs.into_iter().unzip();
    // An acceleration is the derivative of a velocity, so there would be more pairs than joints. Then nothing is found.
    let is_apart = velocities.iter().all(|v| !positions.contains(v));
    if positions.len() != n || !is_apart {
        return None;
    }
    let rest: Vec<usize> =
        columns.iter().copied().filter(|c| !positions.contains(c) && !velocities.contains(c)).collect();
    Some(Relations { positions, velocities, others: Some(rest).filter(|rest| rest.len() == n) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_found_whatever_the_names() {
        let t: Vec<f64> = (0..500).map(|r| 0.004 * f64::from(r)).collect();
        let of = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { t.iter().map(|t| f(*t)).collect() };
        let columns = vec![
            t.clone(),
            of(&|t| (3.0 * t).sin()),
            of(&|t| 0.5 * (5.0 * t).cos()),
            of(&|t| 3.0 * (3.0 * t).cos()),
            of(&|t| -2.5 * (5.0 * t).sin()),
            of(&|t| 7.0 * (3.0 * t).sin() + (11.0 * t).sin()),
            of(&|t| (2.0 * t).cos() + (13.0 * t).cos()),
        ];
        let header = (1..=7).map(|k| format!("c{k}")).collect();
        let table = Table { header, columns, ..Table::default() };
        let found = relations(&table, Some(0), 2).unwrap();
        assert_eq!((found.positions, found.velocities, found.others), (vec![1, 2], vec![3, 4], Some(vec![5, 6])));
        let without =
            Table { header: table.header[1..].into(), columns: table.columns[1..].into(), ..Table::default() };
        assert_eq!(relations(&without, None, 2).unwrap().positions, [0, 1]);
        // Three joints are requested, but the table has only two pairs of position and velocity: nothing is found.
        assert!(relations(&table, Some(0), 3).is_none());
    }
}
