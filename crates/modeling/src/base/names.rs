//! Names of base parameters, as in the program SYMORO.

use robot::{Inertial, LinkId, Robot, StandardParameter, Value};

/// The name of a standard parameter that absorbs others: `XXR2` for `XX2`. `plain`: name of the parameter without absorbed
/// parameters.
pub(crate) fn regrouped(plain: &str, inertial: Inertial) -> String {
    let letters = inertial.letters();
    format!("{letters}R{}", &plain[letters.len()..])
}

/// The name of a base parameter from `name` without prefix. Without gravity, the name of a first moment gets the prefix of the
/// length through which it acts: `D2MXR4`. This length is the first non-zero d on the path from the base to the link.
pub(crate) fn base(robot: &Robot, parameter: StandardParameter, name: String) -> String {
    let weightless = robot.gravity_number() == [0.0; 3];
    if !(weightless && parameter.inertial.is_first_moment()) {
        return name;
    }
    format!("{}{name}", first_length(robot, parameter.link).unwrap_or_default())
}

fn first_length(robot: &Robot, link: LinkId) -> Option<String> {
    let before = robot.link(link).antecedent.and_then(|i| first_length(robot, i));
    before.or_else(|| {
        let d = &robot.link(link).geometry.d;
        if d.number(&robot.symbols) == 0.0 {
            return None;
        }
        match d {
            Value::Symbol(s) => Some(robot.symbols[s.0].name.clone()),
            Value::Neg(a) => match &**a {
                Value::Symbol(s) => Some(robot.symbols[s.0].name.clone()),
                _ => Some(format!("d{}", robot.link(link).label)),
            },
            _ => Some(format!("d{}", robot.link(link).label)),
        }
    })
}
