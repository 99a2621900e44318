//! Proposes units from values: a position with a range above three turns is in degrees or ticks; a velocity is compared with the
//! derivative of the position.
//!
//! A tick is one count of an encoder; a turn has for example 4096 ticks.

use crate::cleaning::raw_words::RawWord;
use crate::cleaning::turns::extremes;
use crate::columns::proposal::proposed::short;
use crate::columns::slope::Slope;
use crate::columns::words::Quantity;
use crate::table::Table;

/// Whole numbers are encoder ticks if their range is at least this.
const MIN_TICKS: f64 = 100.0;
/// Largest range of a position in degrees.
const MAX_RANGE_DEG: f64 = 800.0;
/// Largest position in per cent of the range of a joint, with an allowance for rounding.
const MAX_PERCENT: f64 = 100.5;
/// Largest relative difference between a measured velocity and the derivative of the position, for a known unit.
const RATIO_TOLERANCE: f64 = 0.1;
/// Units of a velocity, each with the value of 1 rad/s in this unit.
pub(super) const VELOCITY_UNITS: [(&str, f64); 3] = [("rad/s", 1.0), ("deg/s", 57.29578), ("rpm", 9.549297)];
/// Units of velocity registers of servos, each with the value of 1 rad/s in this unit: Dynamixel X, and Feetech STS in both
/// settings (docs/how-to/record-on-servos.md has the sources).
const REGISTER_UNITS: [(&str, f64); 3] =
    [("counts(0.229 rpm)", 41.69999), ("counts(0.732 rpm)", 13.04548), ("ticks(4096)/s", 651.8986)];
/// Smallest squared correlation between a velocity and the derivative of its position.
const MIN_SQUARED_CORRELATION: f64 = 0.8;

/// The unit of the columns of a quantity, with the reason. `None` if it is the SI unit or the unit in the header.
pub(super) fn unit(
    table: &Table,
    columns: &[usize],
    quantity: Quantity,
    clock: Option<(usize, f64)>,
    position_factor: f64,
) -> Option<(String, String)> {
    let words: Vec<RawWord> = columns.iter().filter_map(|&c| RawWord::of(&table.columns[c])).collect();
    let word = words.first().map(|word| match word {
        RawWord::TwosComplement { bits, .. } => format!("int{bits}"),
        RawWord::SignBit { bit, .. } => format!("signbit({bit})"),
    });
    if let Some(word) = word {
        let reason = "jumps by the whole word where its sign changes; add what a count is: counts(2.69 mA)";
        return Some((word, reason.into()));
    }
    let spans: Vec<f64> = columns.iter().map(|&c| extremes(&table.columns[c])).map(|(low, high)| high - low).collect();
    let largest = columns.iter().flat_map(|&c| &table.columns[c]).fold(0.0, |most: f64, x| most.max(x.abs()));
    let widest = spans.iter().copied().fold(0.0, f64::max);
    let whole = columns.iter().all(|&c| table.columns[c].iter().all(|x| x.fract() == 0.0));
    // Three turns, rad. The joints of most arms have a smaller range.
    const THREE_TURNS: f64 = 19.0;
    match quantity {
        Quantity::Position if whole && widest > MIN_TICKS => Some((
            "ticks(4096)".into(),
            "whole numbers: ticks of an encoder; 4096 a turn is a guess, say how many".into(),
        )),
        Quantity::Position if widest > THREE_TURNS && widest < MAX_RANGE_DEG => Some((
            "deg".into(),
            format!(
                "they span {} and would be {:.0} turns in rad{}",
                short(widest),
                widest / std::f64::consts::TAU,
                if largest <= MAX_PERCENT { "; or per cent of a range, if the log is normalised" } else { "" }
            ),
        )),
        Quantity::Velocity => {
            let ratio = slope_ratio(table, columns, clock?, position_factor)?;
            let (unit, _) = VELOCITY_UNITS
                .into_iter()
                .chain(REGISTER_UNITS)
                .find(|(_, k)| (ratio / k - 1.0).abs() < RATIO_TOLERANCE)?;
            (unit != "rad/s")
                .then(|| (unit.into(), format!("they are {} times the slope of the position", short(ratio))))
        }
        _ => None,
    }
}

/// Ratio of the velocity of the first joint to the derivative of its position in rad/s. `None` if no position fits.
fn slope_ratio(table: &Table, velocity: &[usize], (clock, second): (usize, f64), to_si: f64) -> Option<f64> {
    // The position of the same joint is the column whose derivative has the largest correlation with the velocity.
    let v = &table.columns[velocity[0]];
    let others = (0..table.columns.len()).filter(|c| *c != clock && !velocity.contains(c));
    let slopes = others.map(|c| Slope::of(&table.columns[c], v, Some(&table.columns[clock])));
    // Of columns that fit equally well up to rounding, the first is taken: logs have positions before torques.
    const TIE: f64 = 1e-9;
    let better = |best: Slope, next: Slope| {
        if next.squared_correlation > best.squared_correlation + TIE { next } else { best }
    };
    let best = slopes.filter(|slope| slope.squared_correlation > MIN_SQUARED_CORRELATION).reduce(better)?;
    Some(best.ratio * second / to_si)
}
