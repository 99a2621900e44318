//! Robots for tests, given row by row: alpha (quarter turns), d, r; all revolute unless said.

use robot::*;

/// alpha in quarter turns, d and r as symbol names or "0", prismatic?
pub(crate) type Row = (i64, &'static str, &'static str, bool);

pub(crate) fn serial(name: &str, rows: &[Row], rotor: RotorInertia) -> Robot {
    let mut symbols: Vec<Symbol> = Vec::new();
    let mut value = |text: &str| -> Value {
        if text == "0" {
            return Value::ZERO;
        }
        let (negative, letters) = match text.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, text),
        };
        let id = symbols.iter().position(|s| s.name == letters).unwrap_or_else(|| {
            let number = 0.2 + 0.07 * symbols.len() as f64;
            symbols.push(Symbol { name: letters.into(), value: Value::Number(number), generic: false });
            symbols.len() - 1
        });
        let symbol = Value::Symbol(SymbolId(id));
        if negative { Value::Neg(Box::new(symbol)) } else { symbol }
    };
    let mut links = Vec::new();
    for (j, &(alpha, d, r, prismatic)) in rows.iter().enumerate() {
        let quarter = |n: i64| {
            let half_pi = Value::Div(Box::new(Value::Pi), Box::new(Value::Number(2.0)));
            Value::Mul(Box::new(Value::Number(n as f64)), Box::new(half_pi))
        };
        links.push(Link {
            name: format!("link {}", j + 1),
            label: format!("{}", j + 1),
            antecedent: j.checked_sub(1).map(LinkId),
            geometry: ModifiedDh { alpha: quarter(alpha), d: value(d), r: value(r), ..ModifiedDh::ZERO },
            joint: Joint {
                name: format!("{}", j + 1),
                kind: if prismatic { JointKind::Prismatic } else { JointKind::Revolute },
                drive: Drive::Actuated,
                variable: Affine::coordinate(CoordinateId(j)),
                rotor_inertia: rotor,
                friction: Friction::default(),
                drive_gain: None,
            },
            inertial: None,
            file_frame: Pose::IDENTITY,
            parts: Vec::new(),
        });
    }
    let coordinates =
        (1..=rows.len()).map(|j| Coordinate { name: format!("q{j}"), limits: Limits::default() }).collect();
    let gravity = [Value::ZERO, Value::ZERO, Value::Number(-9.81)];
    Robot {
        name: name.into(),
        source: None,
        symbols,
        coordinates,
        passive: vec![],
        links,
        massless: 0,
        loops: vec![],
        gravity,
        notes: vec![],
    }
}

pub(crate) fn ur5(rotor: RotorInertia) -> Robot {
    let rows = [
        (0, "0", "RL1", false),
        (1, "0", "0", false),
        (0, "D3", "0", false),
        (0, "D4", "RL4", false),
        (1, "0", "RL5", false),
        (-1, "0", "0", false),
    ];
    serial("ur5", &rows, rotor)
}

pub(crate) fn panda(rotor: RotorInertia) -> Robot {
    let rows = [
        (0, "0", "R1", false),
        (-1, "0", "0", false),
        (1, "0", "R3", false),
        (1, "D4", "0", false),
        (-1, "-D4", "R5", false),
        (1, "0", "0", false),
        (1, "D7", "0", false),
    ];
    serial("panda", &rows, rotor)
}

/// KUKA iiwa 14: the LWR's structure.
pub(crate) fn lwr(rotor: RotorInertia) -> Robot {
    let rows = [
        (0, "0", "0", false),
        (1, "0", "0", false),
        (-1, "0", "RL3", false),
        (-1, "0", "0", false),
        (1, "0", "RL5", false),
        (1, "0", "0", false),
        (-1, "0", "0", false),
    ];
    serial("lwr", &rows, rotor)
}

pub(crate) fn rx90(rotor: RotorInertia) -> Robot {
    let rows = [
        (0, "0", "0", false),
        (1, "0", "0", false),
        (0, "D3", "0", false),
        (-1, "0", "RL4", false),
        (1, "0", "0", false),
        (-1, "0", "0", false),
    ];
    serial("rx90", &rows, rotor)
}

pub(crate) fn puma(rotor: RotorInertia) -> Robot {
    let rows = [
        (0, "0", "0", false),
        (-1, "0", "0", false),
        (0, "D3", "RL3", false),
        (-1, "D4", "RL4", false),
        (1, "0", "0", false),
        (-1, "0", "0", false),
    ];
    serial("puma", &rows, rotor)
}

pub(crate) fn stanford(rotor: RotorInertia) -> Robot {
    let rows = [
        (0, "0", "0", false),
        (-1, "0", "RL2", false),
        (1, "0", "0", true),
        (0, "0", "0", false),
        (-1, "0", "0", false),
        (1, "0", "0", false),
    ];
    serial("stanford", &rows, rotor)
}
