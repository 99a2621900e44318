//! Writes repaired bodies into `standard_parameters` of a YAML description; only numbers change.

use std::ops::Range;

use crate::body_doubt::shown;
use crate::error::Error;
use crate::finding::RepairedBody;
use crate::format::node::{DescriptionFile, Node, NodeValue};
use crate::inertial::Part;
use crate::parameter::Inertial;
use crate::robot::Robot;

/// Significant digits of a written number. Further digits would be rounding errors of the conversion to the centre of mass and
/// back.
const DIGITS: usize = 14;
/// A number is changed if it differs by more than this fraction of the largest number of its body.
const CHANGE: f64 = 1e-12;

/// The text of a description with other numbers for these bodies. `robot`: the robot that was read from this text; `file`: name
/// of the description in errors.
///
/// Fails if a number is missing, or if it is given as an expression.
pub fn write_repairs_into_yaml(
    text: &str,
    file: &str,
    robot: &Robot,
    bodies: &[&RepairedBody],
) -> Result<String, Error> {
    let source = DescriptionFile { file };
    let root = source.parse(text)?;
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    for body in bodies {
        let label = robot.links.iter().find(|link| link.name == body.name).map(|link| link.label.as_str());
        let entry = label.and_then(|label| entry(entry(&root, "standard_parameters")?, label));
        let entry = entry.ok_or_else(|| source.whole(format!("there are no standard parameters of {}", body.name)))?;
        let numbers =
            if self::entry(entry, "mass").is_some() { about_centre(entry, body) } else { about_origin(entry, body) };
        let largest = numbers.iter().fold(0.0f64, |most, (_, _, x)| most.max(x.abs()));
        for (key, node, x) in numbers {
            let at = node.unwrap_or(entry);
            let number = match node.map(|node| &node.content) {
                Some(NodeValue::Number(given)) => *given,
                None if x.abs() <= CHANGE * largest => continue,
                _ => {
                    let message = format!("the repair of {} needs a number for `{key}` here: {x}", body.name);
                    return Err(source.at(at, message));
                }
            };
            if (number - x).abs() > CHANGE * largest {
                edits.push((place(text, at), shown(x, DIGITS).to_string()));
            }
        }
    }
    // The edits start from the end of the text, so that earlier positions stay valid.
    edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
    let mut text = text.to_string();
    edits.into_iter().for_each(|(range, number)| text.replace_range(range, &number));
    Ok(text)
}

/// The value of a key in a map.
pub(super) fn entry<'a>(node: &'a Node, key: &str) -> Option<&'a Node> {
    let NodeValue::Map(entries) = &node.content else { return None };
    entries.iter().find(|(found, _)| found.text == key).map(|(_, value)| value)
}

/// A key, its value in the file, and the number that it should have.
type Wanted<'a> = (&'static str, Option<&'a Node>, f64);

fn about_origin<'a>(entry: &'a Node, body: &RepairedBody) -> Vec<Wanted<'a>> {
    let RepairedBody { mass, pose, inertia, .. } = *body;
    let x = Part { name: String::new(), pose, mass, inertia }.parameters();
    Inertial::BODY.map(Inertial::letters).into_iter().zip(x).map(|(key, x)| (key, self::entry(entry, key), x)).collect()
}

fn about_centre<'a>(entry: &'a Node, body: &RepairedBody) -> Vec<Wanted<'a>> {
    let centre = match self::entry(entry, "centre_of_mass").map(|node| &node.content) {
        Some(NodeValue::List(items)) => &items[..],
        _ => &[],
    };
    let inertia = self::entry(entry, "inertia");
    let mut found = vec![("mass", self::entry(entry, "mass"), body.mass)];
    found.extend((0..3).map(|k| ("centre_of_mass", centre.get(k), body.pose.position[k])));
    let entries = super::standard_parameters::ENTRIES.into_iter().zip(body.inertia);
    found.extend(entries.map(|(key, x)| (key, inertia.and_then(|node| self::entry(node, key)), x)));
    found
}

/// The bytes of a number in the text.
pub(super) fn place(text: &str, node: &Node) -> Range<usize> {
    let line: usize = text.split_inclusive('\n').take(node.line.saturating_sub(1)).map(str::len).sum();
    let rest = &text[line..];
    let start = line + rest.char_indices().nth(node.column.saturating_sub(1)).map_or(0, |(at, _)| at);
    let ends = |c: char| c.is_whitespace() || matches!(c, ',' | ']' | '}' | '#');
    start..text[start..].find(ends).map_or(text.len(), |length| start + length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::read_yaml;
    use crate::lint::lint;

    const HEAD: &str = "convention: khalil-kleinfinger\nname: r # an arm\nlinks:\n- {link: a, antecedent: base, theta: q1}\n\
                        - {link: b, antecedent: a, alpha: pi/2, d: 0.4, theta: q2}\nstandard_parameters:\n  # from CAD\n";

    fn repaired(bodies: &str) -> Result<String, Error> {
        let text = format!("{HEAD}{bodies}");
        let robot = read_yaml(&text, "r.yaml").unwrap();
        let found = lint(&robot);
        let repairs: Vec<&RepairedBody> =
            found.iter().filter_map(|f| f.repair.as_ref()).flat_map(|r| &r.bodies).collect();
        assert!(!repairs.is_empty(), "{found:?}");
        let written = write_repairs_into_yaml(&text, "r.yaml", &robot, &repairs)?;
        let again = lint(&read_yaml(&written, "r.yaml").unwrap());
        assert!(again.iter().all(|f| f.repair.is_none()), "{again:?}");
        Ok(written[HEAD.len()..].to_string())
    }

    #[test]
    fn numbers_alone_change() {
        let sound = "  a: {mass: 2, centre_of_mass: [0.1, 0, 0], inertia: {xx: 0.01, yy: 0.02, zz: 0.02}} # kept, 2\n";
        for (given, wanted) in [
            (
                "  b: {mass: 4000, centre_of_mass: [0.1, 0, 0], inertia: {xx: 10, yy: 20, zz: 20}} # kept\n",
                "  b: {mass: 4, centre_of_mass: [0.1, 0, 0], inertia: {xx: 0.01, yy: 0.02, zz: 0.02}} # kept\n",
            ),
            (
                "  b:\n    XX: 5.0 # g m^2\n    XY: 0\n    XZ: 0\n    YY: 60\n    YZ: 0\n    ZZ: 60\n    MX: 400\n    MY: 0\n    MZ: 0\n    M: 4000\n",
                "  b:\n    XX: 0.005 # g m^2\n    XY: 0\n    XZ: 0\n    YY: 0.06\n    YZ: 0\n    ZZ: 0.06\n    MX: 0.4\n    MY: 0\n    MZ: 0\n    M: 4\n",
            ),
        ] {
            assert_eq!(repaired(&format!("{sound}{given}")).unwrap(), format!("{sound}{wanted}"));
        }
        let text = format!(
            "{sound}  b: {{mass: 4000, centre_of_mass: [0.1, 0, 0], inertia: {{xx: 100/10, yy: 20, zz: 20}}}}\n"
        );
        let message = repaired(&text).unwrap_err().to_string();
        assert!(message.contains("the repair of link b needs a number for `xx` here: 0.01"), "{message}");
    }
}
