//! Reads a robot from a .par file of SYMORO, SYMORO+ or OpenSYMORO.
//!
//! The pose of frame j in its antecedent is iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r) [Khalil, Kleinfinger 1986].
//! Frames 1..NL belong to links. Frames NL+1..NJ belong to the cut joints of loops. Frames NJ+1..NF are the twins of these frames
//! on the other side of the cut. The relations of the passive joints are found by [`crate::passive`].
//!
//! A file may contain symbols without values. Lengths and angles then get substitute values, derived from their names. This does
//! not change the base parameters and their rules (linear combinations of standard parameters), which are equal for nearly all
//! values. Gravity gets -9.81 m/s^2. Such symbols are marked [`Symbol::generic`] and listed in a note. Numerical results need
//! true values, which the file may give as `(* Value D3 = 0.45 *)`. A parameter (XX .. FS) of 0 is a known zero, and a rotor
//! inertia of 0 is absent.
//!
//! Refused: floating and mobile bases. Ignored, with a note if they are numbers: elastic joints, the pose Z of the base, external
//! wrenches.

use std::collections::BTreeSet;

use super::angles::{within_a_turn, within_turns};
use super::carried::{LumpedFrames, carriers, product};
use super::generic::{define_generic, note_generic};
use super::parameters::{friction, inertial, note_unused, rotor_inertia};
use super::table::{ParTable, text};
use super::text::{ParText, scan};
use super::variables::{Mover, own_variables, passive_by_its_joint};
use crate::angle_snap::snap_angles;
use crate::closure;
use crate::error::Error;
use crate::format::expression::{KnownNames, identifiers, is_name};
use crate::format::node::{DescriptionFile, Node, NodeValue};
use crate::format::options::ReadOptions;
use crate::passive;
use crate::robot::{
    Coordinate, Drive, Joint, JointKind, Limits, Link, LinkId, Loop, LoopFrame, ModifiedDh, Note, PassiveCoordinate,
    Robot,
};
use crate::value::Affine;
use crate::value::Value;

/// Reads a robot from the text of a .par file. `file`: name of the file in errors.
///
/// Fails, with line and column, if the table is incomplete or inconsistent, if the base moves, or if a loop cannot close.
pub fn read_par(text: &str, file: &str) -> Result<Robot, Error> {
    read_par_with(text, file, ReadOptions::default())
}

/// Reads a robot from the text of a .par file as [`read_par`] does, with options.
pub(in crate::format) fn read_par_with(text: &str, file: &str, options: ReadOptions) -> Result<Robot, Error> {
    let source = DescriptionFile { file };
    let mut notes = Vec::new();
    // The frames are read and sorted: antecedents come first.
    let entries = scan(source, text)?;
    let table = ParTable::new(source, &entries, &mut notes)?;
    let frames = Frames::new(&table)?;
    let order = frames.order(&table)?;

    // Symbols without a value get substitute values, which a note lists.
    let mut names = valued_symbols(source, &entries)?;
    let owners = frames.owners(source, &table, &names, &mut notes)?;
    names.coordinates = owners.coordinates.iter().chain(&owners.passive).cloned().collect();
    let gravity = table.list("G").map_or_else(|| ["0", "0", "GZ"].map(worded).to_vec(), <[Node]>::to_vec);
    let named = names.symbols.len();
    define_generic(frames.geometry.iter().flatten(), &gravity, &mut names);
    names.set_values(source, options.values)?;
    notes.extend(note_generic(&names.symbols[named..]));

    let mut links = Vec::with_capacity(table.nl);
    for &j in &order {
        links.push(link(source, &table, &frames, &order, &names, &owners, j, &mut notes)?);
    }
    let mut loops = Vec::new();
    // The frame of a cut and its twin (the fixed frame on the other side of the cut) are the two frames of one loop.
    for cut in table.nl..table.nj {
        let frame = |k: usize| -> Result<LoopFrame, Error> {
            let (kind, _, geometry, variable) = frames.placed(source, &names, &owners, k)?;
            Ok(LoopFrame { antecedent: frames.antecedent(&order, k), geometry, kind, variable })
        };
        loops.push(Loop { cut: frame(cut)?, twin: frame(cut + table.nj - table.nl)? });
    }
    let component = |n: &Node| names.constant(source, "a component of `G`", n);
    let gravity = [component(&gravity[0])?, component(&gravity[1])?, component(&gravity[2])?];
    note_unused(&table, &mut notes);
    let stem = std::path::Path::new(file).file_stem().and_then(|s| s.to_str()).unwrap_or("robot");
    let mut robot = Robot {
        name: entries.name.clone().unwrap_or(stem.into()),
        symbols: names.symbols,
        coordinates: owners
            .coordinates
            .into_iter()
            .map(|name| Coordinate { name, limits: Limits::default() })
            .collect(),
        passive: owners.passive.into_iter().map(|name| PassiveCoordinate { name, start: 0.0 }).collect(),
        links,
        loops,
        gravity,
        notes,
        ..Robot::default()
    };
    // These functions need the whole robot: relations of passive joints, exact angles, and the check that loops close.
    passive_by_its_joint(&mut robot);
    snap_angles(&mut robot, options.angles);
    let place = || table.at("ant", String::new()).place;
    passive::resolve(&mut robot).map_err(|message| Error { place: place(), message })?;
    closure::check(&robot).map_err(|(_, message)| Error { place: place(), message })?;
    Ok(robot)
}

/// The symbols that get values in comments of the file.
fn valued_symbols(source: DescriptionFile, entries: &ParText) -> Result<KnownNames, Error> {
    let mut names = KnownNames::default();
    for (name, node) in &entries.values {
        if !is_name(name) || names.symbols.iter().any(|s| s.name == *name) {
            return Err(source.at(node, format!("`{name}` cannot name a symbol, or stands twice")));
        }
        names.define(source, name.clone(), node)?;
    }
    Ok(names)
}

/// The link that has frame j, and the joint that moves it.
fn link(
    source: DescriptionFile,
    table: &ParTable,
    frames: &Frames,
    order: &[usize],
    names: &KnownNames,
    owners: &Owners,
    j: usize,
    notes: &mut Vec<Note>,
) -> Result<Link, Error> {
    let (kind, drive, geometry, variable) = frames.placed(source, names, owners, j)?;
    let label = (j + 1).to_string();
    let joint = Joint {
        rotor_inertia: rotor_inertia(source, table, names, j, drive)?,
        friction: friction(source, table, names, j)?,
        ..Joint::bare(label.clone(), kind, drive, variable)
    };
    Ok(Link {
        name: format!("link {label}"),
        inertial: inertial(source, table, names, j, notes)?,
        ..Link::bare(label, frames.antecedent(order, j), geometry, joint)
    })
}

/// The frames of the file, indexed from zero.
struct Frames {
    /// Number of the link that carries each frame; zero for the base.
    antecedent: Vec<usize>,
    /// For each frame, the twins (fixed frames on the other side of loop cuts) on the path to its link, the nearest first.
    through: Vec<Vec<usize>>,
    kind: Vec<JointKind>,
    actuated: Vec<bool>,
    /// gamma, b, alpha, d, theta and r of each frame.
    geometry: Vec<[Node; 6]>,
    n_links: usize,
    n_joints: usize,
}

/// The keys of the lists with the geometry of the frames.
const GEOMETRY_KEYS: [&str; 6] = ["gamma", "b", "alpha", "d", "theta", "r"];

/// Names of the joint variables, in the order of q: first the coordinates, then the passive coordinates.
struct Owners {
    coordinates: Vec<String>,
    passive: Vec<String>,
    /// For each frame, whether its variable is a coordinate. This is so if the joint has a motor, or if it has no motor and is
    /// outside of all loops.
    is_coordinate: Vec<bool>,
}

impl Frames {
    fn new(table: &ParTable) -> Result<Frames, Error> {
        // The antecedent of a frame is a link, the base, or a loop frame. If the list is missing, the antecedent is the
        // previous frame.
        let antecedent = table.integers("ant", 0, table.nf, |j| (j - 1).min(table.nl))?;
        let LumpedFrames { link: antecedent, through } = carriers(&antecedent, table.nl, table.nj).map_err(|j| {
            let message = format!("the antecedents of frame {} run in a circle and never reach a link", j + 1);
            table.at_item("ant", j, message)
        })?;
        // The twin of a cut is fixed to its link (sigma = 2, the default), because the joint of the loop moves the frame of the
        // cut.
        let twin = |j: usize| j > table.nj;
        let sigma = table.integers("sigma", 0, 2, |j| if twin(j) { 2 } else { 0 })?;
        let actuated = table.integers("mu", 0, 1, |j| usize::from(!twin(j)))?;
        if let Some(j) = (table.nj..table.nf).find(|&j| sigma[j] != 2) {
            let message = format!(
                "sigma of frame {} is 2, found {}: it is the twin of a cut, fixed to its link",
                j + 1,
                sigma[j]
            );
            return Err(table.at_item("sigma", j, message));
        }
        // Defaults of missing lists: theta of a revolute frame is its own variable, for example `th3`; all other values are 0.
        let node = |key: &str, j: usize| match table.list(key) {
            Some(items) => items[j].clone(),
            None if key == "theta" && sigma[j] == 0 => worded(&format!("th{}", j + 1)),
            None => worded("0"),
        };
        Ok(Frames {
            antecedent,
            through,
            kind: sigma.iter().map(|s| [JointKind::Revolute, JointKind::Prismatic, JointKind::Fixed][*s]).collect(),
            actuated: actuated.iter().map(|m| *m == 1).collect(),
            geometry: (0..table.nf).map(|j| GEOMETRY_KEYS.map(|key| node(key, j))).collect(),
            n_links: table.nl,
            n_joints: table.nj,
        })
    }

    /// Indices of the links, an antecedent (parent) before its successors, otherwise in the order of their numbers. Fails if the
    /// antecedents are circular.
    fn order(&self, table: &ParTable) -> Result<Vec<usize>, Error> {
        let mut order: Vec<usize> = Vec::with_capacity(self.n_links);
        let mut placed = vec![false; self.n_links];
        while order.len() < self.n_links {
            let stands = |placed: &[bool], j: usize| self.antecedent[j].checked_sub(1).is_none_or(|i| placed[i]);
            let Some(j) = (0..self.n_links).find(|&j| !placed[j] && stands(&placed, j)) else {
                let stuck = (0..self.n_links).find(|&j| !placed[j]).unwrap_or_default();
                let message = format!("the antecedents of link {} run in a circle and never reach the base", stuck + 1);
                return Err(table.at_item("ant", stuck, message));
            };
            placed[j] = true;
            order.push(j);
        }
        Ok(order)
    }

    fn antecedent(&self, order: &[usize], j: usize) -> Option<LinkId> {
        let number = self.antecedent[j].checked_sub(1)?;
        order.iter().position(|&i| i == number).map(LinkId)
    }

    fn variable(&self, j: usize) -> Option<&Node> {
        match self.kind[j] {
            JointKind::Revolute => Some(&self.geometry[j][4]),
            JointKind::Prismatic => Some(&self.geometry[j][5]),
            JointKind::Fixed => None,
        }
    }

    /// The constants of a frame: its geometry parameters except the joint variable.
    fn constants(&self, j: usize) -> impl Iterator<Item = &Node> {
        let moving = self.variable(j).map(|v| (v.line, v.column));
        self.geometry[j].iter().filter(move |n| n.line > 0 && Some((n.line, n.column)) != moving)
    }

    fn owners(
        &self,
        source: DescriptionFile,
        table: &ParTable,
        names: &KnownNames,
        notes: &mut Vec<Note>,
    ) -> Result<Owners, Error> {
        let nf = self.kind.len();
        let mut constants: BTreeSet<&str> = names.symbols.iter().map(|s| s.name.as_str()).collect();
        for j in 0..nf {
            for node in self.constants(j) {
                constants.extend(identifiers(text(node)));
            }
        }
        constants.extend(table.list("G").into_iter().flatten().flat_map(|n| identifiers(text(n))));
        // An undriven joint outside of every loop is also a coordinate, because nothing else determines its position.
        let mut in_loop = vec![false; nf];
        for k in self.n_links..nf {
            in_loop[k] = true;
            let mut j = self.antecedent[k];
            while j > 0 {
                in_loop[j - 1] = true;
                j = self.antecedent[j - 1];
            }
        }
        let is_coordinate: Vec<bool> = (0..nf).map(|j| self.actuated[j] || !in_loop[j]).collect();
        let moving: Vec<usize> = (0..self.n_joints).filter(|&j| self.variable(j).is_some()).collect();
        let movers: Vec<Mover> = moving
            .iter()
            .filter_map(|&j| self.variable(j).map(|variable| (j, variable)))
            .map(|(j, variable)| Mover { frame: j + 1, actuated: self.actuated[j], variable })
            .collect();
        let own = own_variables(source, &movers, &constants)?;
        let mut owners = Owners { coordinates: Vec::new(), passive: Vec::new(), is_coordinate };
        let mut unactuated = Vec::new();
        for (&j, name) in moving.iter().zip(own) {
            let Some(name) = name else {
                owners.is_coordinate[j] = false;
                continue;
            };
            if !owners.is_coordinate[j] {
                owners.passive.push(name);
                continue;
            }
            if !self.actuated[j] {
                unactuated.push((j + 1).to_string());
            }
            owners.coordinates.push(name);
        }
        if owners.coordinates.is_empty() {
            return Err(source.error(0, 0, "no joint moves with a variable of its own and mu = 1"));
        }
        if !unactuated.is_empty() {
            let text =
                format!("0 for joints {} outside every loop: they are coordinates all the same", unactuated.join(", "));
            notes.push(Note { subject: "mu".into(), text });
        }
        Ok(owners)
    }

    fn placed(
        &self,
        source: DescriptionFile,
        names: &KnownNames,
        owners: &Owners,
        j: usize,
    ) -> Result<(JointKind, Drive, ModifiedDh, Affine), Error> {
        let kind = self.kind[j];
        let mut variable = Affine::constant(Value::ZERO);
        // Index of the joint variable in (gamma, b, alpha, d, theta, r): 4 for theta, 5 for r, 6 if there is none.
        let moving = match kind {
            JointKind::Revolute => 4,
            JointKind::Prismatic => 5,
            JointKind::Fixed => 6,
        };
        let mut values = Vec::with_capacity(6);
        for (k, (key, node)) in GEOMETRY_KEYS.into_iter().zip(&self.geometry[j]).enumerate() {
            let what = format!("{key} of frame {}", j + 1);
            if k != moving {
                values.push(within_a_turn(source, names, (key, &what), node, names.constant(source, &what, node)?)?);
                continue;
            }
            // The expression is affine in the coordinates: its linear part is the joint variable, and its constant part is added
            // to the geometry.
            let value = names.variable(source, &what, node)?;
            let affine = Affine::from_value(&value, &names.symbols).ok_or_else(|| {
                source.at(node, format!("{what} must be affine in the joint variables, found {}", node.kind()))
            })?;
            names.finite(source, &what, node, affine.offset.number(&names.symbols))?;
            for (_, coefficient) in &affine.terms {
                names.finite(source, &what, node, *coefficient)?;
            }
            variable.terms = affine.terms;
            values.push(within_a_turn(source, names, (key, &what), node, affine.offset)?);
        }
        let drive = match (&variable.terms[..], owners.is_coordinate[j]) {
            ([], _) => Drive::Locked,
            (_, false) => Drive::Passive,
            ([(_, c)], true) if c.abs() == 1.0 => Drive::Actuated,
            _ => {
                let node = &self.geometry[j][moving.min(5)];
                let message =
                    format!("the variable of joint {} stands alone, with the factor 1 or -1, plus a constant", j + 1);
                return Err(source.at(node, message));
            }
        };
        let [gamma, b, alpha, d, theta, r]: [Value; 6] = values.try_into().unwrap_or([const { Value::ZERO }; 6]);
        let own = ModifiedDh { gamma, b, alpha, d, theta, r };
        Ok((kind, drive, self.on_its_link(source, names, j, own)?, variable))
    }

    /// The placement of frame j relative to its link. It includes the twins of loops between the link and the frame.
    fn on_its_link(
        &self,
        source: DescriptionFile,
        names: &KnownNames,
        j: usize,
        own: ModifiedDh,
    ) -> Result<ModifiedDh, Error> {
        let mut placement = own;
        // For each twin t, the nearest first: placement = (placement of t in its antecedent) placement. After the last twin,
        // the antecedent is the link or the base.
        for &twin in &self.through[j] {
            let mut values = Vec::with_capacity(6);
            for (key, node) in GEOMETRY_KEYS.into_iter().zip(&self.geometry[twin]) {
                let what = format!("{key} of frame {}", twin + 1);
                values.push(within_a_turn(source, names, (key, &what), node, names.constant(source, &what, node)?)?);
            }
            let [gamma, b, alpha, d, theta, r]: [Value; 6] = values.try_into().unwrap_or([const { Value::ZERO }; 6]);
            let twin_placement = ModifiedDh { gamma, b, alpha, d, theta, r };
            placement = product(twin_placement, placement, &names.symbols).ok_or_else(|| {
                let on = match self.antecedent[j] {
                    0 => "the base, 0".to_string(),
                    link => format!("link {link}"),
                };
                source.whole(format!(
                    "frame {} stands on the frame of a loop, {}, and both turn about other axes than z: give the symbols \
                     values in comments `(* Value {} = 0.45 *)`, or place frame {0} from {on}",
                    j + 1,
                    twin + 1,
                    names.symbols.iter().find(|s| s.generic).map_or("L", |s| &s.name)
                ))
            })?;
        }
        Ok(within_turns(placement, &names.symbols))
    }
}

fn worded(text: &str) -> Node {
    Node { line: 0, column: 0, content: NodeValue::Text(text.into()) }
}
