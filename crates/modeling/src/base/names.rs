//! SYMORO's names for base parameters.

use robot::{LinkId, Robot, StandardParameter, Value};

/// `XXR2` where something regroups into XX2, `XX2` where not.
pub(crate) fn regrouped(robot: &Robot, parameter: StandardParameter, absorbs: bool) -> String {
    let plain = parameter.display(robot).to_string();
    if !absorbs {
        return plain;
    }
    let letters = parameter.inertial.letters();
    format!("{letters}R{}", &plain[letters.len()..])
}

/// The same, and without gravity a first moment with the length through which it acts in front:
/// `D2MXR4`, after the first non-zero d on the way from the base to its link.
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
