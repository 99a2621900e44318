//! Reads a robot from YAML: modified Denavit-Hartenberg parameters with named keys.
//!
//! iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r)  [Khalil, Kleinfinger 1986]
//!
//! Tables of Craig, and of Denavit and Hartenberg, are converted to this form (convention.rs). Degrees and
//! millimetres are possible.
//!
//! Any number may be an expression with symbols. The variable of a joint (theta of a revolute joint, r of a prismatic joint)
//! may also contain coordinates, and must be affine in them: its constant part is added to the geometry, and its linear part
//! is [`crate::Joint::variable`]. If the file omits the variable of a passive joint or a cut, it is determined from the loops
//! ([`crate::passive`]). The keys are listed in the constants below and in link.rs; an unknown key is an error.

use super::convention::Convention;
use super::link::{Draft, drafts};
use super::loops::{check_closure, check_passive, loops};
use super::standard_parameters::standard_parameters;
use crate::angle_snap::snap_angles;
use crate::error::Error;
use crate::format::budget::MAX_DESCRIPTION_BYTES;
use crate::format::expression::{KnownNames, identifiers, is_name};
use crate::format::node::{DescriptionFile, Fields, Node, NodeValue};
use crate::format::options::ReadOptions;
use crate::passive;
use crate::robot::{Coordinate, Drive, Joint, JointKind, Limits, Link, PassiveCoordinate, Robot, RotorInertia};
use crate::value::{CoordinateId, Value};
use gate::suggestion::did_you_mean;

/// The keys at the top level of a description.
pub(super) const ROOT_KEYS: [&str; 12] = [
    "convention",
    "angles",
    "lengths",
    "name",
    "source",
    "gravity",
    "symbols",
    "coordinates",
    "rotor_inertia",
    "links",
    "loops",
    "standard_parameters",
];

/// Largest number of symbols in a description.
const MAX_SYMBOLS_PER_ROBOT: usize = 1000;

/// Reads a robot from a YAML text. `file`: name of the file in errors.
///
/// Fails, with line and column, if the description is incomplete or inconsistent, or if a loop does not close.
pub fn read_yaml(text: &str, file: &str) -> Result<Robot, Error> {
    read_yaml_with(text, file, ReadOptions::default())
}

/// Reads a robot from a YAML text as [`read_yaml`] does, with options.
pub(in crate::format) fn read_yaml_with(text: &str, file: &str, options: ReadOptions) -> Result<Robot, Error> {
    let source = DescriptionFile { file };
    if text.len() > MAX_DESCRIPTION_BYTES {
        return Err(source.error(0, 0, "the description is larger than 1 MiB"));
    }
    let root = source.parse(text)?;
    if matches!(root.content, NodeValue::Null) {
        return Err(source.error(1, 1, "the file is empty; expected a robot with `convention: khalil-kleinfinger`"));
    }
    let convention = Convention::of(source, &root)?;
    let fields = root.fields(source, "the robot", &ROOT_KEYS)?;
    let convention = convention.with_units(source, &fields)?;
    let name = fields.require("name")?.word(source, "`name`")?;
    let cited = fields.get("source").map(|n| n.word(source, "`source`")).transpose()?;

    let mut names = symbols(source, &fields)?;
    names.set_values(source, options.values)?;
    // Joint variables contain coordinates. So the links are read in two steps: before and after the coordinates are known.
    let gravity = gravity(source, &fields, &names)?;
    let drafts = drafts(source, fields.require("links")?, convention)?;
    names.coordinates = match fields.get("coordinates") {
        Some(node) => listed_coordinates(source, node, &names)?,
        None => found_coordinates(source, &drafts, &names)?,
    };

    let rotors = rotors(source, &fields)?;
    let mut passive = Vec::new();
    let link = |draft| link(source, &names, &drafts, draft, rotors, &mut passive);
    let links = drafts.iter().map(link).collect::<Result<Vec<_>, _>>()?;
    let mut coordinates: Vec<Coordinate> =
        names.coordinates.iter().map(|c| Coordinate { name: c.clone(), limits: Limits::default() }).collect();
    assign_coordinates(source, &fields, &names, &drafts, &links, &mut coordinates)?;
    let node = fields.get("loops");
    let loops = node.map(|node| loops(source, node, &names, &drafts, convention, &mut passive)).transpose()?;
    let mut robot = Robot {
        name,
        source: cited,
        symbols: names.symbols.clone(),
        coordinates,
        passive,
        links,
        loops: loops.unwrap_or_default(),
        gravity,
        ..Robot::default()
    };
    let places = convention.to_near_ends(&mut robot, options.angles);
    if let Some(node) = fields.get("standard_parameters") {
        standard_parameters(source, node, &names, convention, &places, &mut robot.links)?;
    }
    robot.notes.extend(convention.far_away(&robot));
    snap_angles(&mut robot, options.angles);
    check_passive(source, &robot, &drafts)?;
    if let Some(node) = fields.get("loops") {
        passive::resolve(&mut robot).map_err(|message| source.at(node, message))?;
    }
    check_closure(source, fields.get("loops"), &robot)?;
    Ok(robot)
}

fn symbols(source: DescriptionFile, fields: &Fields) -> Result<KnownNames, Error> {
    let mut names = KnownNames::default();
    let Some(node) = fields.get("symbols") else { return Ok(names) };
    let entries = node.map(source, "`symbols`")?;
    if entries.len() > MAX_SYMBOLS_PER_ROBOT {
        return Err(source.at(node, format!("more than {MAX_SYMBOLS_PER_ROBOT} symbols")));
    }
    for (key, value) in entries {
        if !is_name(&key.text) {
            let message = format!("`{}` cannot name a symbol: letters, digits and _, no digit first", key.text);
            return Err(source.at_key(key, message));
        }
        names.define(source, key.text.clone(), value)?;
    }
    Ok(names)
}

fn gravity(source: DescriptionFile, fields: &Fields, names: &KnownNames) -> Result<[Value; 3], Error> {
    let Some(node) = fields.get("gravity") else {
        return Ok([Value::ZERO, Value::ZERO, Value::Number(-9.81)]);
    };
    let items = node.list(source, "`gravity`")?;
    let [x, y, z] = items else {
        let message = format!("`gravity` is a vector of three accelerations, m/s^2, found {}", node.kind());
        return Err(source.at(node, message));
    };
    let component = |n| names.constant(source, "a component of `gravity`", n);
    Ok([component(x)?, component(y)?, component(z)?])
}

fn listed_coordinates(source: DescriptionFile, node: &Node, names: &KnownNames) -> Result<Vec<String>, Error> {
    let mut listed: Vec<String> = Vec::new();
    for item in node.list(source, "`coordinates`")? {
        let word = item.word(source, "a coordinate")?;
        let refused = if !is_name(&word) {
            "cannot name a coordinate: letters, digits and _, no digit first"
        } else if names.symbols.iter().any(|s| s.name == word) {
            "names a symbol already"
        } else if listed.contains(&word) {
            "stands twice among the coordinates"
        } else {
            listed.push(word);
            continue;
        };
        return Err(source.at(item, format!("`{word}` {refused}")));
    }
    Ok(listed)
}

/// The names of the coordinates, one for each actuated joint: the name in the joint variable that is not the name of a symbol.
fn found_coordinates(source: DescriptionFile, drafts: &[Draft], names: &KnownNames) -> Result<Vec<String>, Error> {
    let mut found: Vec<String> = Vec::new();
    for draft in drafts.iter().filter(|d| d.drive == Drive::Actuated) {
        let Some(node) = draft.variable_node() else { continue };
        let NodeValue::Text(text) = &node.content else { continue };
        // The file lists no coordinates. So a name in a joint variable is a coordinate if it is no symbol.
        let mut unknown: Vec<&str> =
            identifiers(text).filter(|w| !names.symbols.iter().any(|s| s.name == *w)).collect();
        unknown.sort_unstable();
        unknown.dedup();
        match unknown[..] {
            [] => {}
            [name] => {
                // Two actuated joints with the same coordinate are refused later, in `assign_coordinates`.
                if !found.iter().any(|f| f == name) {
                    found.push(name.to_string());
                }
            }
            _ => {
                let symbols = || names.symbols.iter().map(|s| s.name.as_str());
                let meant = unknown.iter().map(|w| did_you_mean(w, symbols())).find(|m| !m.is_empty());
                let message = format!(
                    "{} of link {} names one coordinate at most, found `{}`{}; list `coordinates` or define symbols",
                    draft.variable_key(),
                    draft.label,
                    unknown.join("`, `"),
                    meant.unwrap_or_default()
                );
                return Err(source.at(node, message));
            }
        }
    }
    Ok(found)
}

#[derive(Clone, Copy)]
enum Rotors {
    None,
    Actuated,
    All,
}

fn rotors(source: DescriptionFile, fields: &Fields) -> Result<Rotors, Error> {
    let Some(node) = fields.get("rotor_inertia") else { return Ok(Rotors::Actuated) };
    let which = node.choice(source, "`rotor_inertia` of the robot", &["none", "actuated", "all"])?;
    Ok([Rotors::None, Rotors::Actuated, Rotors::All][which])
}

fn link(
    source: DescriptionFile,
    names: &KnownNames,
    drafts: &[Draft],
    draft: &Draft,
    rotors: Rotors,
    passive: &mut Vec<PassiveCoordinate>,
) -> Result<Link, Error> {
    let (geometry, variable) = draft.placement(source, names, passive)?;
    let moves = draft.kind != JointKind::Fixed;
    let default = match (rotors, draft.drive) {
        (Rotors::All, _) if moves => RotorInertia::Unknown,
        (Rotors::Actuated, Drive::Actuated) if moves => RotorInertia::Unknown,
        _ => RotorInertia::Absent,
    };
    let (name, antecedent) = (draft.name(source)?, draft.antecedent(source, drafts)?);
    let joint = Joint {
        rotor_inertia: draft.rotor_inertia(source, names)?.unwrap_or(default),
        friction: draft.friction(source, names)?,
        drive_gain: draft.drive_gain(source, names)?,
        ..Joint::bare(draft.label.clone(), draft.kind, draft.drive, variable)
    };
    Ok(Link { name, ..Link::bare(draft.label.clone(), antecedent, geometry, joint) })
}

/// Checks that exactly one actuated joint moves each coordinate, and copies the limits of this joint to the coordinate.
fn assign_coordinates(
    source: DescriptionFile,
    fields: &Fields,
    names: &KnownNames,
    drafts: &[Draft],
    links: &[Link],
    coordinates: &mut [Coordinate],
) -> Result<(), Error> {
    let mut mover: Vec<Option<usize>> = vec![None; coordinates.len()];
    for (j, (draft, link)) in drafts.iter().zip(links).enumerate() {
        let limits = draft.limits(source, names)?;
        // Passive, locked and fixed joints do not move a coordinate of their own, so they have no limits.
        if link.joint.drive != Drive::Actuated || link.joint.kind == JointKind::Fixed {
            if let (Some(_), Some(node)) = (limits, draft.fields.get("limits")) {
                let message =
                    format!("limits belong to the joint that moves a coordinate; link {} does not", draft.label);
                return Err(source.at(node, message));
            }
            continue;
        }
        // The variable of an actuated joint has exactly one term: `placement` in link.rs has checked this.
        let CoordinateId(k) = link.joint.variable.terms[0].0;
        if let Some(first) = mover[k].replace(j) {
            let message = format!(
                "the coordinate `{}` is moved by link {} already: a coordinate has one actuated joint; say \
                 `drive: passive` where a joint only follows",
                coordinates[k].name, drafts[first].label
            );
            return Err(source.at(draft.variable_node().unwrap_or(draft.node), message));
        }
        coordinates[k].limits = limits.unwrap_or_default();
    }
    match mover.iter().position(Option::is_none) {
        None => Ok(()),
        Some(k) => {
            let listed = fields.get("coordinates").and_then(|n| n.list(source, "").ok()).and_then(|l| l.get(k));
            let message = format!("no actuated joint moves the coordinate `{}`", coordinates[k].name);
            Err(source.at(listed.unwrap_or(drafts[0].node), message))
        }
    }
}
