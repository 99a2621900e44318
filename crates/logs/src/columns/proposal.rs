//! Proposes names and units for the columns of a table, each with its reason.
//!
//! First, columns are found by the meaning of their headers ([`Columns::find`]). If this fails, headers that differ by a number
//! or a joint name form a pattern. Words in the pattern determine the quantity. The values determine the unit: a position with a
//! range above three turns is in degrees or ticks; a velocity is compared with the derivative of the position; a clock is
//! compared with the usual sampling rates.

use std::collections::BTreeMap;
use std::fmt;

use crate::cleaning::raw_words::RawWord;
use crate::cleaning::turns::extremes;
use crate::columns::clocks;
use crate::columns::mapping::Columns;
use crate::columns::names::{ColumnNames, NamePattern};
use crate::columns::relations::{Relations, relations};
use crate::columns::row_rate::{rate, usual};
use crate::columns::source::ColumnSource;
use crate::columns::units::given_unit;
use crate::columns::words::{Quantity, with_underscores};
use crate::table::Table;

/// One line of the proposal: a key, its value and the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposed {
    /// The key in the options, for example `time` or `position`.
    pub key: &'static str,
    /// The proposed value of the key.
    pub value: String,
    /// The reason for the value.
    pub reason: String,
}

/// The proposed lines for the options file.
#[derive(Clone, Debug, Default)]
pub struct Proposal {
    /// Proposed names of columns.
    pub columns: Vec<Proposed>,
    /// Proposed units of columns without a unit in the header.
    pub units: Vec<Proposed>,
    /// Sentences on the quantities that could not be determined.
    pub missing: Vec<String>,
    /// The resulting mapping; `None` if a quantity is missing.
    pub mapping: Option<Columns>,
}

/// Words for measured quantities in headers, in several languages. The most likely word is first.
const WORDS: [(Quantity, &[&str]); 4] = [
    (
        Quantity::Position,
        &[
            "position",
            "positions",
            "pos",
            "angle",
            "angles",
            "winkel",
            "posicion",
            "posición",
            "angulo",
            "ángulo",
            "位置",
            "角度",
            "关节位置",
            "关节角度",
            "関節位置",
            "関節角度",
            "state",
            "ist",
            "actual",
            "theta",
            "q",
            "qpos",
            "jp",
            "axisact",
            "enc",
            "encoder",
            "th",
            "mp",
        ],
    ),
    (
        Quantity::Velocity,
        &[
            "velocity",
            "velocities",
            "vel",
            "speed",
            "geschwindigkeit",
            "velocidad",
            "速度",
            "角速度",
            "关节速度",
            "関節速度",
            "omega",
            "dq",
            "qd",
            "qvel",
            "jv",
        ],
    ),
    (
        Quantity::Torque,
        &[
            "torque",
            "torques",
            "effort",
            "efforts",
            "eff",
            "moment",
            "momente",
            "drehmoment",
            "par",
            "力矩",
            "扭矩",
            "关节力矩",
            "トルク",
            "関節トルク",
            "tau",
            "trq",
            "torq",
            "tm",
            "mt",
            "jf",
            "load",
            "force",
            "kraft",
            "u",
        ],
    ),
    (Quantity::Current, &["current", "currents", "strom", "corriente", "电流", "電流", "amp", "curr"]),
];
/// Words, separated by blanks, for signals that are not measured, or for other quantities.
const OTHERS: &str = "command commanded cmd target desired des ref reference soll setpoint goal external ext error \
    temp temperature acc voltage stiffness model";
/// Words for the goals of a position servo.
const GOALS: &str = "goal action target command commanded cmd setpoint desired des ref reference soll leader";
/// Words for a clock.
const CLOCKS: &str = "time zeit stamp timestamp clock temps tiempo sec";
/// Usual sampling periods of logs, s: from 4 kHz to 20 Hz.
const LOG_PERIODS_S: std::ops::Range<f64> = 2.5e-4..0.0501;
/// Sampling periods of slow logs, s: from 20 Hz to 0.5 Hz. Clocks in ms that have such steps are whole numbers.
const SLOW_PERIODS_S: std::ops::Range<f64> = 0.0501..2.0;
/// A clock restarts with each episode. It must have at least this number of steps forward for each step back.
const STEPS_PER_RESTART: usize = 100;
/// Whole numbers are encoder ticks if their range is at least this.
const MIN_TICKS: f64 = 100.0;
/// Largest range of a position in degrees.
const MAX_RANGE_DEG: f64 = 800.0;
/// Largest relative difference between a measured velocity and the derivative of the position, for a known unit.
const RATIO_TOLERANCE: f64 = 0.1;
/// Units of a velocity, and the number of them in a rad/s.
const VELOCITY_UNITS: [(&str, f64); 3] = [("rad/s", 1.0), ("deg/s", 57.29578), ("rpm", 9.549297)];
/// Smallest squared correlation between a velocity and the derivative of its position.
const MIN_SQUARED_CORRELATION: f64 = 0.8;

/// Proposes columns of a table for the coordinates of a robot. `rate`: rows per second, Hz, in place of a clock.
pub fn propose(table: &Table, coordinates: &[String], rate: Option<f64>) -> Proposal {
    let mut proposal = Proposal::default();
    let mut names = ColumnNames { rate, ..ColumnNames::default() };
    if let Some(rate) = rate {
        proposal.columns.push(Proposed { key: "rate", value: rate.to_string(), reason: "Hz, as given".into() });
    }
    if let Ok(mapping) = Columns::find(table, coordinates, &names) {
        return of_names((table, coordinates), mapping, proposal, names);
    }
    let patterns = patterns(table, coordinates);
    let clock = if rate.is_none() { clock(table, &patterns, &mut proposal, &mut names) } else { None };
    for (quantity, words) in WORDS {
        // A log has either torques or currents. Velocities may already have been found by their values.
        let is_found = match quantity {
            Quantity::Velocity => names.velocity.is_some(),
            Quantity::Torque | Quantity::Current => names.torque.is_some(),
            _ => false,
        };
        if is_found {
            continue;
        }
        let score = |pattern: &str| score(pattern, quantity, words);
        let best = patterns.iter().filter(|(p, _)| score(p).is_some()).min_by_key(|(p, _)| score(p));
        let Some((pattern, columns)) = best else {
            if quantity == Quantity::Position
                && by_values((table, coordinates), clock, &patterns, &mut proposal, &mut names)
            {
                continue;
            }
            if matches!(quantity, Quantity::Position) {
                proposal.missing.push("no columns, one per joint, are named like positions".into());
            }
            continue;
        };
        let key = key(quantity);
        let (first, last) = (&table.header[columns[0]], &table.header[columns[columns.len() - 1]]);
        let (given, value) = given(table, coordinates, pattern, columns);
        let reason = format!("{first} .. {last}: one per joint, named like a {key}");
        proposal.columns.push(Proposed { key, value, reason });
        *names_of(&mut names, quantity) = Some(given);
        if let Some((unit, reason)) = unit(table, columns, quantity, clock, factor_of(&names)) {
            proposal.units.push(Proposed { key, value: quoted(&unit), reason });
            set_unit(&mut names, quantity, unit);
        }
    }
    if names.time.is_none() && names.rate.is_none() {
        row_rate((table, coordinates), &mut proposal, &mut names);
    }
    if names.torque.is_none() && names.current.is_none() && names.position.is_some() {
        goals((table, coordinates), &patterns, &mut proposal, &mut names);
    }
    if names.torque.is_none() && names.current.is_none() && names.goal.is_none() {
        proposal.missing.push("no columns, one per joint, are named like torques or currents".into());
    }
    match Columns::find(table, coordinates, &names) {
        Ok(mapping) => proposal.mapping = Some(mapping),
        Err(error) if proposal.missing.is_empty() => proposal.missing.push(error.to_string()),
        Err(_) => {}
    }
    proposal
}

/// The proposal where all columns are found by their names: units that no header names and that the values contradict.
fn of_names(
    (table, coordinates): (&Table, &[String]),
    mapping: Columns,
    mut proposal: Proposal,
    mut names: ColumnNames,
) -> Proposal {
    let column = mapping.time.column;
    let is_one_clock = mapping.rate.is_none() && mapping.time_fraction.is_none();
    if is_one_clock && !rises(&table.columns[column]) {
        row_rate((table, coordinates), &mut proposal, &mut names);
        proposal.mapping = if names.rate.is_some() { Columns::find(table, coordinates, &names).ok() } else { None };
        return proposal;
    }
    let is_judged = is_one_clock && !names_unit(&mapping.time);
    let factor =
        if is_judged { clock_unit(&table.columns[column], &mut proposal, &mut names) } else { mapping.time.factor };
    let clock = mapping.rate.is_none().then_some((column, factor));
    let mut position_factor = mapping.position[0].factor;
    let groups = [(Quantity::Position, Some(&mapping.position)), (Quantity::Velocity, mapping.velocity.as_ref())];
    for (quantity, sources) in groups {
        // A header with a unit is believed.
        let Some(sources) = sources.filter(|all| !all.iter().any(names_unit)) else { continue };
        let columns: Vec<usize> = sources.iter().map(|source| source.column).collect();
        if let Some((unit, reason)) = unit(table, &columns, quantity, clock, position_factor) {
            proposal.units.push(Proposed { key: key(quantity), value: quoted(&unit), reason });
            set_unit(&mut names, quantity, unit);
            position_factor = factor_of(&names);
        }
    }
    proposal.mapping = Columns::find(table, coordinates, &names).ok().or(Some(mapping));
    proposal
}

/// Whether the header of a column names its unit.
fn names_unit(source: &ColumnSource) -> bool {
    let is_of_si = |word: &String| matches!(word.as_str(), "rad" | "radians" | "radps" | "s" | "sec" | "seconds");
    source.factor != 1.0 || words(&source.header).iter().any(is_of_si)
}

/// The factor to rad of the positions.
fn factor_of(names: &ColumnNames) -> f64 {
    let unit = names.units.position.as_deref().unwrap_or("rad");
    given_unit(Quantity::Position, unit).map_or(1.0, |unit| unit.factor)
}

/// Proposes the rows per second of a log without a clock, where it has velocities.
fn row_rate((table, coordinates): (&Table, &[String]), proposal: &mut Proposal, names: &mut ColumnNames) {
    const NO_CLOCK: &str = "no column counts up as a clock does";
    // Any rate serves to find the columns.
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

impl fmt::Display for Proposal {
    /// Writes lines that the user can paste into the options, each with its reason.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (title, lines) in [("columns", &self.columns), ("units", &self.units)] {
            if lines.is_empty() {
                continue;
            }
            writeln!(f, "{title}:")?;
            let width = lines.iter().map(|line| line.key.len() + line.value.len()).max().unwrap_or(0);
            for Proposed { key, value, reason } in lines {
                let gap = " ".repeat(width - key.len() - value.len());
                writeln!(f, "  {key}: {value}{gap}  # {reason}")?;
            }
        }
        Ok(())
    }
}

/// The column names of a pattern, and their text in the options. The text is a list of headers if some joint names in the headers
/// differ in case from the coordinates; otherwise it is the pattern.
fn given(table: &Table, coordinates: &[String], pattern: &str, columns: &[usize]) -> (NamePattern, String) {
    let headers: Vec<String> = columns.iter().map(|&c| table.header[c].clone()).collect();
    let is_as_written = |(header, name): (&String, &String)| {
        !pattern.contains("{joint}") || *header == pattern.replace("{joint}", name)
    };
    match headers.iter().zip(coordinates).all(is_as_written) {
        true => (NamePattern::Pattern(pattern.into()), quoted(pattern)),
        false => {
            let each: Vec<String> = headers.iter().map(|header| quoted(header)).collect();
            (NamePattern::Each(headers), format!("[{}]", each.join(", ")))
        }
    }
}

/// Words that name a joint but no quantity.
const JOINT_WORDS: &str = "j a axis axes joint joints achse gelenk eje articulacion 关节 軸 関節";

/// Proposes columns if their headers have no known word. Positions are columns whose derivatives are in other columns, or
/// columns with joint names only. Returns whether positions were found.
fn by_values(
    (table, coordinates): (&Table, &[String]),
    clock: Option<(usize, f64)>,
    patterns: &[(String, Vec<usize>)],
    proposal: &mut Proposal,
    names: &mut ColumnNames,
) -> bool {
    let is_joint = |pattern: &str| {
        let own = words(&pattern.replace("{joint}", " "));
        !own.is_empty() && own.iter().all(|word| JOINT_WORDS.split_whitespace().any(|joint| joint == word))
    };
    if let Some((pattern, columns)) = patterns.iter().find(|(pattern, _)| is_joint(pattern)) {
        let (given, value) = given(table, coordinates, pattern, columns);
        let reason = "named by the joints alone: positions, unless you know better".into();
        proposal.columns.push(Proposed { key: "position", value, reason });
        names.position = Some(given);
        return true;
    }
    let Some(found) = relations(table, clock.map(|clock| clock.0), coordinates.len()) else { return false };
    let Relations { positions, velocities, others } = found;
    let mut propose = |quantity: Quantity, columns: &[usize], reason: &str| {
        let headers: Vec<String> = columns.iter().map(|&c| table.header[c].clone()).collect();
        let each: Vec<String> = headers.iter().map(|header| quoted(header)).collect();
        let value = format!("[{}]", each.join(", "));
        proposal.columns.push(Proposed { key: key(quantity), value, reason: reason.into() });
        *names_of(names, quantity) = Some(NamePattern::Each(headers));
        if let Some((unit, reason)) = unit(table, columns, quantity, clock, factor_of(names)) {
            proposal.units.push(Proposed { key: key(quantity), value: quoted(&unit), reason });
            set_unit(names, quantity, unit);
        }
    };
    propose(Quantity::Position, &positions, "other columns are their derivatives");
    propose(Quantity::Velocity, &velocities, "the derivatives of the positions");
    if let Some(others) = others {
        propose(Quantity::Torque, &others, "the other columns, one per joint: torques, unless you know better");
    }
    true
}

/// Proposes the goals of position servos, if the table has neither torques nor currents.
fn goals(
    (table, coordinates): (&Table, &[String]),
    patterns: &[(String, Vec<usize>)],
    proposal: &mut Proposal,
    names: &mut ColumnNames,
) {
    let of_others =
        |word: &String| WORDS[1..].iter().any(|(_, words)| words.contains(&word.as_str())) || word == "error";
    let score = |pattern: &str| {
        let own = words(&pattern.replace("{joint}", " "));
        let rank = GOALS.split_whitespace().position(|word| own.iter().any(|own| own == word))?;
        (!own.iter().any(of_others)).then_some((rank, pattern.len()))
    };
    let best = patterns.iter().filter(|(p, _)| score(p).is_some()).min_by_key(|(p, _)| score(p));
    let Some((pattern, columns)) = best else { return };
    let (first, last) = (&table.header[columns[0]], &table.header[columns[columns.len() - 1]]);
    let (given, value) = given(table, coordinates, pattern, columns);
    proposal.columns.push(Proposed {
        key: "goal",
        value,
        reason: format!(
            "{first} .. {last}: one per joint, named like commands of a servo; there is no torque and no current, and its \
             error is a torque up to the gain of the servo"
        ),
    });
    names.goal = Some(given);
    // Goals have the unit of the positions, unless the ranges of the values indicate another unit.
    let of_positions = names.units.position.clone().unwrap_or_else(|| "rad".into());
    let of_goals = unit(table, columns, Quantity::Position, None, 1.0).map_or_else(|| "rad".into(), |unit| unit.0);
    if of_goals != of_positions {
        let reason = format!("they span other numbers than the positions, which are in {of_positions}");
        proposal.units.push(Proposed { key: "goal", value: quoted(&of_goals), reason });
        names.units.goal = Some(of_goals);
    }
}

fn key(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Time => "time",
        Quantity::Position => "position",
        Quantity::Velocity => "velocity",
        Quantity::Acceleration => "acceleration",
        Quantity::Torque => "torque",
        Quantity::Current => "current",
        Quantity::Goal => "goal",
    }
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

fn names_of(names: &mut ColumnNames, quantity: Quantity) -> &mut Option<NamePattern> {
    match quantity {
        Quantity::Velocity => &mut names.velocity,
        Quantity::Acceleration => &mut names.acceleration,
        Quantity::Torque => &mut names.torque,
        Quantity::Current => &mut names.current,
        Quantity::Goal => &mut names.goal,
        _ => &mut names.position,
    }
}

fn set_unit(names: &mut ColumnNames, quantity: Quantity, unit: String) {
    let place = match quantity {
        Quantity::Time => &mut names.units.time,
        Quantity::Position => &mut names.units.position,
        Quantity::Velocity => &mut names.units.velocity,
        Quantity::Acceleration => &mut names.units.acceleration,
        Quantity::Torque => &mut names.units.torque,
        Quantity::Current => &mut names.units.current,
        Quantity::Goal => &mut names.units.goal,
    };
    *place = Some(unit);
}

/// The words of a header, in lower case.
fn words(header: &str) -> Vec<String> {
    let lower = [header.to_lowercase(), with_underscores(header)];
    let of = |text: &String| -> Vec<String> {
        text.split(|c: char| !c.is_alphabetic()).filter(|word| !word.is_empty()).map(str::to_string).collect()
    };
    lower.iter().flat_map(of).collect()
}

/// The rank of a pattern for the words of a quantity; the smallest rank is the best. `None` if no word matches.
fn score(pattern: &str, quantity: Quantity, wanted: &[&str]) -> Option<(usize, usize)> {
    let own = words(&pattern.replace("{joint}", " "));
    if own.iter().any(|word| OTHERS.split_whitespace().any(|other| other == word)) {
        return None;
    }
    // Words of positions such as `state` and `actual` also stand in headers of velocities and torques: `motor_state[0].dq`.
    let is_of_others = |(_, words): &(Quantity, &[&str])| own.iter().any(|own| words.contains(&own.as_str()));
    let others = WORDS.iter().filter(|(other, _)| quantity == Quantity::Position && *other != quantity);
    if others.into_iter().any(is_of_others) {
        return None;
    }
    let rank = wanted.iter().position(|word| own.iter().any(|own| own == word))?;
    Some((rank, pattern.len()))
}

/// Header patterns that occur once for each joint, each with its columns in the order of the joints.
fn patterns(table: &Table, coordinates: &[String]) -> Vec<(String, Vec<usize>)> {
    let mut numbered: BTreeMap<String, BTreeMap<usize, usize>> = BTreeMap::new();
    let mut named: BTreeMap<String, BTreeMap<usize, usize>> = BTreeMap::new();
    for (column, header) in table.header.iter().enumerate() {
        for (start, end, number) in digits(header) {
            let pattern = format!("{}{{}}{}", &header[..start], &header[end..]);
            numbered.entry(pattern).or_default().insert(number, column);
        }
        for (k, name) in coordinates.iter().enumerate() {
            // Joint names often start with a capital letter, so case is ignored. Only ASCII letters are converted, because byte
            // positions must not change.
            let at = header.to_ascii_lowercase().find(&name.to_ascii_lowercase());
            if let Some(start) = at {
                let pattern = format!("{}{{joint}}{}", &header[..start], &header[start + name.len()..]);
                named.entry(pattern).or_default().insert(k, column);
            }
        }
    }
    let n = coordinates.len();
    let whole = |(pattern, columns): (String, BTreeMap<usize, usize>), first: usize| {
        let all: Option<Vec<usize>> = (first..first + n).map(|k| columns.get(&k).copied()).collect();
        all.map(|columns| (pattern, columns))
    };
    let mut found: Vec<(String, Vec<usize>)> = named.into_iter().filter_map(|entry| whole(entry, 0)).collect();
    for entry in numbered {
        // If a file has a column with the number 0, its numbers start at 0.
        let first = usize::from(!entry.1.contains_key(&0));
        found.extend(whole(entry, first));
    }
    found
}

/// The numbers in a header: start, end and value.
fn digits(header: &str) -> Vec<(usize, usize, usize)> {
    let bytes = header.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let end = (at..bytes.len()).find(|&k| !bytes[k].is_ascii_digit()).unwrap_or(bytes.len());
        if end > at && end - at <= 3 {
            found.extend(header[at..end].parse().ok().map(|number| (at, end, number)));
        }
        at = end.max(at + 1);
    }
    found
}

/// Proposes the clock. Returns its column and the factor that converts it to s.
fn clock(
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
fn rises(x: &[f64]) -> bool {
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
fn clock_unit(clock: &[f64], proposal: &mut Proposal, names: &mut ColumnNames) -> f64 {
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

/// The unit of the columns of a quantity, with the reason. `None` if it is the SI unit or the unit in the header.
fn unit(
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
            format!("they span {} and would be {:.0} turns in rad", short(widest), widest / std::f64::consts::TAU),
        )),
        Quantity::Velocity => {
            let ratio = slope_ratio(table, columns, clock?, position_factor)?;
            let (unit, _) = VELOCITY_UNITS.into_iter().find(|(_, k)| (ratio / k - 1.0).abs() < RATIO_TOLERANCE)?;
            (unit != "rad/s")
                .then(|| (unit.into(), format!("they are {} times the slope of the position", short(ratio))))
        }
        _ => None,
    }
}

/// Ratio of the velocity of the first joint to the derivative of its position in rad/s. `None` if no position fits.
fn slope_ratio(table: &Table, velocity: &[usize], (clock, second): (usize, f64), to_si: f64) -> Option<f64> {
    let t = &table.columns[clock];
    // The position of the same joint is the column whose derivative has the largest correlation with the velocity.
    let fit = |q: &[f64], v: &[f64]| {
        let (mut vs, mut ss, mut vv) = (0.0, 0.0, 0.0);
        for k in 1..t.len().saturating_sub(1) {
            let slope = to_si * (q[k + 1] - q[k - 1]) / (second * (t[k + 1] - t[k - 1]));
            if slope.is_finite() && v[k].is_finite() {
                (vs, ss, vv) = (vs + v[k] * slope, ss + slope * slope, vv + v[k] * v[k]);
            }
        }
        (vs / ss, vs * vs / (ss * vv))
    };
    let v = &table.columns[velocity[0]];
    let others = (0..table.columns.len()).filter(|c| *c != clock && !velocity.contains(c));
    let best = others.map(|c| fit(&table.columns[c], v)).filter(|(_, r)| *r > MIN_SQUARED_CORRELATION);
    best.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(ratio, _)| ratio)
}

/// The median of the numbers.
fn middle(mut numbers: Vec<f64>) -> f64 {
    let middle = numbers.len() / 2;
    if numbers.is_empty() {
        return f64::NAN;
    }
    *numbers.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// A number with four significant digits.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A table of two oscillating joints. `scales`: factors of time, position, velocity and torque.
    fn table(header: &str, scales: [f64; 4]) -> Table {
        let [time, position, velocity, torque] = scales;
        let header: Vec<String> = header.split(',').map(Into::into).collect();
        let at = |k: usize| k as f64 * 0.005;
        let series = |f: &dyn Fn(f64) -> f64| (0..400).map(|k| f(at(k))).collect::<Vec<f64>>();
        let columns = vec![
            series(&|t| time * t),
            series(&|t| position * (3.0 * t).sin()),
            series(&|t| position * (2.0 * t).cos()),
            series(&|t| velocity * 3.0 * (3.0 * t).cos()),
            series(&|t| velocity * -2.0 * (2.0 * t).sin()),
            series(&|t| torque * (3.0 * t).sin()),
            series(&|t| torque * (2.0 * t).sin()),
        ];
        Table { file: "log.csv".into(), texts: vec![None; header.len()], columns, header, ..Table::default() }
    }

    fn joints() -> [String; 2] {
        ["shoulder".to_string(), "elbow".to_string()]
    }

    #[test]
    fn what_is_found_by_name_needs_no_words() {
        let proposal = propose(&table("t,q1,q2,dq1,dq2,tau1,tau2", [1.0; 4]), &joints(), None);
        assert!(proposal.columns.is_empty() && proposal.mapping.is_some(), "{proposal}");
    }

    /// Without a clock, the rate is proposed at which the velocities are the derivatives of the positions. The printed proposal
    /// can be read again. If the velocities fit to no usual rate, the rate is reported as missing.
    #[test]
    fn the_rate_of_a_log_without_a_clock_is_proposed() {
        let without_clock = |header: &str, scales: [f64; 4]| {
            let mut table = table(&format!("t,{header}"), scales);
            table.columns.remove(0);
            table.texts.remove(0);
            table.header.remove(0);
            // In the table the torques equal the positions, so the velocities would be their derivatives too. They are replaced
            // by other signals.
            for (column, f) in [(4, 13.0), (5, 17.0)] {
                table.columns[column] = (0..400).map(|k| (f * 0.005 * f64::from(k)).cos()).collect();
            }
            propose(&table, &joints(), None)
        };
        let degrees = 180.0 / std::f64::consts::PI;
        let named = "q1,q2,dq1,dq2,tau1,tau2";
        let found = without_clock(named, [1.0; 4]);
        assert!(found.to_string().contains("rate: 200 "), "{found}");
        assert_eq!(found.mapping.unwrap().rate, Some(200.0));
        let in_degrees = without_clock(named, [1.0, 1.0, degrees, 1.0]);
        assert!(in_degrees.to_string().contains("velocity: \"deg/s\""), "{in_degrees}");
        assert!((in_degrees.mapping.unwrap().velocity.unwrap()[0].factor * degrees - 1.0).abs() < 1e-12);
        let unnamed = without_clock("c1,c2,c3,c4,c5,c6", [1.0; 4]).to_string();
        for line in ["rate: 200 ", "position: [\"c1\", \"c2\"]", "torque: [\"c5\", \"c6\"]"] {
            assert!(unnamed.contains(line), "{line}\n{unnamed}");
        }
        let given = propose(&table("x,a1,a2,dq1,dq2,tau1,tau2", [0.0, 1.0, 1.0, 1.0]), &joints(), Some(125.0));
        assert!(given.to_string().contains("rate: 125 "), "{given}");
        for scale in [1.37, -1.0] {
            let found = without_clock(named, [1.0, 1.0, scale, 1.0]);
            assert!(found.mapping.is_none() && found.missing[0].contains("[rate=HZ]"), "{found} {:?}", found.missing);
        }
    }

    /// If a header has no unit and the values do not fit to the SI unit, degrees are proposed. A unit in a header is not
    /// changed.
    #[test]
    fn degrees_without_a_unit_in_the_header_are_proposed() {
        let degrees = 180.0 / std::f64::consts::PI;
        let found = propose(&table("t,q1,q2,dq1,dq2,tau1,tau2", [1.0, degrees, degrees, 1.0]), &joints(), None);
        let shown = found.to_string();
        assert!(shown.contains("position: \"deg\"") && shown.contains("velocity: \"deg/s\""), "{shown}");
        let said = propose(&table("t,q1_rad,q2_rad,dq1,dq2,tau1,tau2", [1.0, degrees, degrees, 1.0]), &joints(), None);
        assert!(!said.to_string().contains("position:"), "{said}");
    }

    /// By its name, `A1` could also be an acceleration. Since it is used as a position, it is not used a second time.
    #[test]
    fn names_of_joints_alone_are_positions_and_nothing_else() {
        let proposal = propose(&table("t,A1,A2,dq1,dq2,tau1,tau2", [1.0; 4]), &joints(), None);
        assert_eq!(
            (proposal.columns[1].key, proposal.columns[1].value.as_str()),
            ("position", "\"A{}\""),
            "{proposal}"
        );
        let mapping = proposal.mapping.unwrap();
        assert!(mapping.acceleration.is_none() && mapping.velocity.is_some(), "{mapping}");
    }

    #[test]
    fn words_and_numbers_make_a_proposal_that_is_read() {
        let trace = "Takt,A1 Ist,A2 Ist,A1 Geschwindigkeit,A2 Geschwindigkeit,A1 Moment,A2 Moment";
        let degrees = 180.0 / std::f64::consts::PI;
        let proposal = propose(&table(trace, [1e3, degrees, degrees, 1.0]), &joints(), None);
        let shown = proposal.to_string();
        for line in [
            "time: \"Takt\"",
            "position: \"A{} Ist\"",
            "velocity: \"A{} Geschwindigkeit\"",
            "torque: \"A{} Moment\"",
            "time: ms",
            "position: \"deg\"",
            "velocity: \"deg/s\"",
        ] {
            assert!(shown.contains(line), "{line}\n{shown}");
        }
        let mapping = proposal.mapping.unwrap();
        assert!((mapping.position[0].factor * degrees - 1.0).abs() < 1e-12);
        // The columns are found by joint names; set points are ignored.
        let named = "stamp,shoulder_state,elbow_state,shoulder_cmd_state,elbow_cmd_state,shoulder load,elbow load";
        let shown = propose(&table(named, [1.0; 4]), &joints(), None).to_string();
        assert!(shown.contains("position: \"{joint}_state\"") && shown.contains("torque: \"{joint} load\""), "{shown}");
    }

    #[test]
    fn joints_in_other_letters_are_found() {
        let trace = "Sample time,Shoulder joint angle,Elbow joint angle,Shoulder speed,Elbow speed,Shoulder drive load,Elbow drive load";
        let proposal = propose(&table(trace, [1.0; 4]), &joints(), None);
        let shown = proposal.to_string();
        assert!(shown.contains("position: [\"Shoulder joint angle\", \"Elbow joint angle\"]"), "{shown}");
        assert!(proposal.mapping.is_some() && shown.contains("torque: [\"Shoulder drive load\""), "{shown}");
    }

    /// A counter of rows, and stamps that stand still in most rows, are no clock: the velocities show the rate.
    #[test]
    fn counters_and_repeated_stamps_are_no_clock() {
        let of = |header: &str, clock: &dyn Fn(usize) -> f64| {
            let mut table = table(header, [1.0; 4]);
            table.columns[0] = (0..400).map(clock).collect();
            propose(&table, &joints(), None)
        };
        let named = ",q1,q2,dq1,dq2,tau1,tau2";
        for found in [
            of(&format!("cycle{named}"), &|row| row as f64 + 7.0),
            // A counter with lost rows.
            of(&format!("cycle{named}"), &|row| (row + row / 100) as f64),
            of(&format!("t{named}"), &|row| 0.02 * (row / 4) as f64),
        ] {
            assert_eq!(found.mapping.as_ref().and_then(|mapping| mapping.rate), Some(200.0), "{found}");
        }
        let counted = of(&format!("time{named}"), &|row| 5.0 * row as f64);
        assert_eq!(counted.mapping.as_ref().map(|mapping| mapping.time.factor), Some(1e-3), "{counted}");
        // A slow log in s, and a clock in ms of 1 kHz.
        let slow = of(&format!("time{named}"), &|row| 0.98 * row as f64);
        assert_eq!(slow.mapping.as_ref().map(|mapping| mapping.time.factor), Some(1.0), "{slow}");
        let fast = of(&format!("time{named}"), &|row| row as f64);
        assert_eq!(fast.mapping.as_ref().map(|mapping| mapping.time.factor), Some(1e-3), "{fast}");
        // A rate that the user gives counts before a clock.
        let clocked = table(&format!("t{named}"), [1.0; 4]);
        let given = propose(&clocked, &joints(), Some(125.0));
        assert_eq!(given.mapping.as_ref().and_then(|mapping| mapping.rate), Some(125.0), "{given}");
        assert!(given.to_string().contains("rate: 125 "), "{given}");
    }

    #[test]
    fn the_finer_clock_is_taken() {
        let mut table = table("stamp_s,a_state,b_state,a_vel,b_vel,a_load,b_load", [1.0; 4]);
        let fine: Vec<f64> =
            table.columns[0].iter().enumerate().map(|(k, t)| if k < 200 { *t } else { *t - 1.0 }).collect();
        table.columns[0].iter_mut().for_each(|t| *t = t.floor());
        table.header.extend(["timestamp_fine".to_string(), "row".to_string()]);
        table.columns.extend([fine, (0..400).map(f64::from).collect()]);
        table.texts.extend([None, None]);
        let shown = propose(&table, &["a".to_string(), "b".to_string()], None).to_string();
        assert!(shown.contains("time: \"timestamp_fine\"") && shown.contains("by 0.005 a row"), "{shown}");
    }

    #[test]
    fn goals_of_servos_are_proposed_where_no_torque_is() {
        let header = "timestamp,observation.state_1,observation.state_2,speed_1,speed_2,action_1,action_2";
        let shown = |table: &Table| propose(table, &joints(), None).to_string();
        let degrees = 180.0 / std::f64::consts::PI;
        let in_degrees = shown(&table(header, [1.0, degrees, 1.0, degrees]));
        for line in ["position: \"observation.state_{}\"", "goal: \"action_{}\"", "position: \"deg\""] {
            assert!(in_degrees.contains(line), "{line}\n{in_degrees}");
        }
        assert!(!in_degrees.contains("goal: \"rad\""), "{in_degrees}");
        let in_rad = shown(&table(header, [1.0, degrees, 1.0, 1.0]));
        assert!(in_rad.contains("goal: \"rad\""), "{in_rad}");
        let with_torques = "timestamp,a_state_1,a_state_2,load_1,load_2,action_1,action_2";
        let shown = shown(&table(with_torques, [1.0; 4]));
        assert!(!shown.contains("goal") && shown.contains("torque: \"load_{}\""), "{shown}");
    }

    #[test]
    fn what_cannot_be_told_is_said() {
        let proposal = propose(&table("t,a,b,c,d,e,f", [1.0; 4]), &joints(), None);
        assert!(proposal.mapping.is_none());
        let said = proposal.missing.join("; ");
        assert!(said.contains("named like positions") && said.contains("torques or currents"), "{said}");
    }
}
