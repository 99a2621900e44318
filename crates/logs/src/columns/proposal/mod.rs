//! Proposes names and units for the columns of a table, each with its reason.
//!
//! First, columns are found by the meaning of their headers ([`Columns::find`]). If this fails, headers that differ by a number
//! or a joint name form a pattern. Words in the pattern determine the quantity. The values determine the unit: a position with a
//! range above three turns is in degrees or ticks; a velocity is compared with the derivative of the position; a clock is
//! compared with the usual sampling rates.

mod clock;
mod header_patterns;
mod header_words;
mod proposed;
mod units;
mod unnamed;

use crate::columns::mapping::Columns;
use crate::columns::names::ColumnNames;
use crate::columns::words::Quantity;
use crate::table::Table;
use clock::{clock, clock_unit, rises, row_rate};
use header_patterns::{given, patterns, quoted};
use header_words::{WORDS, names_unit, score};
pub use proposed::{Proposal, Proposed};
use proposed::{factor_of, key, names_of, set_unit};
use units::unit;
use unnamed::{by_values, goals};

/// Proposes columns of a table for the coordinates of a robot. `rate`: rows per second (Hz) in place of a clock.
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
    Proposal { names, ..proposal }
}

/// The proposal if all columns are found by their names. It then contains only units, for columns whose header names no unit,
/// if the values contradict the default unit.
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
        return Proposal { names, ..proposal };
    }
    let is_judged = is_one_clock && !names_unit(&mapping.time);
    let factor =
        if is_judged { clock_unit(&table.columns[column], &mut proposal, &mut names) } else { mapping.time.factor };
    let clock = mapping.rate.is_none().then_some((column, factor));
    let mut position_factor = mapping.position[0].factor;
    let groups = [(Quantity::Position, Some(&mapping.position)), (Quantity::Velocity, mapping.velocity.as_ref())];
    for (quantity, sources) in groups {
        // If a header names a unit, this unit is used without a test.
        let Some(sources) = sources.filter(|all| !all.iter().any(names_unit)) else { continue };
        let columns: Vec<usize> = sources.iter().map(|source| source.column).collect();
        if let Some((unit, reason)) = unit(table, &columns, quantity, clock, position_factor) {
            proposal.units.push(Proposed { key: key(quantity), value: quoted(&unit), reason });
            set_unit(&mut names, quantity, unit);
            position_factor = factor_of(&names);
        }
    }
    proposal.mapping = Columns::find(table, coordinates, &names).ok().or(Some(mapping));
    Proposal { names, ..proposal }
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
