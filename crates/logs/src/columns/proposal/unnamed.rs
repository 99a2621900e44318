//! Proposes columns whose headers have no known word, and the goals of position servos.
//!
//! The goal of a position servo is its commanded position.

use crate::columns::names::{ColumnNames, NamePattern};
use crate::columns::proposal::header_patterns::{given, quoted};
use crate::columns::proposal::header_words::{WORDS, words};
use crate::columns::proposal::proposed::{Proposal, Proposed, factor_of, key, names_of, set_unit};
use crate::columns::proposal::units::unit;
use crate::columns::relations::{Relations, relations};
use crate::columns::words::Quantity;
use crate::table::Table;

/// Words that name a joint but no quantity.
const JOINT_WORDS: &str = "j a axis axes joint joints achse gelenk eje articulacion 关节 軸 関節";
/// Words for the goals of a position servo.
const GOALS: &str = "goal action target command commanded cmd setpoint desired des ref reference soll leader";

/// Proposes columns if their headers have no known word. Positions are columns whose derivatives are in other columns, or
/// columns with joint names only. Returns whether positions were found.
pub(super) fn by_values(
    (table, coordinates): (&Table, &[String]),
    clock: Option<(usize, f64)>,
    patterns: &[(String, Vec<usize>)],
    proposal: &mut Proposal,
    names: &mut ColumnNames,
) -> bool {
    // Columns whose headers name joints but no quantity are usually positions.
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
    // Otherwise the values decide: a column is a position if another column is its derivative.
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
    // Positions are first, because the unit of the velocities follows from the unit of the positions.
    propose(Quantity::Position, &positions, "other columns are their derivatives");
    propose(Quantity::Velocity, &velocities, "the derivatives of the positions");
    if let Some(others) = others {
        propose(Quantity::Torque, &others, "the other columns, one per joint: torques, unless you know better");
    }
    true
}

/// Proposes the goals of position servos, if the table has neither torques nor currents.
pub(super) fn goals(
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
