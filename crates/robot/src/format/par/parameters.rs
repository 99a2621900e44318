//! Reads the dynamic parameters of a .par file. A parameter is known if it is a number.

use super::table::{ParTable, text};
use crate::error::Error;
use crate::format::expression::{KnownNames, identifiers};
use crate::format::node::{DescriptionFile, Node};
use crate::parameter::Inertial;
use crate::robot::{Drive, Friction, Note, RotorInertia};

/// The number of an entry; `None` if it contains a symbol without a value.
fn known(source: DescriptionFile, names: &KnownNames, what: &str, node: &Node) -> Result<Option<f64>, Error> {
    let has_value = |word: &str| names.symbols.iter().any(|s| s.name == word && !s.generic);
    if identifiers(text(node)).all(has_value) {
        return names.number(source, what, node).map(Some);
    }
    Ok(None)
}

/// XX .. M of link `j`; `None` unless all ten are known.
pub(super) fn inertial(
    source: DescriptionFile,
    table: &ParTable,
    names: &KnownNames,
    j: usize,
    notes: &mut Vec<Note>,
) -> Result<Option<[f64; 10]>, Error> {
    let mut x = [None; 10];
    for (x, inertial) in x.iter_mut().zip(Inertial::BODY) {
        let Some(items) = table.list(inertial.letters()) else { continue };
        *x = known(source, names, &format!("{} of link {}", inertial.letters(), j + 1), &items[j])?;
    }
    let n_known = x.iter().flatten().count();
    if n_known == 10 {
        return Ok(Some(x.map(Option::unwrap_or_default)));
    }
    if n_known > 0 {
        let known: Vec<&str> = Inertial::BODY.iter().zip(x).filter(|p| p.1.is_some()).map(|p| p.0.letters()).collect();
        let text = format!(
            "{} numbers, the others symbols: a link's ten parameters are known together or not at all, so these \
             numbers are not used",
            known.join(" ")
        );
        notes.push(Note { subject: format!("link {}", j + 1), text });
    }
    Ok(None)
}

/// The rotor inertia IA of joint `j`. The joint has none if IA is 0 or if the joint is locked.
pub(super) fn rotor_inertia(
    source: DescriptionFile,
    table: &ParTable,
    names: &KnownNames,
    j: usize,
    drive: Drive,
) -> Result<RotorInertia, Error> {
    if drive == Drive::Locked {
        return Ok(RotorInertia::Absent);
    }
    let Some(items) = table.list("IA") else { return Ok(RotorInertia::Unknown) };
    Ok(match known(source, names, &format!("IA of joint {}", j + 1), &items[j])? {
        None => RotorInertia::Unknown,
        Some(0.0) => RotorInertia::Absent,
        Some(x) => RotorInertia::Known(x),
    })
}

/// The friction parameters FV and FS of joint `j`; each is `None` if it is 0 or not a number.
pub(super) fn friction(
    source: DescriptionFile,
    table: &ParTable,
    names: &KnownNames,
    j: usize,
) -> Result<Friction, Error> {
    let number = |key: &str| -> Result<Option<f64>, Error> {
        let Some(items) = table.list(key) else { return Ok(None) };
        Ok(known(source, names, &format!("{key} of joint {}", j + 1), &items[j])?.filter(|x| *x != 0.0))
    };
    Ok(Friction { viscous: number("FV")?, coulomb: number("FS")?, offset: None })
}

/// Adds notes on entries of the file that are not used, because the robot here is rigid, has a fixed base and no external wrench.
pub(super) fn note_unused(table: &ParTable, notes: &mut Vec<Note>) {
    let mut note = |subject: &str, text: &str| notes.push(Note { subject: subject.into(), text: text.into() });
    let number = |node: &Node| text(node).parse::<f64>().ok();
    for key in ["FX", "FY", "FZ", "CX", "CY", "CZ"] {
        let items = table.list(key).unwrap_or_default();
        if items.iter().any(|n| number(n).is_some_and(|x| x != 0.0)) {
            note(key, "an external wrench is given to the models, not to the description: its numbers are not used");
        }
    }
    if table.list("eta").is_some_and(|items| items.iter().any(|n| number(n) != Some(0.0))) {
        note("eta", "elastic joints are read as rigid ones");
    }
    let unit = |k: usize| if k.is_multiple_of(5) { 1.0 } else { 0.0 };
    if table.list("Z").is_some_and(|items| items.iter().enumerate().any(|(k, n)| number(n) != Some(unit(k)))) {
        note("Z", "the place of the base in the world changes no torque, since G is given in the base frame; not used");
    }
}
