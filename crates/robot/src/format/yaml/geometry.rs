//! Writes errors of the geometry (from a calibration) into the table of a YAML description; comments, order and spacing stay.
//!
//! A number is replaced by its sum with the error, and an expression gets the error as a term: `q1 + pi/2` becomes
//! `q1 + pi/2 + 0.002`. The angle beta of Hayati has no key. It becomes a fixed link before the link with this error, because
//! with gamma = pi/2 and theta = -pi/2
//! ```text
//! Ry(beta) = Rz(gamma) Rx(beta) Rz(theta)
//! ```
//! The six other parameters could describe the same pose. But the axes are nearly parallel, so b and r would be kilometres.

use std::ops::Range;

use super::convention::Convention;
use super::read::ROOT_KEYS;
use super::repairs::{entry, place};
use crate::error::Error;
use crate::format::node::{DescriptionFile, Node, NodeValue};
use crate::robot::{LinkId, Robot};

/// Errors of the geometry of a link: of gamma, b, beta, alpha, d, theta and r, rad and m.
pub type GeometryErrors = [f64; 7];

const LETTERS: [&str; 7] = ["gamma", "b", "beta", "alpha", "d", "theta", "r"];
const BETA: usize = 2;

/// The text of a description whose links have these errors added to their geometry. `robot` was read from it; `file`: its name in
/// errors.
///
/// Fails if the table of the description has no key for an error, or if a value is an alias or extends over several lines.
pub fn write_geometry_into_yaml(
    text: &str,
    file: &str,
    robot: &Robot,
    errors: &[(LinkId, GeometryErrors)],
) -> Result<String, Error> {
    let source = DescriptionFile { file };
    let root = source.parse(text)?;
    let convention = Convention::of(source, &root)?;
    let fields = root.fields(source, "the robot", &ROOT_KEYS)?;
    let convention = convention.with_units(source, &fields)?;
    let rows = fields.require("links")?.list(source, "`links`")?;
    let mut table = Table { source, text, robot, convention, rows, edits: Vec::new() };
    for (j, errors) in errors {
        for (letter, x) in LETTERS.into_iter().zip(errors).filter(|(_, x)| **x != 0.0) {
            if letter != LETTERS[BETA] {
                table.add(*j, letter, *x)?;
            }
        }
        if errors[BETA] != 0.0 {
            table.add_beta(*j, errors)?;
        }
    }
    Ok(table.written())
}

struct Table<'a> {
    source: DescriptionFile<'a>,
    text: &'a str,
    robot: &'a Robot,
    convention: Convention,
    rows: &'a [Node],
    edits: Vec<(Range<usize>, String)>,
}

impl Table<'_> {
    fn row(&self, j: LinkId) -> Result<&Node, Error> {
        self.rows
            .get(j.0)
            .ok_or_else(|| self.source.whole(format!("the file has no link {}", self.robot.link(j).label)))
    }

    /// The row of the table that contains the parameter `letter` of link j. In a table with frames at the far ends, alpha and d
    /// stand in the row of the antecedent of the link.
    fn row_of(&self, j: LinkId, letter: &str) -> Result<&Node, Error> {
        if !self.convention.is_far(letter) {
            return self.row(j);
        }
        let carried = |i: LinkId| self.robot.links.iter().filter(|link| link.antecedent == Some(i)).count();
        match self.robot.link(j).antecedent {
            Some(i) if carried(i) == 1 => self.row(i),
            _ => Err(self.refused(j, letter)),
        }
    }

    fn refused(&self, j: LinkId, letter: &str) -> Error {
        let label = &self.robot.link(j).label;
        let message = format!(
            "the table of this file has no key for the error of {letter}{label}: convert it to khalil-kleinfinger first"
        );
        self.rows
            .get(j.0)
            .map_or_else(|| self.source.whole(message.clone()), |row| self.source.at(row, message.clone()))
    }

    /// Adds x (rad or m) to the parameter `letter` (gamma .. r) of link j.
    fn add(&mut self, j: LinkId, letter: &str, x: f64) -> Result<(), Error> {
        let key = self.convention.key(letter).ok_or_else(|| self.refused(j, letter))?;
        let row = self.row_of(j, letter)?;
        let geometry = &self.robot.link(j).geometry;
        let value = match letter {
            "gamma" => &geometry.gamma,
            "b" => &geometry.b,
            "alpha" => &geometry.alpha,
            "d" => &geometry.d,
            "theta" => &geometry.theta,
            _ => &geometry.r,
        };
        let unit = self.convention.per_si(letter);
        let edit = match entry(row, key) {
            Some(node) => match (&node.content, self.scalar(node)?) {
                (NodeValue::Number(_), range) => (range, number(unit * (value.number(&self.robot.symbols) + x))),
                (_, range) => {
                    let sign = if x < 0.0 { "-" } else { "+" };
                    (range.end..range.end, format!(" {sign} {}", number(unit * x.abs())))
                }
            },
            None => self.new_entry(row, &format!("{key}: {}", number(unit * (value.number(&self.robot.symbols) + x)))),
        };
        self.edits.push(edit);
        Ok(())
    }

    /// The range of bytes in the text that a number, or an expression without its quotes, occupies.
    fn scalar(&self, node: &Node) -> Result<Range<usize>, Error> {
        let range = place(self.text, node);
        let rest = &self.text[range.start..];
        let is_there = match &node.content {
            NodeValue::Number(x) => {
                self.text[range.clone()].parse::<f64>().is_ok_and(|y| y == *x).then_some(range.clone())
            }
            NodeValue::Text(text) => [0, 1].into_iter().find_map(|quote| {
                let is_quoted = quote == 0 || rest.starts_with(['"', '\'']);
                let is_it = is_quoted && rest.get(quote..).is_some_and(|rest| rest.starts_with(text.as_str()));
                is_it.then(|| range.start + quote..range.start + quote + text.len())
            }),
            _ => None,
        };
        let message = "this value cannot be changed in its place: write it as a number or as an expression on one line";
        is_there.ok_or_else(|| self.source.at(node, message))
    }

    /// The edit that inserts the entry `text` into a row, before the key `antecedent`.
    fn new_entry(&self, row: &Node, text: &str) -> (Range<usize>, String) {
        let NodeValue::Map(entries) = &row.content else { return (0..0, String::new()) };
        let key = entries.iter().map(|(key, _)| key).find(|key| key.text == "antecedent");
        let (line, column) = key.map_or((row.line, row.column), |key| (key.line, key.column));
        let at = place(self.text, &Node { line, column, content: NodeValue::Null }).start;
        let is_flow = self.text[place(self.text, row).start..].starts_with('{');
        let between = if is_flow { ", ".into() } else { format!("\n{}", " ".repeat(column.saturating_sub(1))) };
        (at..at, format!("{text}{between}"))
    }

    /// Inserts a fixed link with the angle beta between link j and its antecedent.
    fn add_beta(&mut self, j: LinkId, errors: &GeometryErrors) -> Result<(), Error> {
        let (link, row) = (self.robot.link(j), self.row(j)?);
        let number_of = |value: &crate::Value| value.number(&self.robot.symbols);
        let is_first =
            number_of(&link.geometry.gamma) + errors[0] == 0.0 && number_of(&link.geometry.b) + errors[1] == 0.0;
        let antecedent = entry(row, "antecedent").ok_or_else(|| self.refused(j, LETTERS[BETA]))?;
        if self.convention.key("gamma").is_none() || !is_first {
            return Err(self.refused(j, LETTERS[BETA]));
        }
        let mut label = format!("beta{}", link.label);
        while self.robot.links.iter().any(|link| link.label == label) {
            label.push('_');
        }
        let (quarter, unit) = (self.convention.quarter_turn(), self.convention.per_si("alpha"));
        let before = place(self.text, antecedent);
        let fixed = format!(
            "{{link: {label}, antecedent: {}, joint: fixed, gamma: {quarter}, alpha: {}, theta: -{quarter}}}",
            &self.text[before.clone()],
            number(unit * errors[BETA])
        );
        let start = place(self.text, row).start;
        let line = self.text[..start].rfind('\n').map_or(0, |at| at + 1);
        let edit = match self.text[line..start].trim_end().strip_suffix('-') {
            Some(indent) if indent.trim().is_empty() => (line..line, format!("{indent}- {fixed}\n")),
            _ => (start..start, format!("{fixed}, ")),
        };
        self.edits.extend([(before, label), edit]);
        Ok(())
    }

    fn written(mut self) -> String {
        // The edits are made from the end of the text, so that earlier positions stay valid.
        self.edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
        let mut text = self.text.to_string();
        self.edits.into_iter().for_each(|(range, new)| text.replace_range(range, &new));
        text
    }
}

/// The text of a number. A negative zero becomes 0, because YAML reads -0 as the integer 0.
fn number(x: f64) -> String {
    (x + 0.0).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::read_yaml;

    const TABLE: &str = "\
convention: khalil-kleinfinger # a table
name: arm
lengths: mm
links:
  - {link: 1, antecedent: base, theta: q1 + 0.1}
  # the long one
  - link: 2 # upper arm
    antecedent: 1
    alpha: -pi/2
    d: 150
    theta: \"q2\"
  - {link: 3, antecedent: 2, d: 600, theta: q3}
";

    #[test]
    fn numbers_and_terms_change_in_their_places() {
        let robot = read_yaml(TABLE, "a.yaml").unwrap();
        let errors = [
            (LinkId(0), [0.0, 0.0, 0.0, 0.0, 0.0, -0.01, 0.0]),
            (LinkId(1), [0.0, 0.0, 0.0, 0.002, 0.001, 0.003, 0.004]),
            (LinkId(2), [0.0, 0.0, 0.005, 0.006, 0.0, 0.0, 0.0]),
        ];
        let written = write_geometry_into_yaml(TABLE, "a.yaml", &robot, &errors).unwrap();
        let wanted = TABLE
            .replace("q1 + 0.1", "q1 + 0.1 - 0.01")
            .replace("-pi/2", "-pi/2 + 0.002")
            .replace("150", "151")
            .replace("\"q2\"", "\"q2 + 0.003\"")
            .replace("    antecedent: 1", "    r: 4\n    antecedent: 1")
            .replace(
                "  - {link: 3, antecedent: 2, ",
                "  - {link: beta3, antecedent: 2, joint: fixed, gamma: pi/2, alpha: 0.005, theta: -pi/2}\n  - {link: 3, alpha: \
                 0.006, antecedent: beta3, ",
            );
        assert_eq!(written, wanted);
        assert_eq!(read_yaml(&written, "a.yaml").unwrap().links.len(), 4);
        // Other tables have no key for beta. In a table with frames at the far ends, alpha of the first link would stand in a
        // row of the base, which does not exist.
        for (table, errors, word) in [
            ("craig", [0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0], "beta1"),
            ("craig", [0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0], "b1"),
            ("denavit-hartenberg", [0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0], "alpha1"),
        ] {
            let text = format!("convention: {table}\nname: a\nlinks:\n- {{link: 1, antecedent: base, theta: q1}}\n");
            let robot = read_yaml(&text, "a.yaml").unwrap();
            let refused = write_geometry_into_yaml(&text, "a.yaml", &robot, &[(LinkId(0), errors)]);
            let refused = refused.unwrap_err().to_string();
            assert!(refused.contains(&format!("no key for the error of {word}: convert it")), "{refused}");
        }
        let alias = TABLE.replace("d: 150", "d: &d 150").replace("d: 600", "d: *d");
        let robot = read_yaml(&alias, "a.yaml").unwrap();
        let refused =
            write_geometry_into_yaml(&alias, "a.yaml", &robot, &[(LinkId(2), [0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0])]);
        assert!(refused.unwrap_err().to_string().contains("cannot be changed in its place"));
    }
}
