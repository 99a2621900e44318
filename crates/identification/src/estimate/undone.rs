//! Finds options that undo faults of a log when it is read, and writes these options as text.
//!
//! ```text
//! q = R^-1 q_m + q_0        tau = R' tau_m / s
//! ```
//! q_m, tau_m: logged positions and torques; R: matrix of the transmission; q_0: offsets, rad (m); s: scales of the torques. A
//! zero offset is added to q_0, and a wrong scale multiplies s. Wrong signs and exchanged columns are undone by other column
//! names. Faults are undone one after the other as in `log_check::change`. So a change of sign also changes the sign of a zero
//! offset that was undone earlier.

use logs::{ColumnNames, NamePattern};

use crate::estimate::hypothesis::Hypothesis::{self, *};
use crate::estimate::hypothesis::OF_OPTIONS;
use crate::estimate::log_check::Change;
use crate::estimate::options::Options;

/// Numbers in options are rounded to multiples of 1 / this number (four decimals). For an angle in rad, the rounding is about a
/// hundredth of a degree.
const OPTION_ROUNDING: f64 = 1e4;

impl Options {
    /// Returns a copy of these options that also undoes the changes. `columns`: the columns from which the log was read;
    /// `turns`: for each coordinate, whether the coordinate is an angle.
    ///
    /// `None` if no option can undo one of the changes.
    pub fn undoing(&self, changes: &[Change], columns: &ColumnNames, turns: &[bool]) -> Option<Options> {
        let mut options = self.clone();
        changes.iter().all(|change| options.undo(change, columns, turns)).then_some(options)
    }

    /// Extends these options so that they undo one change. Returns false if no option can undo this change.
    fn undo(&mut self, change: &Change, columns: &ColumnNames, turns: &[bool]) -> bool {
        let (Change { of, size }, n) = (*change, turns.len());
        // Wrong signs and exchanges are undone by other names of the columns concerned.
        let (motion, effort) = signals(of);
        if motion.contains(&true) || effort {
            let named = &mut self.columns;
            let motions = [
                (&mut named.position, &columns.position),
                (&mut named.velocity, &columns.velocity),
                (&mut named.acceleration, &columns.acceleration),
            ];
            let moved = motions.into_iter().zip(motion).filter(|(_, moves)| *moves).map(|(names, _)| names);
            let efforts = [
                (&mut named.torque, &columns.torque),
                (&mut named.current, &columns.current),
                (&mut named.goal, &columns.goal),
            ];
            let all: Vec<_> = moved.chain(efforts.into_iter().filter(|_| effort)).collect();
            for (given, read) in all {
                let Some(NamePattern::Each(read)) = read else { continue };
                if read.len() != n {
                    return false;
                }
                if !matches!(given, Some(NamePattern::Each(_))) {
                    *given = Some(NamePattern::Each(read.clone()));
                }
                if let Some(NamePattern::Each(names)) = given {
                    change_names(of, names);
                }
            }
        }
        let transmission = &mut self.transmission;
        match of {
            Zero(k) => transmission.offsets.get_or_insert_with(|| vec![0.0; n])[k] += size,
            MotionSign(k) | Reversed(k) => transmission.offsets.iter_mut().for_each(|all| all[k] = -all[k]),
            SwappedMotions(k, l) | SwappedPositions(k, l) | SwappedJoints(k, l) => {
                transmission.offsets.iter_mut().for_each(|all| all.swap(k, l))
            }
            Scale(k) => transmission.scales.get_or_insert_with(|| vec![1.0; n])[k] *= 1.0 + size,
            // The option for units applies to the positions of all joints. If some joints are prismatic, each angle gets the
            // ratio 180 / pi instead, and the scale of the torque of this joint is multiplied by the same number, so that the
            // torque does not change.
            Degrees if turns.contains(&false) => {
                let degrees = |turns: &bool| if *turns { 180.0 / std::f64::consts::PI } else { 1.0 };
                for list in [&mut transmission.ratios, &mut transmission.scales] {
                    let all = list.get_or_insert_with(|| vec![1.0; n]);
                    all.iter_mut().zip(turns).for_each(|(x, turns)| *x *= degrees(turns));
                }
            }
            Degrees => {
                let units = &mut self.columns.units;
                units.position = Some("deg".into());
                units.velocity = columns.velocity.as_ref().map(|_| "deg/s".into());
                units.acceleration = columns.acceleration.as_ref().map(|_| "deg/s^2".into());
            }
            TorqueSign(_) | SwappedVelocities(..) | SwappedTorques(..) => {}
            _ => return false,
        }
        true
    }

    /// Remedy in words: the entries of these options that differ from `others`, for the options file. `None` if no entry
    /// differs.
    pub fn remedy_added_to(&self, others: &Options) -> Option<String> {
        self.differences_from(others).map(|said| format!("{OF_OPTIONS} {said}"))
    }

    /// The entries of these options that differ from `others`, as text of an options file (YAML). `None` if no entry differs.
    fn differences_from(&self, others: &Options) -> Option<String> {
        let (columns, transmission) = (&self.columns, &self.transmission);
        let (of_columns, of_transmission) = (&others.columns, &others.transmission);
        let list = |key: &str, numbers: &Option<Vec<f64>>, other: &Option<Vec<f64>>| {
            // Adding 0.0 turns the number -0 into 0, so that it is printed without a sign.
            let rounded = |x: &f64| ((x * OPTION_ROUNDING).round() / OPTION_ROUNDING + 0.0).to_string();
            let numbers = numbers.as_ref().filter(|_| numbers != other)?;
            Some(format!("{key}: [{}]", numbers.iter().map(rounded).collect::<Vec<_>>().join(", ")))
        };
        let names = |key: &str, names: &Option<NamePattern>, other: &Option<NamePattern>| match names {
            Some(NamePattern::Each(each)) if names != other => {
                Some(format!("{key}: [{}]", each.iter().map(|name| scalar(name)).collect::<Vec<_>>().join(", ")))
            }
            _ => None,
        };
        let unit = |key: &str, unit: &Option<String>, other: &Option<String>| {
            unit.as_ref().filter(|_| unit != other).map(|unit| format!("{key}: {}", scalar(unit)))
        };
        let groups = [
            (
                "columns",
                vec![
                    names("position", &columns.position, &of_columns.position),
                    names("velocity", &columns.velocity, &of_columns.velocity),
                    names("acceleration", &columns.acceleration, &of_columns.acceleration),
                    names("torque", &columns.torque, &of_columns.torque),
                    names("current", &columns.current, &of_columns.current),
                    names("goal", &columns.goal, &of_columns.goal),
                ],
            ),
            (
                "units",
                vec![
                    unit("position", &columns.units.position, &of_columns.units.position),
                    unit("velocity", &columns.units.velocity, &of_columns.units.velocity),
                    unit("acceleration", &columns.units.acceleration, &of_columns.units.acceleration),
                ],
            ),
            (
                "transmission",
                vec![
                    list("ratios", &transmission.ratios, &of_transmission.ratios),
                    list("offsets", &transmission.offsets, &of_transmission.offsets),
                    list("dead_currents", &transmission.dead_currents, &of_transmission.dead_currents),
                    list("scales", &transmission.scales, &of_transmission.scales),
                ],
            ),
        ];
        let said = groups.into_iter().map(|(key, parts)| (key, parts.into_iter().flatten().collect::<Vec<_>>()));
        let said = said.filter(|(_, parts)| !parts.is_empty());
        let said: Vec<String> = said.map(|(key, parts)| format!("{key}: {{{}}}", parts.join(", "))).collect();
        match said.as_slice() {
            [] => None,
            [one] => Some(one.clone()),
            _ => Some(format!("{{{}}}", said.join(", "))),
        }
    }
}

/// The columns that a fault concerns: flags for [position, velocity, acceleration], and for the torque.
fn signals(of: Hypothesis) -> ([bool; 3], bool) {
    match of {
        MotionSign(_) | SwappedMotions(..) => ([true; 3], false),
        Reversed(_) | SwappedJoints(..) => ([true; 3], true),
        SwappedPositions(..) => ([true, false, false], false),
        SwappedVelocities(..) => ([false, true, true], false),
        TorqueSign(_) | SwappedTorques(..) => ([false; 3], true),
        _ => ([false; 3], false),
    }
}

/// Exchanges the names of two columns, or changes the sign of one column by a leading `-` in its name.
fn change_names(of: Hypothesis, names: &mut [String]) {
    match *of.joints().as_slice() {
        [k] => names[k] = names[k].strip_prefix('-').map_or_else(|| format!("-{}", names[k]), str::to_string),
        [k, l] => names.swap(k, l),
        _ => {}
    }
}

/// Writes a text as an entry of a YAML list, quoted if necessary.
fn scalar(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_./- ^".contains(c);
    let begins = text.trim_start_matches('-').starts_with(|c: char| c.is_alphabetic() || c == '_');
    match begins && !text.starts_with("--") && text.chars().all(is_plain) && text.trim() == text {
        true => text.into(),
        false => format!("'{}'", text.replace('\'', "''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> ColumnNames {
        let each = |stem: &str| Some(NamePattern::Each((1..=3).map(|k| format!("{stem}{k}")).collect()));
        ColumnNames { position: each("q"), velocity: each("dq"), torque: each("tau"), ..ColumnNames::default() }
    }

    fn said(options: &Options, changes: &[Change]) -> Option<String> {
        options.undoing(changes, &columns(), &[true; 3])?.differences_from(options)
    }

    #[test]
    fn what_undoes_a_fault_is_said_as_options() {
        let (of, sized) = (Change::of, |of: Hypothesis, size: f64| Change { of, size });
        for (changes, wanted) in [
            (vec![sized(Zero(1), 0.5)], "transmission: {offsets: [0, 0.5, 0]}"),
            (vec![of(TorqueSign(2))], "columns: {torque: [tau1, tau2, -tau3]}"),
            (vec![of(MotionSign(0))], "columns: {position: [-q1, q2, q3], velocity: [-dq1, dq2, dq3]}"),
            (vec![of(SwappedVelocities(0, 1))], "columns: {velocity: [dq2, dq1, dq3]}"),
            (vec![sized(Scale(0), -0.75)], "transmission: {scales: [0.25, 1, 1]}"),
            (vec![of(Degrees)], "units: {position: deg, velocity: deg/s}"),
            (
                vec![sized(Zero(1), 0.5), of(Reversed(1))],
                "{columns: {position: [q1, -q2, q3], velocity: [dq1, -dq2, dq3], torque: [tau1, -tau2, tau3]}, \
                 transmission: {offsets: [0, -0.5, 0]}}",
            ),
            (vec![of(SwappedTorques(0, 1)), of(TorqueSign(0))], "columns: {torque: [-tau2, tau1, tau3]}"),
        ] {
            let text = said(&Options::default(), &changes).unwrap();
            assert_eq!(text, wanted);
            let meant = Options::default().undoing(&changes, &columns(), &[true; 3]).unwrap();
            assert_eq!(Options::parse("o.yaml", &text).unwrap(), meant, "{text}");
        }
    }

    #[test]
    fn options_that_are_there_are_changed_and_not_replaced() {
        let options = Options::parse("o.yaml", "transmission: {offsets: [0.1, 0, 0.3]}").unwrap();
        let turned = [Change { of: Zero(0), size: -0.25 }];
        assert_eq!(said(&options, &turned).unwrap(), "transmission: {offsets: [-0.15, 0, 0.3]}");
        let twice = [Change::of(TorqueSign(1)), Change::of(TorqueSign(1))];
        assert_eq!(said(&Options::default(), &twice).unwrap(), "columns: {torque: [tau1, tau2, tau3]}");
        assert_eq!(said(&options, &[Change::of(GravityCompensated)]), None);
        let mixed = Options::default().undoing(&[Change::of(Degrees)], &columns(), &[true, false, true]).unwrap();
        let both = "transmission: {ratios: [57.2958, 1, 57.2958], scales: [57.2958, 1, 57.2958]}";
        assert_eq!(mixed.differences_from(&Options::default()).unwrap(), both);
        assert_eq!(scalar("A1 [Nm]"), "'A1 [Nm]'");
        assert_eq!(scalar("-q_1"), "-q_1");
        assert_eq!(scalar("1"), "'1'");
    }
}
