//! The convention of the frames in a YAML description: the Denavit-Hartenberg table and the units.
//!
//! Every table is converted to the six parameters of Khalil and Kleinfinger:
//!
//! | `convention` | row of joint i | converted to |
//! |---|---|---|
//! | `khalil-kleinfinger` | gamma b alpha d theta r | itself |
//! | `craig` | alpha_(i-1) a_(i-1) d_i theta_i | alpha, d, r, theta: the frames are equal |
//! | `denavit-hartenberg` | theta_i d_i a_i alpha_i | theta and r of link i; alpha and d of the links that link i carries |
//!
//! In the table `denavit-hartenberg`, frame i is at the far end of link i: its pose in our frame i is Tx(a_i) Rx(alpha_i). The
//! file gives the body of link i in this far frame: A_i = Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i) [Denavit, Hartenberg 1955].

use std::f64::consts::PI;

use crate::angle_snap::{AngleSnapping, computed_angle, given_angle};
use crate::error::Error;
use crate::format::node::{DescriptionFile, Fields, Node, NodeValue};
use crate::inertial::Pose;
use crate::kinematics::sin_cos;
use crate::robot::{JointKind, Link, ModifiedDh, Note, Robot};
use crate::value::{Symbol, Value};
use crate::vector::rotation_by;
use gate::suggestion::did_you_mean;

/// If a length in a table is larger than this value (m), its unit is probably mm.
const LONGEST_LENGTH_M: f64 = 20.0;
/// Number of millimetres per metre.
const MM_PER_M: f64 = 1000.0;

/// The kind of Denavit-Hartenberg table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DhTable {
    KhalilKleinfinger,
    Craig,
    DenavitHartenberg,
}

/// The table and the units of a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Convention {
    table: DhTable,
    degrees: bool,
    millimetres: bool,
}

/// The values of the key `convention`. The values after the third are other names of the table `denavit-hartenberg`.
const CONVENTIONS: [(&str, DhTable); 7] = [
    ("khalil-kleinfinger", DhTable::KhalilKleinfinger),
    ("craig", DhTable::Craig),
    ("denavit-hartenberg", DhTable::DenavitHartenberg),
    ("standard", DhTable::DenavitHartenberg),
    ("classical", DhTable::DenavitHartenberg),
    ("distal", DhTable::DenavitHartenberg),
    ("paul", DhTable::DenavitHartenberg),
];

impl Convention {
    /// Reads the `convention` of a description. Units are SI until [`Convention::with_units`] is called. Fails if the
    /// convention is missing or unknown.
    pub(super) fn of(source: DescriptionFile, root: &Node) -> Result<Convention, Error> {
        let entries = root.map(source, "a robot description")?;
        let Some((_, node)) = entries.iter().find(|(k, _)| k.text == "convention") else {
            let near = did_you_mean("convention", entries.iter().map(|(k, _)| k.text.as_str()));
            let message = "`convention` is missing: Denavit-Hartenberg parameters mean nothing before it is named: \
                           khalil-kleinfinger, craig or denavit-hartenberg";
            return Err(source.at(root, format!("{message}{}", near.replace("did you mean", "found"))));
        };
        let known = CONVENTIONS.iter().find(|known| matches!(&node.content, NodeValue::Text(t) if t == known.0));
        match known {
            Some((_, table)) => Ok(Convention { table: *table, degrees: false, millimetres: false }),
            None => {
                let meant = match &node.content {
                    NodeValue::Text(text) => did_you_mean(text, CONVENTIONS.iter().map(|known| known.0)),
                    _ => String::new(),
                };
                let message = format!(
                    "the convention {} is not read: expected `khalil-kleinfinger`, `craig` or `denavit-hartenberg`{meant}",
                    node.kind()
                );
                Err(source.at(node, message))
            }
        }
    }

    /// Adds the units from the keys `angles` and `lengths` to this convention.
    pub(super) fn with_units(mut self, source: DescriptionFile, fields: &Fields) -> Result<Convention, Error> {
        if let Some(node) = fields.get("angles") {
            self.degrees = node.choice(source, "`angles`", &["rad", "deg"])? == 1;
        }
        if let Some(node) = fields.get("lengths") {
            self.millimetres = node.choice(source, "`lengths`", &["m", "mm"])? == 1;
        }
        Ok(self)
    }

    /// The number of units of the file per rad or m, for one of gamma, b, alpha, d, theta, r.
    pub(super) fn per_si(self, parameter: &str) -> f64 {
        match matches!(parameter, "gamma" | "alpha" | "theta") {
            true if self.degrees => 180.0 / PI,
            false if self.millimetres => MM_PER_M,
            _ => 1.0,
        }
    }

    /// A quarter turn in the unit of the file.
    pub(super) fn quarter_turn(self) -> &'static str {
        if self.degrees { "90" } else { "pi/2" }
    }

    /// Whether the parameter of a link stands in the row of its antecedent.
    pub(super) fn is_far(self, parameter: &str) -> bool {
        self.table == DhTable::DenavitHartenberg && matches!(parameter, "alpha" | "d")
    }

    /// The keys of a link's placement in this table.
    pub(super) fn placement_keys(self) -> &'static [&'static str] {
        match self.table {
            DhTable::KhalilKleinfinger => &["gamma", "b", "alpha", "d", "theta", "r"],
            _ => &["alpha", "a", "theta", "d"],
        }
    }

    /// The key that stands in this table for one of gamma, b, alpha, d, theta, r; `None` if the table does not have this
    /// parameter.
    pub(super) fn key(self, parameter: &str) -> Option<&'static str> {
        match (self.table, parameter) {
            (_, "alpha") => Some("alpha"),
            (_, "theta") => Some("theta"),
            (DhTable::KhalilKleinfinger, "gamma") => Some("gamma"),
            (DhTable::KhalilKleinfinger, "b") => Some("b"),
            (DhTable::KhalilKleinfinger, "d") => Some("d"),
            (DhTable::KhalilKleinfinger, "r") => Some("r"),
            (_, "d") => Some("a"),
            (_, "r") => Some("d"),
            _ => None,
        }
    }

    /// The key of the joint variable for this type of joint.
    pub(super) fn variable_key(self, kind: JointKind) -> &'static str {
        self.key(if kind == JointKind::Prismatic { "r" } else { "theta" }).unwrap_or("theta")
    }

    /// Converts the value of one of gamma, b, alpha, d, theta, r to rad or m.
    pub(super) fn si(self, parameter: &str, value: Value) -> Value {
        let is_angle = matches!(parameter, "gamma" | "alpha" | "theta");
        let number = |x: f64| Box::new(Value::Number(x));
        match value {
            _ if is_angle && !self.degrees || !is_angle && !self.millimetres => value,
            // A multiple of pi/12 (up to half a turn) is converted exactly.
            Value::Number(x) if is_angle => computed_angle_of_any_turn(x),
            Value::Number(x) => Value::Number(x / MM_PER_M),
            value if is_angle => Value::Div(Box::new(Value::Mul(Box::new(value), Box::new(Value::Pi))), number(180.0)),
            value => Value::Div(Box::new(value), number(MM_PER_M)),
        }
    }

    /// Converts a position or a rate of a joint from the units of the file to rad or m. `kind`: type of the joint.
    pub(super) fn si_of(self, kind: JointKind, x: f64) -> f64 {
        match kind {
            JointKind::Prismatic if self.millimetres => x / MM_PER_M,
            JointKind::Revolute if self.degrees => x * PI / 180.0,
            _ => x,
        }
    }

    pub(super) fn length(self, x: f64) -> f64 {
        if self.millimetres { x / MM_PER_M } else { x }
    }

    /// The message if an angle exceeds a full turn; otherwise `None`.
    pub(super) fn refused_angle(self, angle: &Value, symbols: &[Symbol]) -> Option<String> {
        let x = angle.beyond_a_turn(symbols)?;
        let advice = if self.degrees { "write it within one turn" } else { "degrees are read with `angles: deg`" };
        Some(format!("is {x:.4} rad, more than a whole turn: {advice}"))
    }

    /// For the table `denavit-hartenberg`: moves alpha and a of each link (given at its far end) to the links that it carries.
    /// Returns, for each link, the pose of its far frame in the link frame.
    pub(super) fn to_near_ends(self, robot: &mut Robot, angles: AngleSnapping) -> Vec<Pose> {
        if self.table != DhTable::DenavitHartenberg {
            return vec![Pose::IDENTITY; robot.links.len()];
        }
        let far: Vec<(Value, Value)> =
            robot.links.iter().map(|l| (l.geometry.alpha.clone(), l.geometry.d.clone())).collect();
        for link in &mut robot.links {
            let (alpha, d) = link.antecedent.map_or((Value::ZERO, Value::ZERO), |i| far[i.0].clone());
            link.geometry = ModifiedDh { alpha, d, ..link.geometry.clone() };
        }
        let place = |(alpha, a): &(Value, Value)| {
            let meant = match alpha.as_multiple_of_pi(&robot.symbols) {
                Some(_) => alpha.clone(),
                None => given_angle(alpha.number(&robot.symbols), angles),
            };
            let rotation = rotation_by([1.0, 0.0, 0.0], sin_cos(&meant, &robot.symbols));
            Pose { rotation, position: [a.number(&robot.symbols), 0.0, 0.0] }
        };
        let places: Vec<Pose> = far.iter().map(place).collect();
        for (link, place) in robot.links.iter_mut().zip(&places) {
            link.file_frame = *place;
            link.frames = vec![(link.name.clone(), *place)];
        }
        places
    }

    /// A note if the longest length of a table is too long for a robot; otherwise `None`.
    pub(super) fn far_away(self, robot: &Robot) -> Option<Note> {
        let lengths = |link: &Link| {
            [&link.geometry.b, &link.geometry.d, &link.geometry.r].map(|v| v.number(&robot.symbols).abs())
        };
        let longest = |link: &Link| lengths(link).into_iter().fold(0.0, f64::max);
        let link = robot.links.iter().max_by(|a, b| longest(a).total_cmp(&longest(b)))?;
        let length = longest(link);
        let text = format!("a length of it is {length} m: millimetres are read with `lengths: mm`");
        (length > LONGEST_LENGTH_M).then(|| Note { subject: format!("link {}", link.label), text })
    }

    /// Whether the table can describe loops. A table with frames at the far ends of links cannot.
    pub(super) fn has_loops(self) -> bool {
        self.table != DhTable::DenavitHartenberg
    }
}

/// Converts an angle in degrees to rad. A multiple of pi/12 is exact, up to half a turn.
fn computed_angle_of_any_turn(degrees: f64) -> Value {
    let angle = degrees * PI / 180.0;
    if angle.abs() <= PI { computed_angle(angle) } else { Value::Number(angle) }
}
