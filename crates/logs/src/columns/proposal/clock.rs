//! Proposes the clock of a table: its column and unit, or the rows per second.
//!
//! A column is a clock if it increases in nearly all rows and if its median step is a usual sampling period. Several episodes
//! (parts of a file with their own clock) are allowed, so it may restart.

use crate::columns::clocks;
use crate::columns::mapping::Columns;
use crate::columns::names::ColumnNames;
use crate::columns::proposal::header_patterns::quoted;
use crate::columns::proposal::header_words::{names_unit, words};
use crate::columns::proposal::proposed::{Proposal, Proposed, set_unit, short};
use crate::columns::proposal::units::VELOCITY_UNITS;
use crate::columns::row_rate::{rate, usual};
use crate::columns::words::Quantity;
use crate::table::Table;

/// Words for a clock.
const CLOCKS: &str = "time zeit stamp timestamp clock temps tiempo sec";
/// Usual sampling periods of logs, s: from 4 kHz to 20 Hz.
const LOG_PERIODS_S: std::ops::Range<f64> = 2.5e-4..0.0501;
/// Sampling periods of slow logs, s: from 20 Hz to 0.5 Hz. A clock in ms may also have such steps (below 2 ms), but its times
/// are whole numbers.
const SLOW_PERIODS_S: std::ops::Range<f64> = 0.0501..2.0;
/// A clock restarts with each episode. It must have at least this number of steps forward for each step back.
const STEPS_PER_RESTART: usize = 100;

/// Proposes the clock. Returns its column and the factor that converts it to s.
pub(super) fn clock(
    table: &Table,
    patterns: &[(String, Vec<usize>)],
    proposal: &mut Proposal,
    names: &mut ColumnNames,
) -> Option<(usize, f64)> {
    let is_named = |column: &usize| {
        words(&table.header[*column]).iter().any(|w| CLOCKS.split_whitespace().any(|clock| clock == w))
    };
    if let Some((seconds, (fraction, ..))) = clocks::pairs(table).first() {
        let reason = format!("seconds, and `{}` counts their fractions", table.header[*fraction]);
        proposal.columns.push(Proposed { key: "time", value: quoted(&table.header[*seconds]), reason });
        names.time = Some(table.header[*seconds].clone());
        return None;
    }
    // If there are several clocks, the finest is chosen: a column of whole seconds increases only in few rows.
    let fineness = |column: &usize| table.columns[*column].windows(2).filter(|w| w[1] > w[0]).count();
    // A column that has a similar column for each joint is a signal that happens to increase, so it is no clock. The pattern
    // `c{}` matches all columns of a table without headers.
    let of_joints = patterns.iter().filter(|(pattern, columns)| pattern != "c{}" && columns.len() > 1);
    let of_joints: Vec<usize> = of_joints.flat_map(|(_, columns)| columns.iter().copied()).collect();
    let rising = (0..table.header.len()).filter(|column| rises(&table.columns[*column]));
    let is_apart = |column: &usize| !of_joints.contains(column) && !is_counter(&table.columns[*column]);
    let rising = rising.filter(|column| is_named(column) || is_apart(column));
    let column = rising.max_by_key(|c| (is_named(c), fineness(c), std::cmp::Reverse(*c)))?;
    proposal.columns.push(Proposed {
        key: "time",
        value: quoted(&table.header[column]),
        reason: format!("counts up, by {} a row", short(step(&table.columns[column]))),
    });
    names.time = Some(table.header[column].clone());
    Some((column, clock_unit(&table.columns[column], proposal, names)))
}

/// Whether a column increases as a clock does: in most rows, except at the start of each of a few episodes.
pub(super) fn rises(x: &[f64]) -> bool {
    let steps = |holds: fn(f64, f64) -> bool| x.windows(2).filter(|w| holds(w[0], w[1])).count();
    let (up, back) = (steps(|a, b| b > a), steps(|a, b| b < a));
    2 * up >= x.len().saturating_sub(1).max(1) && back * STEPS_PER_RESTART <= up
}

/// Whether a column counts the rows in an unknown unit: whole numbers, in most rows 1 more than in the row before.
fn is_counter(x: &[f64]) -> bool {
    x.iter().all(|x| x.fract() == 0.0) && step(x) == 1.0
}

/// The median step forward of a clock, in its unit.
fn step(clock: &[f64]) -> f64 {
    middle(clock.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > 0.0).collect())
}

/// Proposes the unit of a clock if its step is no sampling period in s; returns the factor to s.
pub(super) fn clock_unit(clock: &[f64], proposal: &mut Proposal, names: &mut ColumnNames) -> f64 {
    let step = step(clock);
    if SLOW_PERIODS_S.contains(&step) && clock.iter().any(|t| t.fract() != 0.0) {
        return 1.0;
    }
    let units = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
    let unit = units.into_iter().find(|unit| LOG_PERIODS_S.contains(&(step * unit.1)));
    let Some((unit, factor)) = unit.filter(|unit| unit.0 != "s") else { return 1.0 };
    let reason = format!(
        "{} a row would be {} Hz in s, and are {:.0} Hz so",
        short(step),
        short(1.0 / step),
        1.0 / (step * factor)
    );
    proposal.units.push(Proposed { key: "time", value: unit.into(), reason });
    names.units.time = Some(unit.into());
    factor
}

/// Proposes the rows per second for a log without a clock, if the log has velocities.
pub(super) fn row_rate((table, coordinates): (&Table, &[String]), proposal: &mut Proposal, names: &mut ColumnNames) {
    const NO_CLOCK: &str = "no column counts up as a clock does";
    // The rate does not affect which columns are found, so any rate can be used here.
    let with_rate = ColumnNames { rate: Some(1.0), ..names.clone() };
    let found = Columns::find(table, coordinates, &with_rate).ok();
    // The rate for each unit that the velocities may have.
    let rates = found.as_ref().and_then(|found| {
        let velocities = found.velocity.as_ref()?;
        let of = |per_rad_s: f64| {
            let pairs = found.position.iter().zip(velocities).map(|(q, dq)| {
                let velocity = (table.columns[dq.column].as_slice(), dq.factor / per_rad_s);
                ((table.columns[q.column].as_slice(), q.factor), velocity)
            });
            rate(pairs)
        };
        let is_said = velocities.iter().any(names_unit);
        let units = VELOCITY_UNITS.into_iter().filter(|(unit, _)| *unit == "rad/s" || !is_said);
        units.map(|(unit, per_rad_s)| Some((unit, of(per_rad_s)?))).collect::<Option<Vec<(&str, f64)>>>()
    });
    let usual: Vec<(&str, f64)> =
        rates.iter().flatten().filter_map(|(unit, rate)| Some((*unit, usual(*rate)?))).collect();
    let (unit, rate) = match (usual.as_slice(), rates.as_deref()) {
        (&[found], _) => found,
        (all, Some(&[(_, rate), ..])) => {
            let what = if all.is_empty() { "which is no usual rate" } else { "if they are in SI units" };
            proposal.missing.push(format!(
                "{NO_CLOCK}, and the velocities are the derivatives of the positions at {rate:.3} Hz, {what}: say the rows per \
                 second, [rate=HZ]"
            ));
            return;
        }
        _ => return proposal.missing.push(format!("{NO_CLOCK}: say the rows per second, [rate=HZ]")),
    };
    let reason = format!("Hz; {NO_CLOCK}; the velocities are the derivatives of the positions at this rate");
    proposal.columns.insert(0, Proposed { key: "rate", value: rate.to_string(), reason });
    names.rate = Some(rate);
    if unit != "rad/s" {
        let reason = "at no usual rate are they the derivatives in another unit".into();
        proposal.units.push(Proposed { key: "velocity", value: quoted(unit), reason });
        set_unit(names, Quantity::Velocity, unit.into());
    }
}

/// The median of the numbers.
fn middle(mut numbers: Vec<f64>) -> f64 {
    let middle = numbers.len() / 2;
    if numbers.is_empty() {
        return f64::NAN;
    }
    *numbers.select_nth_unstable_by(middle, f64::total_cmp).1
}
