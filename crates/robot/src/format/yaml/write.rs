//! Writes a robot as YAML that [`crate::format::read_yaml`] can read.
//!
//! The text is exact: expressions are unchanged, and each number is the shortest decimal with the same f64 value. Each
//! property that the format cannot express gets a note.

use std::fmt::Write;

use crate::format::written::{WrittenNames, tell_of_file};
use crate::parameter::Inertial;
use crate::robot::{Drive, JointKind, Limits, LinkId, LoopFrame, ModifiedDh, Note, Robot, RotorInertia};
use crate::value::{Affine, Value};

/// Returns the YAML text of a robot, and notes on properties that the format cannot express.
pub fn write_yaml(robot: &Robot) -> (String, Vec<Note>) {
    let mut text = String::new();
    // Writing to a `String` cannot fail, so the result is ignored.
    macro_rules! line {
        ($($part:tt)*) => {{ let _ = writeln!(text, $($part)*); }};
    }
    let names = SymbolNames::new(robot);
    line!("convention: khalil-kleinfinger\nname: {}", named(&robot.name));
    if let Some(source) = &robot.source {
        line!("source: {}", named(source));
    }
    let constant = |v: &Value| names.others.value(v);
    let [x, y, z] = robot.gravity.each_ref().map(constant);
    // A comma inside a YAML list ends the entry, so an expression with a comma must be quoted.
    line!("gravity: [{}, {}, {}]", quoted(&x), quoted(&y), quoted(&z));
    if !robot.symbols.is_empty() {
        line!("symbols:");
        for (symbol, name) in robot.symbols.iter().zip(&names.others.symbols) {
            let comment = if symbol.generic { "   # generic: the description gave no value" } else { "" };
            line!("  {name}: {}{comment}", constant(&symbol.value));
        }
    }
    line!("coordinates: [{}]", names.others.coordinates[..robot.n_coordinates()].join(", "));
    line!("rotor_inertia: none\nlinks:");
    for j in robot.link_ids() {
        line!("  - {{{}}}", link_items(robot, &names, j).join(", "));
    }
    if !robot.loops.is_empty() {
        line!("loops:");
    }
    for one in &robot.loops {
        for (key, frame) in [("  - cut:", &one.cut), ("    twin:", &one.twin)] {
            let items = frame_items(robot, &names, frame, key.contains("cut"));
            line!("{key} {{{}}}", items.join(", "));
        }
    }
    if robot.links.iter().any(|l| l.inertial.is_some()) {
        line!("standard_parameters:");
    }
    for (link, label) in robot.links.iter().zip(&names.labels) {
        if let Some(x) = link.inertial {
            let items: Vec<String> =
                Inertial::BODY.iter().zip(x).map(|(i, x)| format!("{}: {}", i.letters(), number(x))).collect();
            line!("  {label}: {{{}}}", items.join(", "));
        }
    }
    (text, notes_of_symbols(robot, &names))
}

/// The entries `key: value` of one link, without its inertial parameters.
fn link_items(robot: &Robot, names: &SymbolNames, j: LinkId) -> Vec<String> {
    let (link, label) = (robot.link(j), &names.labels[j.0]);
    let joint = &link.joint;
    let mut items = vec![format!("link: {}", label)];
    // The reader gives a link without a name the name `link` with its label, so this name is not written.
    if link.name != format!("link {}", label) {
        items.push(format!("name: {}", named(&link.name)));
    }
    items.push(format!("antecedent: {}", names.link(link.antecedent)));
    // Defaults of the reader are not written: a revolute joint, an actuated drive, the locked drive of a fixed joint.
    match joint.kind {
        JointKind::Revolute => {}
        JointKind::Prismatic => items.push("joint: prismatic".into()),
        JointKind::Fixed => items.push("joint: fixed".into()),
    }
    match joint.drive {
        Drive::Passive => items.push("drive: passive".into()),
        Drive::Locked if joint.kind != JointKind::Fixed => items.push("drive: locked".into()),
        Drive::Locked | Drive::Actuated => {}
    }
    items.extend(placement(robot, names, &link.geometry, joint.kind, &joint.variable));
    match joint.rotor_inertia {
        RotorInertia::Absent => {}
        RotorInertia::Unknown => items.push("rotor_inertia: unknown".into()),
        RotorInertia::Known(x) => items.push(format!("rotor_inertia: {}", number(x))),
    }
    let friction =
        [("viscous", joint.friction.viscous), ("coulomb", joint.friction.coulomb), ("offset", joint.friction.offset)];
    let friction: Vec<String> = friction.iter().filter_map(|(k, x)| x.map(|x| format!("{k}: {}", number(x)))).collect();
    if !friction.is_empty() {
        items.push(format!("friction: {{{}}}", friction.join(", ")));
    }
    if let Some(gain) = joint.drive_gain {
        items.push(format!("drive_gain: {}", number(gain)));
    }
    // Limits belong to a coordinate, but the file has them at the actuated joint that moves this coordinate.
    if let (Drive::Actuated, [(k, _)]) = (joint.drive, &joint.variable.terms[..]) {
        items.extend(limits(robot.coordinates.get(k.0).map(|c| c.limits).unwrap_or_default()));
    }
    items
}

/// The entries `key: value` of a loop frame: of the cut, or of its twin on the other side. The default joint type is omitted:
/// revolute for a cut, fixed for a twin.
fn frame_items(robot: &Robot, names: &SymbolNames, frame: &LoopFrame, is_cut: bool) -> Vec<String> {
    let kind = match (frame.kind, is_cut) {
        (JointKind::Revolute, true) | (JointKind::Fixed, false) => None,
        (JointKind::Revolute, false) => Some("joint: revolute"),
        (JointKind::Prismatic, _) => Some("joint: prismatic"),
        (JointKind::Fixed, true) => Some("joint: fixed"),
    };
    let mut items = vec![format!("antecedent: {}", names.link(frame.antecedent))];
    items.extend(kind.map(str::to_string));
    items.extend(placement(robot, names, &frame.geometry, frame.kind, &frame.variable));
    items
}

/// The entries gamma .. r of a placement; zeros are omitted, except that the variable of a moving or locked joint is always
/// written.
fn placement(
    robot: &Robot,
    names: &SymbolNames,
    geometry: &ModifiedDh,
    kind: JointKind,
    variable: &Affine,
) -> Vec<String> {
    let keys = ["gamma", "b", "alpha", "d", "theta", "r"];
    let values = [&geometry.gamma, &geometry.b, &geometry.alpha, &geometry.d, &geometry.theta, &geometry.r];
    let moving = match kind {
        JointKind::Revolute => "theta",
        JointKind::Prismatic => "r",
        JointKind::Fixed => "",
    };
    let n = robot.n_coordinates();
    let mut items = Vec::new();
    for (key, value) in keys.into_iter().zip(values) {
        if key != moving {
            if *value != Value::ZERO {
                items.push(format!("{key}: {}", quoted(&names.others.value(value))));
            }
            continue;
        }
        // A variable that the loops determine is not written, because the reader determines it again. But the constant part is
        // added to the start value of the search, which is written.
        match &variable.terms[..] {
            [(k, c)] if k.0 >= n && *c == 1.0 => {
                let start = robot.passive[k.0 - n].start + value.number(&robot.symbols);
                if start != 0.0 {
                    items.push(format!("start: {}", number(start)));
                }
            }
            terms if terms.iter().any(|(k, _)| k.0 >= n) => {}
            _ => items.push(format!("{key}: {}", quoted(&names.others.variable(variable, value)))),
        }
    }
    items
}

/// The text of a number. A negative zero becomes 0, because YAML reads -0 as the integer 0.
fn number(x: f64) -> String {
    (x + 0.0).to_string()
}

fn limits(limits: Limits) -> Option<String> {
    let mut items = Vec::new();
    if let Some((low, high)) = limits.position
        && low.is_finite()
        && high.is_finite()
    {
        items.push(format!("position: [{}, {}]", number(low), number(high)));
    }
    for (key, x) in [("velocity", limits.velocity), ("acceleration", limits.acceleration), ("effort", limits.effort)] {
        items.extend(x.map(|x| format!("{key}: {}", number(x))));
    }
    (!items.is_empty()).then(|| format!("limits: {{{}}}", items.join(", ")))
}

/// Whether some version of YAML would read this text as a number or a keyword. A label that consists only of digits, as Khalil
/// uses, does not count, because our reader reads it back unchanged.
fn is_no_word(text: &str) -> bool {
    const RESERVED_WORDS: [&str; 9] = ["null", "true", "false", "yes", "no", "on", "off", "y", "n"];
    let as_khalil = text.parse::<u32>().is_ok_and(|n| n.to_string() == text);
    let digit = |c: char| c.is_ascii_hexdigit() || matches!(c, '_' | '.' | '+' | '-' | 'x' | 'X' | 'o' | 'O');
    let begins_as_number = text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-'));
    let is_number = begins_as_number && text.chars().all(digit);
    RESERVED_WORDS.contains(&text.to_ascii_lowercase().as_str()) || (is_number && !as_khalil)
}

/// The text as a plain word if possible, otherwise in JSON quotes, which YAML can read.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | ' ' | '+' | '-' | '*' | '/' | '(' | ')' | '.');
    let is_word = text.trim() == text && text.chars().all(plain) && !text.starts_with(['-', '*', ' ']);
    if !text.is_empty() && (is_word || text.parse::<f64>().is_ok()) {
        return text.to_string();
    }
    let escaped: String = text
        .chars()
        .map(|c| match c {
            '"' => "\\\"".into(),
            '\\' => "\\\\".into(),
            // Characters that YAML refuses or reads as a line break are escaped.
            c if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}') => {
                format!("\\u{:04x}", u32::from(c))
            }
            c => c.to_string(),
        })
        .collect();
    format!("\"{escaped}\"")
}

/// The text of a name. It is quoted if YAML would read it as a number or a boolean.
fn named(text: &str) -> String {
    let plain = quoted(text);
    if plain == text && (is_no_word(text) || text.parse::<f64>().is_ok()) { format!("\"{text}\"") } else { plain }
}

struct SymbolNames {
    labels: Vec<String>,
    others: WrittenNames,
}

impl SymbolNames {
    /// The label of a link; `base` for `None`.
    fn link(&self, j: Option<LinkId>) -> String {
        j.map_or("base".into(), |j| self.labels[j.0].clone())
    }

    fn new(robot: &Robot) -> SymbolNames {
        let word = |text: &str| -> String {
            text.chars().map(|c| if c.is_alphanumeric() || c == '_' { c } else { '_' }).collect()
        };
        let others = WrittenNames::new(robot, word, is_no_word);
        let mut labels: Vec<String> = Vec::new();
        for link in &robot.links {
            let mut label = word(&link.label);
            // With an underscore at its end, a number may still be read as a number. So such a label gets a letter in front.
            if is_no_word(&label) {
                label.insert(0, 'l');
            }
            while label.is_empty() || label == "base" || labels.contains(&label) {
                label.push('_');
            }
            labels.push(label);
        }
        SymbolNames { labels, others }
    }
}

fn notes_of_symbols(robot: &Robot, names: &SymbolNames) -> Vec<Note> {
    let mut notes = Vec::new();
    let mut note = |subject: &str, text: String| notes.push(Note { subject: subject.into(), text });
    for (link, label) in robot.links.iter().zip(&names.labels) {
        if link.label != *label {
            note(&link.label, format!("the link is called {label} in the file"));
        }
        if link.joint.name != link.label {
            note(&link.name, format!("the name `{}` of its joint is not carried", link.joint.name));
        }
        tell_of_file(link, &mut note);
    }
    for (k, coordinate) in robot.coordinates.iter().enumerate() {
        if coordinate.name != names.others.coordinates[k] {
            note(&coordinate.name, format!("the coordinate is called {} in the file", names.others.coordinates[k]));
        }
    }
    for symbol in robot.symbols.iter().filter(|s| s.generic) {
        note(&symbol.name, "has no value in the description; a generic one is written".into());
    }
    notes
}
