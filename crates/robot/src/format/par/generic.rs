//! Substitute values for symbols that have no value in the file.

use super::table::text;
use crate::format::expression::{KnownNames, identifiers};
use crate::format::node::Node;
use crate::robot::Note;
use crate::value::Symbol;

/// A substitute value in [0.2, 0.9), m or rad, with five digits. It depends only on the name of the symbol, not on other symbols
/// or on the order in the file.
fn generic_value(name: &str) -> f64 {
    // FNV-1a and splitmix64 give very different values for similar names.
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
    let mut z = hash.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let u = ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
    (20_000.0 + (70_000.0 * u).floor()) / 100_000.0
}

/// The value of a gravity symbol for which its component of gravity is -9.81 m/s^2. `component`: for example `G3` or `-G3`.
fn gravity_value(component: &str) -> f64 {
    if component.trim_start().starts_with('-') { 9.81 } else { -9.81 }
}

/// Gives a substitute value to every symbol that has no value, in the order of the file.
pub(super) fn define_generic<'a>(geometry: impl Iterator<Item = &'a Node>, gravity: &[Node], names: &mut KnownNames) {
    let lonely = gravity.iter().filter(|n| identifiers(text(n)).next().is_some()).count() == 1;
    for node in gravity {
        for word in identifiers(text(node)) {
            let value = if lonely && !text(node).contains(['*', '/']) {
                gravity_value(text(node))
            } else {
                10.0 * generic_value(word)
            };
            names.define_generic(word, value);
        }
    }
    for word in geometry.flat_map(|n| identifiers(text(n))) {
        if !names.coordinates.iter().any(|c| c == word) {
            names.define_generic(word, generic_value(word));
        }
    }
}

/// The note on symbols with substitute values; `None` if there are none.
pub(super) fn note_generic(symbols: &[Symbol]) -> Option<Note> {
    let open = || symbols.iter().filter(|s| s.generic);
    let last = open().next_back()?;
    let shown: Vec<String> = open().map(|s| format!("{} = {}", s.name, s.value.number(symbols))).collect();
    let text = format!(
        "no value in the file, so generic ones are used ({}): ranks and rules hold, but numbers mean nothing; give a \
         value in a comment `(* Value {} = 0.45 *)`",
        shown.join(", "),
        last.name
    );
    Some(Note { subject: "symbols".into(), text })
}
