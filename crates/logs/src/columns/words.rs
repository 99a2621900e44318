//! Determines the possible meanings of a column header: quantity, joint and unit.
//!
//! A header has a stem, a joint and a unit, in one of the forms `q1`, `q_1`, `q[1]`, `q_elbow`, `elbow.position`, `q1_deg`,
//! `q_deg1`. The stems are words of drivers and tools for measured quantities. Set points (`target_`, `_ref`, `_des`) are not
//! stems; they are used only if the user names them.

use std::sync::LazyLock;

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

/// A unit as written in headers, and its factor to the SI unit.
pub(crate) type Unit = (&'static str, f64);

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

/// For each quantity, its units with their factors to the SI unit. The first unit is the default.
const UNITS: [(Quantity, &[Unit]); 7] = [
    (Time, &[("s", 1.0), ("sec", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)]),
    (Position, POSITION_UNITS),
    (Goal, POSITION_UNITS),
    (
        Velocity,
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
    (Current, &[("a", 1.0), ("ma", 1e-3), ("permille", 1.0), ("percent", 1.0)]),
];

/// The stems in `header_words.txt`, in the order of this file. Set points have no stems, because they are used only if the user
/// names them.
static WORDS: LazyLock<Vec<(Quantity, &str)>> = LazyLock::new(|| {
    let of = |line: &'static str| {
        let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
        let quantity = match words.next() {
            Some("time") => Time,
            Some("position") => Position,
            Some("velocity") => Velocity,
            Some("acceleration") => Acceleration,
            Some("torque") => Torque,
            Some("current") => Current,
            _ => return Vec::new(),
        };
        words.map(|word| (quantity, word)).collect()
    };
    include_str!("header_words.txt").lines().flat_map(of).collect()
});

/// The units of a quantity, the default first.
pub(crate) fn units(quantity: Quantity) -> &'static [Unit] {
    UNITS.iter().find(|of| of.0 == quantity).map_or(&[], |of| of.1)
}

/// The usual spelling of a unit in headers.
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

/// The unit of a sliding joint that corresponds to the unit of a revolute joint. `None` if a sliding joint cannot have such a
/// unit. A header without a unit gets the default unit of a revolute joint, so this unit is converted to the default of a
/// sliding joint.
pub(crate) fn of_sliding(unit: &str) -> Option<&str> {
    // A scale from the user already converts to the SI unit of the joint.
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

/// The joint that a header names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Designator {
    None,
    /// A number that is counted from 0 or from 1; all headers of the quantity together determine which.
    Number(usize),
    Coordinate(usize),
}

/// The meanings of all headers of a table. Fails if a header can mean two quantities.
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
        if readings.is_empty() {
            readings = parse(&unqualified(&with_underscores(header)), &lower);
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
        // If a header contains the whole name of a joint, a number in this name does not count. For example, `q_J 1 [rad]`
        // belongs to the joint `J 1 [rad]`.
        if found.iter().any(|r| matches!(r.joint, Designator::Coordinate(_))) {
            found.retain(|r| !matches!(r.joint, Designator::Number(_)));
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

/// Words that mark a quantity as measured, or that name a group of signals. They do not change the meaning.
const QUALIFIER_WORDS: &str = "actual act meas measured msr real present sensor robot field jointstate joint_states \
    joint_state";

/// A header without its qualifier words, for example `joint_states.elbow.position`, `actual_joint_pos_1`, `q_meas_1`. The input
/// is in lower case.
fn unqualified(header: &str) -> String {
    let mut header = header.trim_start_matches(['%', '#', '/', '_', '-', ' ']).to_string();
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

/// Converts `jointPosition1` to `joint_position1`: a capital letter after a small letter starts a new word.
pub(crate) fn with_underscores(header: &str) -> String {
    let mut words = String::new();
    for c in header.chars() {
        if c.is_uppercase() && words.ends_with(char::is_lowercase) {
            words.push('_');
        }
        words.extend(c.to_lowercase());
    }
    words
}

/// Pairs of joint number and coordinate, from columns `name0`, `name1`, .. (`field.name0`) that contain joint names.
fn joint_names(table: &Table, coordinates: &[String]) -> Vec<(usize, usize)> {
    let name = |(header, text): (&String, &Option<(usize, String)>)| {
        let header = unqualified(&header.to_lowercase());
        let number = header.strip_prefix("name")?.trim_matches(['_', '[', ']']).parse().ok()?;
        let text = text.as_ref()?.1.to_lowercase();
        Some((number, coordinates.iter().position(|c| *c == plain(&text))?))
    };
    table.header.iter().zip(&table.texts).filter_map(name).collect()
}

/// Replaces brackets and blanks by underscores.
fn plain(text: &str) -> String {
    text.replace(['[', ']', '(', ')', '{', '}', ' '], "_")
}

/// All meanings of a header in lower case.
fn parse(header: &str, coordinates: &[String]) -> Vec<(Quantity, Designator, Unit)> {
    let header = plain(header);
    let header = header.trim_matches('_');
    let mut out = Vec::new();
    for (quantity, units) in UNITS {
        for (rest, unit) in without_unit(header, units) {
            for (_, stem) in WORDS.iter().filter(|word| word.0 == quantity) {
                if let Some(joint) = joint_next_to(rest, stem, quantity, units, coordinates) {
                    out.push((quantity, joint.0, joint.1.unwrap_or(unit)));
                }
            }
        }
    }
    out
}

/// Whether a header can be the header of a clock.
pub fn is_clock(header: &str) -> bool {
    let header = header.to_lowercase();
    [parse(&header, &[]), parse(&unqualified(&header), &[])].concat().iter().any(|(quantity, ..)| *quantity == Time)
}

/// The possible forms of a header without its unit: the header itself with the default unit, and for each unit at its end the
/// text before this unit.
fn without_unit<'a>(header: &'a str, units: &[Unit]) -> Vec<(&'a str, Unit)> {
    let mut out = vec![(header, units[0])];
    for unit in units {
        if let Some(rest) = header.strip_suffix(unit.0).and_then(|r| r.strip_suffix(['_', '.', '-'])) {
            out.push((rest.trim_end_matches('_'), *unit));
        }
    }
    out
}

/// The unit at the end of a header or before its number (`i_mA_{}`), or the default unit of the quantity.
pub(crate) fn unit_at_end(header: &str, quantity: Quantity) -> Unit {
    let units = units(quantity);
    let header = header.to_lowercase();
    let header = header.trim_end_matches(['{', '}', '_', '.', '-']).trim_end_matches("{joint");
    // The longest unit counts: `_mnm` also ends with a unit of one letter.
    let named = without_unit(header.trim_end_matches(['_', '.', '-']), units).into_iter().skip(1);
    named.map(|(_, unit)| unit).max_by_key(|unit| unit.0.len()).unwrap_or(units[0])
}

/// Interprets the text after the stem: nothing, a joint, or a unit and a joint. `None` if it has another form.
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
        // A name may begin or end with separators itself: `/arm/j1` of ROS 1.
        let mut bare = coordinates.iter().enumerate().filter(|(_, c)| c.trim_matches(separators) == text);
        if let (Some((k, _)), None, false) = (bare.next(), bare.next(), text.is_empty()) {
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
            // Between `q` and the name of a coordinate, a separator is required: `qelbow` is another word.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn found(header: &str) -> Option<(Quantity, Designator)> {
        let table = Table { header: vec![header.into()], texts: vec![None], ..Table::default() };
        readings(&table, &["elbow".into(), "wrist".into()]).unwrap().first().map(|r| (r.quantity, r.joint))
    }

    /// Header names of drivers and data sets (header_words.txt) are recognised. Ambiguous headers and commanded signals are not.
    #[test]
    fn names_of_drivers_are_read() {
        let first = Designator::Number(1);
        for (header, quantity) in [
            ("joint_positions_1", Position),
            ("jointPositions1", Position),
            ("JointPosition1", Position),
            ("measuredJointPosition_1", Position),
            ("qpos_1", Position),
            ("angles_1", Position),
            ("measured_jp_1", Position),
            ("msr_jp_1", Position),
            ("joint_velocities_1", Velocity),
            ("measured_jv_1", Velocity),
            ("joint_torques_1", Torque),
            ("JointTorque1", Torque),
            ("joint_eff_1", Torque),
            ("torq_1", Torque),
            ("measured_jf_1", Torque),
            ("j1_eff", Torque),
        ] {
            assert_eq!(found(header), Some((quantity, first)), "{header}");
        }
        assert_eq!(found("elbowPosition"), Some((Position, Designator::Coordinate(0))));
        for header in ["u1", "J1", "joint1", "enc1", "qelbow", "target_q_1", "joint_positions_desired_1"] {
            assert_eq!(found(header), None, "{header}");
        }
    }

    /// Names that `simulate` writes are read again, also those that begin or end with separators.
    #[test]
    fn odd_names_of_joints_are_found() {
        let odd = ["/arm/j1", "x_", "__j__", "J 1 [rad]", "// \\1", "wrist/", "a\u{85}b"];
        let coordinates: Vec<String> = odd.iter().map(|name| name.to_string()).collect();
        for (k, name) in odd.iter().enumerate() {
            for (stem, quantity) in [("q_", Position), ("tau_", Torque), ("dq_", Velocity)] {
                let header = format!("{stem}{name}");
                let table = Table { header: vec![header.clone()], texts: vec![None], ..Table::default() };
                let found = readings(&table, &coordinates).unwrap_or_else(|e| panic!("{header}: {e}"));
                let found: Vec<_> = found.iter().map(|r| (r.quantity, r.joint)).collect();
                assert_eq!(found, [(quantity, Designator::Coordinate(k))], "{header}");
            }
        }
        // If a bare name fits two joints, it is assigned to neither of them.
        let table = Table { header: vec!["q_j".into()], texts: vec![None], ..Table::default() };
        assert_eq!(readings(&table, &["/j".into(), "j/".into()]).unwrap().len(), 0);
        assert_eq!(readings(&table, &["/j".into(), "j".into()]).unwrap()[0].joint, Designator::Coordinate(1));
    }

    #[test]
    fn every_line_of_the_table_has_a_quantity_and_a_source() {
        let lines = include_str!("header_words.txt").lines().filter(|line| !line.starts_with('#'));
        for line in lines {
            let (words, source) = line.split_once('#').unwrap_or_else(|| panic!("no source: {line}"));
            assert!(words.split_whitespace().count() > 1 && !source.trim().is_empty(), "{line}");
        }
        assert!(
            WORDS.len() > 60
                && [Time, Position, Velocity, Acceleration, Torque, Current]
                    .iter()
                    .all(|q| WORDS.iter().any(|w| w.0 == *q))
        );
    }
}
