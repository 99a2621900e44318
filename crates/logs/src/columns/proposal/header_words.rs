//! The words by which headers are proposed for a quantity, in several languages.
//!
//! A pattern is a header with `{}` in place of the joint's number or `{joint}` in place of the joint's name. Its words
//! determine how well it matches a quantity.

use crate::columns::source::ColumnSource;
use crate::columns::words::{Quantity, with_underscores};

/// Words for measured quantities in headers, in several languages. The most likely word is first.
pub(super) const WORDS: [(Quantity, &[&str]); 4] = [
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

/// The words of a header, in lower case.
pub(super) fn words(header: &str) -> Vec<String> {
    let lower = [header.to_lowercase(), with_underscores(header)];
    let of = |text: &String| -> Vec<String> {
        text.split(|c: char| !c.is_alphabetic()).filter(|word| !word.is_empty()).map(str::to_string).collect()
    };
    lower.iter().flat_map(of).collect()
}

/// The rank of a pattern for the words of a quantity; the smallest rank is the best. `None` if no word matches.
pub(super) fn score(pattern: &str, quantity: Quantity, wanted: &[&str]) -> Option<(usize, usize)> {
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

/// Whether the header of a column names its unit.
pub(super) fn names_unit(source: &ColumnSource) -> bool {
    let is_of_si = |word: &String| matches!(word.as_str(), "rad" | "radians" | "radps" | "s" | "sec" | "seconds");
    source.factor != 1.0 || words(&source.header).iter().any(is_of_si)
}
