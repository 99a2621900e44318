//! Reads a link of a YAML description: its placement, its joint and the data of its motor.

use super::convention::Convention;
use crate::error::Error;
use crate::format::budget::MAX_LINKS;
use crate::format::expression::KnownNames;
use crate::format::node::{DescriptionFile, Fields, Node};
use crate::robot::{Drive, Friction, JointKind, Limits, LinkId, ModifiedDh, PassiveCoordinate, RotorInertia};
use crate::value::Affine;
use crate::value::{CoordinateId, Value};
use gate::suggestion::did_you_mean;

/// The keys of a link, except the keys of its placement.
const LINK_KEYS: [&str; 10] = [
    "link",
    "name",
    "antecedent",
    "joint",
    "drive",
    // Messages list the five keys above, then the keys of the placement (`placement_keys`), then the keys below.
    "start",
    "rotor_inertia",
    "friction",
    "limits",
    "drive_gain",
];

/// A link whose keys were checked, but whose values are not read yet.
#[derive(Clone, Debug)]
pub(super) struct Draft<'a> {
    pub label: String,
    pub node: &'a Node,
    pub fields: Fields<'a>,
    pub kind: JointKind,
    pub drive: Drive,
    pub convention: Convention,
    index: usize,
}

/// The links of the description, in the order of the file. Fails if two links have the same label.
pub(super) fn drafts<'a>(
    source: DescriptionFile<'a>,
    node: &'a Node,
    convention: Convention,
) -> Result<Vec<Draft<'a>>, Error> {
    let items = node.list(source, "`links`")?;
    if items.is_empty() {
        return Err(source.at(node, "a robot has one link at least; `links` is empty"));
    }
    if items.len() > MAX_LINKS {
        return Err(source.at(node, format!("more than {MAX_LINKS} links are no robot")));
    }
    let mut drafts: Vec<Draft> = Vec::with_capacity(items.len());
    let mut seen = std::collections::BTreeMap::new();
    let keys = [&LINK_KEYS[..5], convention.placement_keys(), &LINK_KEYS[5..]].concat();
    for (index, node) in items.iter().enumerate() {
        let fields = node.fields(source, "a link", &keys)?;
        let called = fields.require("link")?;
        let label = called.word(source, "`link`")?;
        if !label.chars().all(|c| c.is_alphanumeric() || c == '_') || label == "base" {
            let message = format!("`{label}` cannot label a link: a number, or letters, digits and _, but not `base`");
            return Err(source.at(called, message));
        }
        if let Some(line) = seen.insert(label.clone(), called.line) {
            return Err(source.at(called, format!("link {label} stands twice, first on line {line}")));
        }
        let kind = joint_kind(source, &fields, JointKind::Revolute)?;
        let drive = match fields.get("drive") {
            // A fixed joint is not driven, so it counts as locked.
            None if kind == JointKind::Fixed => Drive::Locked,
            None => Drive::Actuated,
            Some(n) => {
                let which = n.choice(source, "`drive`", &["actuated", "passive", "locked"])?;
                let drive = [Drive::Actuated, Drive::Passive, Drive::Locked][which];
                if kind == JointKind::Fixed && drive != Drive::Locked {
                    return Err(source.at(n, format!("the joint of link {label} is fixed: nothing drives it")));
                }
                drive
            }
        };
        drafts.push(Draft { label, node, fields, kind, drive, convention, index });
    }
    Ok(drafts)
}

/// Reads `joint: revolute | prismatic | fixed`.
pub(super) fn joint_kind(source: DescriptionFile, fields: &Fields, default: JointKind) -> Result<JointKind, Error> {
    let Some(node) = fields.get("joint") else { return Ok(default) };
    let which = node.choice(source, "`joint`", &["revolute", "prismatic", "fixed"])?;
    Ok([JointKind::Revolute, JointKind::Prismatic, JointKind::Fixed][which])
}

/// If the file gives no variable for a joint, adds a passive coordinate for it and returns its index; otherwise `None`. The loops
/// determine this coordinate: the search for its value starts at the value of the key `start`.
pub(super) fn passive_coordinate(
    source: DescriptionFile,
    names: &KnownNames,
    fields: &Fields,
    (kind, convention): (JointKind, Convention),
    label: &str,
    passive: &mut Vec<PassiveCoordinate>,
) -> Result<Option<CoordinateId>, Error> {
    let (key, start) = (convention.variable_key(kind), fields.get("start"));
    if kind == JointKind::Fixed || fields.get(key).is_some() {
        return match start {
            Some(node) => Err(source.at(node, format!("`start` belongs to a passive joint without {key}"))),
            None => Ok(None),
        };
    }
    let start = start.map(|n| names.number(source, "`start`", n)).transpose()?.unwrap_or(0.0);
    let start = convention.si_of(kind, start);
    let separator = if label.starts_with(|c: char| c.is_ascii_digit()) { "" } else { "_" };
    passive.push(PassiveCoordinate { name: format!("{key}{separator}{label}"), start });
    Ok(Some(CoordinateId(names.coordinates.len() + passive.len() - 1)))
}

/// Reads the placement (gamma .. r) of a link or a loop frame, and its joint variable. `unknown`: the variable if the file gives
/// none. `what`: name of the link or frame in errors.
pub(super) fn placement(
    source: DescriptionFile,
    names: &KnownNames,
    fields: &Fields,
    what: &str,
    (kind, convention): (JointKind, Convention),
    unknown: Option<CoordinateId>,
) -> Result<(ModifiedDh, Affine), Error> {
    let mut variable = unknown.map_or(Affine::constant(Value::ZERO), Affine::coordinate);
    let mut read = |parameter: &str, moving: bool| -> Result<Value, Error> {
        let Some((key, node)) = convention.key(parameter).and_then(|key| Some((key, fields.get(key)?))) else {
            return Ok(Value::ZERO);
        };
        let named = format!("{key} of {what}");
        // Converts a value from the units of the file. Fails if an angle exceeds a full turn.
        let in_si = |value: Value| {
            let value = convention.si(parameter, value);
            let is_angle = ["gamma", "alpha", "theta"].contains(&parameter);
            match convention.refused_angle(&value, &names.symbols).filter(|_| is_angle) {
                Some(why) => Err(source.at(node, format!("{named} {why}"))),
                None => Ok(value),
            }
        };
        if !moving {
            return in_si(names.constant(source, &named, node)?);
        }
        let value = names.variable(source, &named, node)?;
        let affine = Affine::from_value(&value, &names.symbols).ok_or_else(|| {
            let message = format!(
                "{named} must be affine in the coordinates, like `q2 - q1 + pi/2`, found {}; what follows the \
                 coordinates otherwise is not described by a tree of joints",
                node.kind()
            );
            source.at(node, message)
        })?;
        names.finite(source, &named, node, affine.offset.number(&names.symbols))?;
        for (_, coefficient) in &affine.terms {
            names.finite(source, &named, node, *coefficient)?;
        }
        variable.terms = affine.terms;
        in_si(affine.offset)
    };
    let geometry = ModifiedDh {
        gamma: read("gamma", false)?,
        b: read("b", false)?,
        alpha: read("alpha", false)?,
        d: read("d", false)?,
        theta: read("theta", kind == JointKind::Revolute)?,
        r: read("r", kind == JointKind::Prismatic)?,
    };
    Ok((geometry, variable))
}

impl<'a> Draft<'a> {
    /// The key of the joint variable in the table of the description.
    pub(super) fn variable_key(&self) -> &'static str {
        self.convention.variable_key(self.kind)
    }

    pub(super) fn variable_node(&self) -> Option<&'a Node> {
        if self.kind == JointKind::Fixed { None } else { self.fields.get(self.variable_key()) }
    }

    pub(super) fn name(&self, source: DescriptionFile) -> Result<String, Error> {
        match self.fields.get("name") {
            Some(node) => node.word(source, "`name` of a link"),
            None => Ok(format!("link {}", self.label)),
        }
    }

    pub(super) fn antecedent(&self, source: DescriptionFile, drafts: &[Draft]) -> Result<Option<LinkId>, Error> {
        let node = self.fields.get("antecedent").ok_or_else(|| {
            let message = format!("link {} has no `antecedent`: `base`, or the link that carries it", self.label);
            source.at(self.node, message)
        })?;
        let word = node.word(source, "`antecedent`")?;
        find_link(drafts, &word, self.index).map_err(|e| {
            let advice = match ancestors_return(source, drafts, self.index) {
                true => "; the antecedents run in a circle and never reach the base",
                false if e.contains("after") => "; write antecedents before what they carry",
                false => "",
            };
            source.at(node, format!("antecedent of link {}: {e}{advice}", self.label))
        })
    }

    /// The geometry of the link and its joint variable. The constant part of the variable is added to the geometry.
    pub(super) fn placement(
        &self,
        source: DescriptionFile,
        names: &KnownNames,
        passive: &mut Vec<PassiveCoordinate>,
    ) -> Result<(ModifiedDh, Affine), Error> {
        let what = format!("link {}", self.label);
        // Only a passive joint may lack its variable, because the loops then determine the variable.
        let unknown = match self.drive {
            Drive::Passive => {
                passive_coordinate(source, names, &self.fields, (self.kind, self.convention), &self.label, passive)?
            }
            _ => None,
        };
        let (geometry, variable) =
            placement(source, names, &self.fields, &what, (self.kind, self.convention), unknown)?;
        let node = self.variable_node().unwrap_or(self.node);
        let key = self.variable_key();
        // Rule for the variable of the joint. Actuated: one coordinate with the factor 1 or -1, plus a constant. Passive: any
        // sum of coordinates. Locked: a constant.
        match (self.kind, self.drive, &variable.terms[..]) {
            (JointKind::Fixed, _, _) | (_, Drive::Passive, _) | (_, Drive::Locked, []) => Ok((geometry, variable)),
            (_, Drive::Actuated, [(_, c)]) if c.abs() == 1.0 => Ok((geometry, variable)),
            (_, Drive::Actuated, _) => {
                let message = format!(
                    "{key} of link {} must be one coordinate, with the factor 1 or -1, plus a constant, because its \
                     joint is actuated; `drive: passive` follows coordinates, `drive: locked` holds a constant",
                    self.label
                );
                Err(source.at(node, message))
            }
            (_, Drive::Locked, _) => {
                let message = format!("{key} of link {} must be constant: its joint is locked", self.label);
                Err(source.at(node, message))
            }
        }
    }

    pub(super) fn rotor_inertia(
        &self,
        source: DescriptionFile,
        names: &KnownNames,
    ) -> Result<Option<RotorInertia>, Error> {
        use crate::format::node::NodeValue::Text;
        let Some(node) = self.fields.get("rotor_inertia") else { return Ok(None) };
        let rotor = match &node.content {
            Text(t) if t == "none" => RotorInertia::Absent,
            _ if self.kind == JointKind::Fixed => {
                return Err(source.at(node, format!("the joint of link {} is fixed: it has no rotor", self.label)));
            }
            Text(t) if t == "unknown" => RotorInertia::Unknown,
            _ => RotorInertia::Known(names.number(source, "`rotor_inertia` (none, unknown or a value)", node)?),
        };
        Ok(Some(rotor))
    }

    pub(super) fn friction(&self, source: DescriptionFile, names: &KnownNames) -> Result<Friction, Error> {
        let Some(node) = self.fields.get("friction") else { return Ok(Friction::default()) };
        let fields = node.fields(source, "the friction of a joint", &["viscous", "coulomb", "offset"])?;
        let number = |key: &str| fields.get(key).map(|n| names.number(source, key, n)).transpose();
        Ok(Friction { viscous: number("viscous")?, coulomb: number("coulomb")?, offset: number("offset")? })
    }

    pub(super) fn drive_gain(&self, source: DescriptionFile, names: &KnownNames) -> Result<Option<f64>, Error> {
        self.fields.get("drive_gain").map(|n| names.number(source, "`drive_gain`", n)).transpose()
    }

    pub(super) fn limits(&self, source: DescriptionFile, names: &KnownNames) -> Result<Option<Limits>, Error> {
        const KEYS: [&str; 7] =
            ["position", "position_deg", "velocity", "velocity_deg", "acceleration", "acceleration_deg", "effort"];
        let Some(node) = self.fields.get("limits") else { return Ok(None) };
        let fields = node.fields(source, "the limits of a joint", &KEYS)?;
        // The value of a key, or of the same key with the ending `_deg`, and the factor that converts it to SI units.
        let either = |key: &str| -> Result<Option<(&Node, f64)>, Error> {
            let degrees = format!("{key}_deg");
            match (fields.get(key), fields.get(&degrees)) {
                (Some(_), Some(n)) => {
                    Err(source.at(n, format!("`{degrees}` and `{key}` are both given: keep one of them")))
                }
                (Some(n), None) => Ok(Some((n, self.convention.si_of(self.kind, 1.0)))),
                (None, Some(n)) if self.kind == JointKind::Prismatic => {
                    Err(source.at(n, format!("the joint of link {} slides: `{key}` in m, not degrees", self.label)))
                }
                (None, Some(n)) => Ok(Some((n, std::f64::consts::PI / 180.0))),
                (None, None) => Ok(None),
            }
        };
        let magnitude = |key: &str, node: &Node| -> Result<f64, Error> {
            let x = names.number(source, key, node)?;
            if x >= 0.0 { Ok(x) } else { Err(source.at(node, format!("`{key}` limits a magnitude, found {x}"))) }
        };
        let scaled = |key: &str| -> Result<Option<f64>, Error> {
            either(key)?.map(|(n, factor)| Ok(factor * magnitude(key, n)?)).transpose()
        };
        let position = match either("position")? {
            None => None,
            Some((node, factor)) => {
                let [low, high] = node.list(source, "`position`")? else {
                    return Err(source.at(node, format!("`position` is [lowest, highest], found {}", node.kind())));
                };
                let low = names.number(source, "`position`", low)?;
                let high = names.number(source, "`position`", high)?;
                if low > high {
                    return Err(source.at(node, format!("`position` is [lowest, highest], found [{low}, {high}]")));
                }
                Some((factor * low, factor * high))
            }
        };
        let effort = fields.get("effort").map(|n| magnitude("effort", n)).transpose()?;
        Ok(Some(Limits { position, velocity: scaled("velocity")?, acceleration: scaled("acceleration")?, effort }))
    }
}

/// Whether the chain of antecedents of a link leads back to this link.
fn ancestors_return(source: DescriptionFile, drafts: &[Draft], start: usize) -> bool {
    let above = |j: usize| -> Option<usize> {
        let word = drafts[j].fields.get("antecedent")?.word(source, "").ok()?;
        drafts.iter().position(|d| d.label == word)
    };
    let mut j = start;
    for _ in 0..drafts.len() {
        match above(j) {
            Some(up) if up == start => return true,
            Some(up) => j = up,
            None => return false,
        }
    }
    false
}

/// The link with the label `word`, searched among the first `until` links. `None` for the base. Fails with a message if there is
/// no such link.
pub(super) fn find_link(drafts: &[Draft], word: &str, until: usize) -> Result<Option<LinkId>, String> {
    if word == "base" {
        return Ok(None);
    }
    match drafts.iter().position(|d| d.label == word) {
        Some(j) if j < until => Ok(Some(LinkId(j))),
        Some(_) => Err(format!("link {word} stands after what it carries")),
        None => {
            let meant = did_you_mean(word, drafts.iter().map(|d| d.label.as_str()).chain(["base"]));
            Err(format!("no link is called `{word}`{meant}"))
        }
    }
}
