//! The possible meanings of a column's header.
//!
//! A header is stem, joint and unit in one of the forms `q1`, `q_1`, `q[1]`, `q_elbow`, `elbow.position`, `q1_deg`, `q_deg1`. The
//! stems are the words of drivers and tools for measured quantities. Set points (`target_`, `_ref`, `_des`) are not among them
//! and are used only when the user names them.

use crate::Error;
use crate::table::Table;

/// A measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Time, s.
    Time,
    /// Position, rad (m).
    Position,
    /// Velocity, rad/s (m/s).
    Velocity,
    /// Acceleration, rad/s^2 (m/s^2).
    Acceleration,
    /// Torque, N m (N).
    Torque,
    /// Current, A.
    Current,
    /// Commanded position of a position servo, rad (m).
    Goal,
}

use Quantity::*;

/// A unit in headers, and its factor to SI.
pub(crate) type Unit = (&'static str, f64);

type QuantityWords = (Quantity, &'static str, &'static [Unit]);

/// Units of positions.
const POSITION_UNITS: &[Unit] = &[
    ("rad", 1.0),
    ("radians", 1.0),
    ("deg", std::f64::consts::PI / 180.0),
    ("degrees", std::f64::consts::PI / 180.0),
    ("°", std::f64::consts::PI / 180.0),
    ("grad", std::f64::consts::PI / 180.0),
    ("m", 1.0),
    ("mm", 1e-3),
];

/// Stems, separated by blanks, then units with the factor to SI. The first unit is the default.
const QUANTITY_WORDS: [QuantityWords; 7] = [
    (
        Time,
        "t time timestamp stamp clock timestamps times sec secs seconds zeit",
        &[("s", 1.0), ("sec", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)],
    ),
    (Position, "q pos position positions angle actual_q joint_position joint_pos joint_angle qm theta", POSITION_UNITS),
    // A set point is used only where the user names it, so it has no stems.
    (Goal, "", POSITION_UNITS),
    (
        Velocity,
        "dq qd v vel velocity velocities qdot q_dot actual_qd joint_velocity joint_vel dqm speed",
        &[
            ("rad_s", 1.0),
            ("radps", 1.0),
            ("rad/s", 1.0),
            ("deg_s", std::f64::consts::PI / 180.0),
            ("degps", std::f64::consts::PI / 180.0),
            ("deg/s", std::f64::consts::PI / 180.0),
            ("°/s", std::f64::consts::PI / 180.0),
            ("rpm", std::f64::consts::PI / 30.0),
            ("m_s", 1.0),
            ("m/s", 1.0),
            ("mm_s", 1e-3),
        ],
    ),
    (
        Acceleration,
        "ddq qdd a acc acceleration accelerations qddot q_ddot actual_qdd",
        &[
            ("rad_s2", 1.0),
            ("radps2", 1.0),
            ("rad/s^2", 1.0),
            ("deg_s2", std::f64::consts::PI / 180.0),
            ("degps2", std::f64::consts::PI / 180.0),
            ("deg/s^2", std::f64::consts::PI / 180.0),
            ("°/s^2", std::f64::consts::PI / 180.0),
        ],
    ),
    (
        Torque,
        "tau torque torques effort efforts trq joint_torque joint_effort actual_torque taum tauj",
        &[
            ("nm", 1.0),
            ("n_m", 1.0),
            ("n.m", 1.0),
            ("n*m", 1.0),
            ("n", 1.0),
            ("n m", 1.0),
            ("ncm", 1e-2),
            ("n cm", 1e-2),
            ("mnm", 1e-3),
            ("nmm", 1e-3),
            ("n mm", 1e-3),
            ("knm", 1e3),
            ("permille", 1.0),
            ("percent", 1.0),
        ],
    ),
    (
        Current,
        "i current currents cur actual_current motor_current joint_current iq",
        &[("a", 1.0), ("ma", 1e-3), ("permille", 1.0), ("percent", 1.0)],
    ),
];

/// The units of a quantity, the default first.
pub(crate) fn units(quantity: Quantity) -> &'static [Unit] {
    QUANTITY_WORDS.iter().find(|w| w.0 == quantity).map_or(&[], |w| w.2)
}

/// The usual notation of a unit in headers.
pub(crate) fn written(unit: &str) -> &str {
    match unit {
        "sec" => "s",
        "radians" => "rad",
        "degrees" | "°" | "grad" => "deg",
        "rad_s" | "radps" => "rad/s",
        "deg_s" | "degps" | "°/s" => "deg/s",
        "m_s" => "m/s",
        "mm_s" => "mm/s",
        "rad_s2" | "radps2" => "rad/s^2",
        "deg_s2" | "degps2" | "°/s^2" => "deg/s^2",
        "nm" | "n_m" | "n.m" | "n*m" | "n m" => "N m",
        "n" => "N",
        "ncm" | "n cm" => "N cm",
        "mnm" | "nmm" | "n mm" => "mN m",
        "knm" => "kN m",
        "a" => "A",
        "ma" => "mA",
        other => other,
    }
}

/// The unit of a sliding joint where the header of a turning one would have `unit`; `None` where `unit` is of neither a length
/// nor a force. The default unit of a turning joint stands for a header without a unit.
pub(crate) fn of_sliding(unit: &str) -> Option<&str> {
    // A scale from the user is already in the SI unit of the joint.
    if unit.contains('(') || unit.starts_with("int") {
        return Some(unit);
    }
    match written(unit) {
        "rad" => Some("m"),
        "rad/s" => Some("m/s"),
        "rad/s^2" => Some("m/s^2"),
        "N m" => Some("N"),
        "m" | "mm" | "m/s" | "mm/s" | "m/s^2" | "N" | "A" | "mA" | "permille" | "percent" => Some(unit),
        _ => None,
    }
}

/// A possible meaning of a header.
pub(crate) struct Reading {
    pub column: usize,
    pub quantity: Quantity,
    pub joint: Designator,
    pub unit: Unit,
}

/// The joint in a header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Designator {
    None,
    /// A number, counted from 0 or from 1; the other headers of the quantity decide which.
    Number(usize),
    Coordinate(usize),
}

/// The meanings of every header of a table; a header with two quantities is refused.
pub(crate) fn readings(table: &Table, coordinates: &[String]) -> Result<Vec<Reading>, Error> {
    let lower: Vec<String> = coordinates.iter().map(|c| plain(&c.to_lowercase())).collect();
    let names = joint_names(table, &lower);
    let mut all = Vec::new();
    for (column, header) in table.header.iter().enumerate() {
        let mut found: Vec<Reading> = Vec::new();
        let header_lower = header.to_lowercase();
        let mut readings = parse(&header_lower, &lower);
        if readings.is_empty() {
            readings = parse(&unqualified(&header_lower), &lower);
        }
        for (quantity, joint, unit) in readings {
            let joint = match joint {
                Designator::Number(i) => names.iter().find(|n| n.0 == i).map_or(joint, |n| Designator::Coordinate(n.1)),
                _ => joint,
            };
            if !found.iter().any(|r| r.quantity == quantity && r.joint == joint) {
                found.push(Reading { column, quantity, joint, unit });
            }
        }
        if let [a, b, ..] = found.as_slice() {
            let (a, b) = (a.quantity, b.quantity);
            let message = format!("column `{header}` may be a {a:?} or a {b:?}; name the columns to use");
            return Err(Error::at(&table.file, 1, message));
        }
        all.append(&mut found);
    }
    Ok(all)
}

/// Words that mark a quantity as measured, or name a group that it belongs to.
const QUALIFIER_WORDS: &str = "actual act meas measured msr real present sensor robot field jointstate joint_states \
    joint_state";

/// A header in lower case without its qualifiers: `joint_states.elbow.position`, `actual_joint_pos_1`, `q_meas_1`.
fn unqualified(header: &str) -> String {
    let mut header = header.trim_start_matches(['%', '#', '/', '_', ' ']).to_string();
    for word in QUALIFIER_WORDS.split_whitespace() {
        if let Some(at) = header.find(word) {
            let (before, after) = (&header[..at], &header[at + word.len()..]);
            let apart = |c: Option<char>| c.is_none_or(|c| !c.is_ascii_alphanumeric());
            if apart(before.chars().next_back()) && apart(after.chars().next()) {
                let separators = ['_', '.', '/', '-', ':', ' '];
                let (before, after) = (before.trim_end_matches(separators), after.trim_start_matches(separators));
                let between = if before.is_empty() || after.is_empty() { "" } else { "_" };
                header = format!("{before}{between}{after}");
            }
        }
    }
    header
}

/// Joint numbers and their coordinates, as (number, coordinate), from columns `name0`, `name1`, .. (`field.name0`) with the names
/// of the joints in their cells.
fn joint_names(table: &Table, coordinates: &[String]) -> Vec<(usize, usize)> {
    let name = |(header, text): (&String, &Option<(usize, String)>)| {
        let header = unqualified(&header.to_lowercase());
        let number = header.strip_prefix("name")?.trim_matches(['_', '[', ']']).parse().ok()?;
        let text = text.as_ref()?.1.to_lowercase();
        Some((number, coordinates.iter().position(|c| *c == plain(&text))?))
    };
    table.header.iter().zip(&table.texts).filter_map(name).collect()
}

/// Brackets and blanks as underscores.
fn plain(text: &str) -> String {
    text.replace(['[', ']', '(', ')', '{', '}', ' '], "_")
}

/// All meanings of a header in lower case.
fn parse(header: &str, coordinates: &[String]) -> Vec<(Quantity, Designator, Unit)> {
    let header = plain(header);
    let header = header.trim_matches('_');
    let mut out = Vec::new();
    for (quantity, stems, units) in QUANTITY_WORDS {
        for (rest, unit) in without_unit(header, units) {
            for stem in stems.split_whitespace() {
                if let Some(joint) = joint_next_to(rest, stem, quantity, units, coordinates) {
                    out.push((quantity, joint.0, joint.1.unwrap_or(unit)));
                }
            }
        }
    }
    out
}

/// The header with the default unit, and the header without each unit that it ends in.
fn without_unit<'a>(header: &'a str, units: &[Unit]) -> Vec<(&'a str, Unit)> {
    let mut out = vec![(header, units[0])];
    for unit in units {
        if let Some(rest) = header.strip_suffix(unit.0).and_then(|r| r.strip_suffix(['_', '.', '-'])) {
            out.push((rest.trim_end_matches('_'), *unit));
        }
    }
    out
}

/// Reads the text next to the stem: nothing, a joint, or a unit and a joint.
fn joint_next_to(
    rest: &str,
    stem: &str,
    quantity: Quantity,
    units: &[Unit],
    coordinates: &[String],
) -> Option<(Designator, Option<Unit>)> {
    let separators = ['_', '.', '/', '-', ':'];
    let joint = |text: &str| -> Option<Designator> {
        let text = text.trim_matches(separators);
        if let Some(k) = coordinates.iter().position(|c| c == text) {
            return Some(Designator::Coordinate(k));
        }
        let digits = text.strip_prefix("joint").or(text.strip_prefix('j')).unwrap_or(text);
        let digits = digits.trim_matches(separators);
        let small = !digits.is_empty() && digits.len() <= 3 && digits.bytes().all(|b| b.is_ascii_digit());
        small.then(|| digits.parse().ok().map(Designator::Number))?
    };
    if quantity == Time {
        return (rest == stem).then_some((Designator::None, None));
    }
    if let Some(after) = rest.strip_prefix(stem) {
        if let Some(j) = joint(after) {
            // `q` before the name of a coordinate needs a separator: `qelbow` is another word.
            let separated = matches!(j, Designator::Number(_)) || after.starts_with(separators);
            return separated.then_some((j, None));
        }
        for unit in units {
            let inner = after.trim_start_matches(separators).strip_prefix(unit.0);
            if let Some(j) = inner.filter(|_| after.starts_with(separators)).and_then(joint) {
                return Some((j, Some(*unit)));
            }
        }
    }
    let before = rest.strip_suffix(stem).and_then(|b| b.strip_suffix(separators))?;
    joint(before).map(|j| (j, None))
}
