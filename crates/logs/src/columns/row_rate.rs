//! Estimates the sampling rate f of a log without a clock from its velocities.
//!
//! ```text
//! dq_r = f (q_{r+1} - q_{r-1}) / 2       by least squares (module `slope`)
//! ```

use crate::columns::slope::Slope;
use crate::columns::words::{Designator, Quantity, Reading};
use crate::table::Table;

/// Smallest squared correlation between a velocity and the difference of its position.
const MIN_SQUARED_CORRELATION: f64 = 0.9;
/// Usual sampling rates of controllers and drivers, Hz.
const USUAL_RATES: [f64; 18] = [
    10.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 100.0, 120.0, 125.0, 200.0, 240.0, 250.0, 333.0, 400.0, 500.0, 1000.0,
    2000.0,
];
/// A rate is replaced by a usual rate if their relative difference is below this.
const USUAL_TOLERANCE: f64 = 0.02;

/// Signals of one joint: a position and the factor that converts it to rad, a velocity and the factor that converts it to
/// rad/s.
pub(crate) type Pair<'a> = ((&'a [f64], f64), (&'a [f64], f64));

/// The sampling rate in Hz for which the differences of the positions agree with the velocities: the median over the joints.
/// `None` if they agree for no joint.
pub(crate) fn rate<'a>(pairs: impl Iterator<Item = Pair<'a>>) -> Option<f64> {
    let rate = |((q, to_rad), (dq, to_rad_s)): Pair| {
        Some(to_rad_s / to_rad * Slope::of(q, dq, None).positive_ratio(MIN_SQUARED_CORRELATION)?)
    };
    let mut rates: Vec<f64> = pairs.filter_map(rate).collect();
    rates.sort_by(f64::total_cmp);
    rates.get(rates.len() / 2).copied()
}

/// The usual rate within 2 % of this rate, Hz. `None` if there is none.
pub(crate) fn usual(rate: f64) -> Option<f64> {
    USUAL_RATES.into_iter().find(|usual| (rate / usual - 1.0).abs() < USUAL_TOLERANCE)
}

/// The sampling rate that follows from the position and velocity columns of `readings`, as text.
pub(crate) fn rows_per_second(table: &Table, readings: &[Reading]) -> Option<String> {
    let of = |quantity: Quantity, joint: Designator| {
        readings
            .iter()
            .find(|r| r.quantity == quantity && r.joint == joint)
            .map(|r| (table.columns[r.column].as_slice(), r.unit.1))
    };
    let positions = readings.iter().filter(|r| r.quantity == Quantity::Position);
    let rate =
        rate(positions.filter_map(|r| Some((of(Quantity::Position, r.joint)?, of(Quantity::Velocity, r.joint)?))))?;
    Some(usual(rate).map_or(format!("{rate:.3} Hz"), |usual| format!("{usual} Hz")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::words::readings;

    fn said(factor: f64) -> Option<String> {
        let q: Vec<f64> = (0..400).map(|r| (0.02 * f64::from(r)).sin()).collect();
        let dq = (0..400).map(|r| factor * 0.02 * 125.0 * (0.02 * f64::from(r)).cos()).collect();
        let table = Table {
            header: vec!["q1".into(), "dq1".into()],
            columns: vec![q, dq],
            texts: vec![None; 2],
            ..Table::default()
        };
        rows_per_second(&table, &readings(&table, &["q1".into()]).unwrap())
    }

    #[test]
    fn velocities_show_the_rate() {
        assert_eq!(said(1.0).as_deref(), Some("125 Hz"));
        assert_eq!(said(1.3).as_deref(), Some("162.511 Hz"));
        // With reversed sign, the column is not the velocity of this position.
        assert_eq!(said(-1.0), None);
    }
}
