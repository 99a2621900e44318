//! The table of a .par file: its sizes and its lists. The lengths of the lists are checked.

use super::text::{ParEntry, ParText};
use crate::error::Error;
use crate::format::node::{DescriptionFile, Node, NodeValue};
use crate::robot::Note;
use gate::suggestion::did_you_mean;

/// The kind of object for which a list has one item each: frames, links, joints or axes. `Sixteen`: the list is a matrix of 16
/// entries.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Per {
    Frame,
    Link,
    Joint,
    Axis,
    Sixteen,
}

/// The keys of lists, grouped by the objects for which a list has one item each.
const LIST_KEYS: [(Per, &str); 5] = [
    (Per::Frame, "ant sigma mu gamma b alpha d theta r"),
    (Per::Link, "XX XY XZ YY YZ ZZ MX MY MZ M IA FV FS FX FY FZ CX CY CZ"),
    (Per::Joint, "eta k QP QDP GAM"),
    (Per::Axis, "W0 WP0 V0 VP0 G"),
    (Per::Sixteen, "Z"),
];

/// All keys of lists, each with the objects for which the list has one item each.
fn list_keys() -> impl Iterator<Item = (&'static str, Per)> {
    LIST_KEYS.into_iter().flat_map(|(per, keys)| keys.split_whitespace().map(move |key| (key, per)))
}

/// The keys that have a single value.
const SCALAR_KEYS: [&str; 6] = ["NL", "NJ", "NF", "Type", "is_floating", "is_mobile"];

/// Largest number of links in a .par file.
const MAX_PAR_LINKS: usize = 500;

/// The table of a .par file. Its sizes and lengths of lists are checked.
pub(super) struct ParTable<'a> {
    source: DescriptionFile<'a>,
    entries: &'a [ParEntry],
    /// Number of links.
    pub nl: usize,
    /// Number of joints, including the joints of the loop cuts.
    pub nj: usize,
    /// Number of frames, including the twins of the loop cuts.
    pub nf: usize,
    /// Whether the robot has no loops.
    pub is_open: bool,
}

impl<'a> ParTable<'a> {
    pub(super) fn new(
        source: DescriptionFile<'a>,
        text: &'a ParText,
        notes: &mut Vec<Note>,
    ) -> Result<ParTable<'a>, Error> {
        let entries = &text.entries[..];
        if entries.is_empty() {
            return Err(source.error(1, 1, "the file has no `key = value`; expected NL, NJ, Type, ant, sigma, ..."));
        }
        let mut table = ParTable { source, entries, nl: 0, nj: 0, nf: 0, is_open: true };
        table.check_keys(notes)?;
        table.nl = table.count("NL")?.ok_or_else(|| source.error(0, 0, "`NL`, the number of links, is missing"))?;
        if table.nl == 0 || table.nl > MAX_PAR_LINKS {
            let message = format!("NL is 1 to {MAX_PAR_LINKS}, found {}", table.nl);
            return Err(table.at("NL", message));
        }
        table.nj = table.count("NJ")?.unwrap_or(table.nl);
        if table.nj < table.nl || table.nj > 2 * MAX_PAR_LINKS {
            let message =
                format!("NJ = {} joints cannot move NL = {} links: every link has one joint", table.nj, table.nl);
            return Err(table.at("NJ", message));
        }
        // The number of frames: NJ frames of links and cuts, and one twin (the frame on the other side) for each of the NJ - NL
        // cuts.
        table.nf = 2 * table.nj - table.nl;
        let kind = table.count("Type")?;
        match kind {
            None | Some(2) => {}
            Some(0 | 1) if table.nj == table.nl => {}
            Some(kind @ (0 | 1)) => {
                let (nj, nl) = (table.nj, table.nl);
                let message =
                    format!("Type {kind} has no loops, but NJ = {nj} and NL = {nl} leave {} cut joints", nj - nl);
                return Err(table.at("Type", message));
            }
            Some(kind) => {
                return Err(table.at("Type", format!("Type is 0 (simple), 1 (tree) or 2 (closed), found {kind}")));
            }
        }
        table.is_open = table.nj == table.nl;
        // NF follows from NL and NJ. If the file gives another value of NF, this value is ignored with a note.
        if let Some(nf) = table.count("NF")?
            && nf != table.nf
        {
            let text = format!("{nf} in the file; NL = {} and NJ = {} make {} frames", table.nl, table.nj, table.nf);
            notes.push(Note { subject: "NF".into(), text });
        }
        table.check_lengths()?;
        table.check_base()?;
        Ok(table)
    }

    /// An error at the place of a key.
    pub(super) fn at(&self, key: &str, message: String) -> Error {
        let place = self.entry(key).map_or((0, 0), |e| (e.line, e.column));
        self.source.place(place, message)
    }

    /// An error at the place of an item of a list, or at the key if the list is missing.
    pub(super) fn at_item(&self, key: &str, item: usize, message: String) -> Error {
        match self.list(key) {
            Some(items) => self.source.at(&items[item], message),
            None => self.at(key, message),
        }
    }

    /// The items of a list; `None` if the file does not have this list.
    pub(super) fn list(&self, key: &str) -> Option<&'a [Node]> {
        self.entry(key).map(|e| &e.items[..])
    }

    /// The integers of a list. Fails if one is not between `lowest` and `highest`. `default`: value for each frame if the
    /// list is missing.
    pub(super) fn integers(
        &self,
        key: &str,
        lowest: usize,
        highest: usize,
        default: impl Fn(usize) -> usize,
    ) -> Result<Vec<usize>, Error> {
        let Some(items) = self.list(key) else { return Ok((1..=self.nf).map(default).collect()) };
        let read = |(k, item): (usize, &Node)| match text(item).parse::<usize>() {
            Ok(n) if (lowest..=highest).contains(&n) => Ok(n),
            _ => {
                let what = item.kind();
                let message = format!("{key} of frame {} is a whole number {lowest} to {highest}, found {what}", k + 1);
                Err(self.source.at(item, message))
            }
        };
        items.iter().enumerate().map(read).collect()
    }

    fn entry(&self, key: &str) -> Option<&'a ParEntry> {
        self.entries.iter().find(|e| e.key == key)
    }

    fn count(&self, key: &str) -> Result<Option<usize>, Error> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        let found = text(&entry.items[0]);
        found.parse().map(Some).map_err(|_| self.at(key, format!("{key} is a whole number, found `{found}`")))
    }

    fn check_keys(&self, notes: &mut Vec<Note>) -> Result<(), Error> {
        let known = || list_keys().map(|l| l.0).chain(SCALAR_KEYS);
        for entry in self.entries {
            let listed = list_keys().any(|l| l.0 == entry.key);
            if listed != entry.is_list && known().any(|k| k == entry.key) {
                let wanted = if listed { "a list `{..}`" } else { "one value" };
                return Err(self.at(&entry.key, format!("`{}` is {wanted}", entry.key)));
            }
            if !known().any(|k| k == entry.key) {
                let key: String = entry.key.chars().take(40).collect();
                let meant = did_you_mean(&entry.key, known());
                notes.push(Note { subject: key, text: format!("unknown key, ignored{meant}") });
            }
        }
        Ok(())
    }

    fn check_lengths(&self) -> Result<(), Error> {
        for entry in self.entries.iter().filter(|e| e.is_list) {
            let Some((_, per)) = list_keys().find(|l| l.0 == entry.key) else { continue };
            let (wanted, of) = match per {
                Per::Frame => (self.nf, "frames (2 NJ - NL)"),
                Per::Link => (self.nl, "links (NL)"),
                Per::Joint => (self.nj, "joints (NJ)"),
                Per::Axis => (3, "axes"),
                Per::Sixteen => (16, "entries of a matrix"),
            };
            if entry.items.len() != wanted {
                let message =
                    format!("`{}` has one item for each of {wanted} {of}, found {}", entry.key, entry.items.len());
                return Err(self.at(&entry.key, message));
            }
        }
        Ok(())
    }

    /// Fails if the base is floating or mobile, or has a velocity or an acceleration.
    fn check_base(&self) -> Result<(), Error> {
        for key in ["is_floating", "is_mobile"] {
            let Some(entry) = self.entry(key) else { continue };
            match text(&entry.items[0]) {
                "0" | "False" | "false" => {}
                "1" | "True" | "true" => {
                    let message = format!("`{key}`: only a fixed base is read; make the base a chain of joints");
                    return Err(self.at(key, message));
                }
                other => return Err(self.at(key, format!("`{key}` is True or False, found `{other}`"))),
            }
        }
        for key in ["W0", "WP0", "V0", "VP0"] {
            let Some(items) = self.list(key) else { continue };
            if let Some(moving) = items.iter().find(|n| text(n).parse() != Ok(0.0)) {
                let message = format!("`{key}` moves the base ({}): only a base at rest is read", moving.kind());
                return Err(self.source.at(moving, message));
            }
        }
        Ok(())
    }
}

/// The text of an item; empty if it is no text.
pub(super) fn text(node: &Node) -> &str {
    match &node.content {
        NodeValue::Text(t) => t,
        _ => "",
    }
}
