//! Writes a robot as a .par file for SYMORO and OpenSYMORO; [`robot::format::read_par`] reads such files.
//!
//! Values of symbols are written as comments `(* Value D3 = 0.45 *)`. So they stay symbols in SYMORO and OpenSYMORO, and this
//! program can read their values. Each property that the format cannot express gets a note.

use std::fmt::Write;

use robot::format::written::{WrittenNames, tell_of_file};
use robot::{
    Affine, Drive, Inertial, JointKind, Limits, Link, LinkId, LoopFrame, ModifiedDh, Note, Robot, RotorInertia, Value,
};

/// The text of a .par file, and notes on the properties that the format cannot express.
pub fn write_par(robot: &Robot) -> (String, Vec<Note>) {
    let names = WrittenNames::new(robot, |name| allowed(name, ""), |_| false);
    let mut text = String::new();
    head(robot, &names, &mut text);
    geometric_parameters(robot, &names, &mut text);
    dynamic_parameters(robot, &mut text);
    symbolic_vectors(robot, &names, &mut text);
    let mut notes = Vec::new();
    tell(robot, &names, &mut notes);
    (text, notes)
}

/// Appends a line to the text; writing to a String cannot fail.
macro_rules! line {
    ($text:expr, $($part:tt)*) => {{ let _ = writeln!($text, $($part)*); }};
}

/// Writes name, source, numbers of links and joints, and the values of the symbols.
fn head(robot: &Robot, names: &WrittenNames, text: &mut String) {
    let (nl, nj) = (robot.links.len(), robot.links.len() + robot.loops.len());
    let is_simple = robot.links.iter().enumerate().all(|(j, l)| l.antecedent == j.checked_sub(1).map(LinkId));
    let kind = if nj > nl { 2 } else { usize::from(!is_simple) };
    line!(text, "(* Robotname = '{}' *)", robot_name(robot));
    if let Some(source) = &robot.source {
        line!(text, "(* {} *)", source.replace("*)", "* )"));
    }
    line!(text, "NL = {nl}\nNJ = {nj}\nNF = {}\nType = {kind}\nis_mobile = 0\n", 2 * nj - nl);
    for (symbol, name) in robot.symbols.iter().zip(&names.symbols) {
        if !symbol.generic {
            line!(text, "(* Value {name} = {} *)", names.value(&symbol.value));
        }
    }
}

/// Writes the geometric table: one list per parameter, with one entry per frame. The frames of the links come first, then the
/// cuts of loops, then their twins (the frames on the other side of each cut).
fn geometric_parameters(robot: &Robot, names: &WrittenNames, text: &mut String) {
    let cuts = robot.loops.iter().map(|l| ParFrame::of_loop(&l.cut));
    let twins = robot.loops.iter().map(|l| ParFrame::of_loop(&l.twin));
    let frames: Vec<ParFrame> = robot.links.iter().map(ParFrame::of_link).chain(cuts).chain(twins).collect();
    line!(text, "\n(* Geometric parameters *)");
    let row = |of: &dyn Fn(&ParFrame) -> String| frames.iter().map(of).collect::<Vec<_>>().join(",");
    line!(text, "ant = {{{}}}", row(&|f| f.antecedent.map_or(0, |i| i.0 + 1).to_string()));
    line!(text, "sigma = {{{}}}", row(&|f| f.sigma().to_string()));
    line!(text, "mu = {{{}}}", row(&|f| usize::from(f.drive == Drive::Actuated).to_string()));
    let constant = |v: &Value| names.value(v);
    let moved = |f: &ParFrame, v: &Value, kind: JointKind| match f.sigma() {
        2 => constant(v),
        _ if f.kind == kind => names.variable(f.variable, v),
        _ => constant(v),
    };
    line!(text, "gamma = {{{}}}", row(&|f| constant(&f.geometry.gamma)));
    line!(text, "b = {{{}}}", row(&|f| constant(&f.geometry.b)));
    line!(text, "alpha = {{{}}}", row(&|f| constant(&f.geometry.alpha)));
    line!(text, "d = {{{}}}", row(&|f| constant(&f.geometry.d)));
    line!(text, "theta = {{{}}}", row(&|f| moved(f, &f.geometry.theta, JointKind::Revolute)));
    line!(text, "r = {{{}}}", row(&|f| moved(f, &f.geometry.r, JointKind::Prismatic)));
}

/// Writes the lists of inertias, rotor inertias, friction and external forces (zero). Each list has one entry per link.
fn dynamic_parameters(robot: &Robot, text: &mut String) {
    line!(text, "\n(* Dynamic parameters *)");
    let of_links = |of: &dyn Fn(usize, &Link) -> String| {
        robot.links.iter().enumerate().map(|(j, l)| of(j, l)).collect::<Vec<_>>().join(",")
    };
    for (k, inertial) in Inertial::BODY.into_iter().enumerate() {
        let letters = inertial.letters();
        let value = |j: usize, l: &Link| l.inertial.map_or(format!("{letters}{}", j + 1), |x| x[k].to_string());
        line!(text, "{letters} = {{{}}}", of_links(&value));
    }
    let rotor = |j: usize, l: &Link| match l.joint.rotor_inertia {
        RotorInertia::Absent => "0".into(),
        RotorInertia::Unknown => format!("IA{}", j + 1),
        RotorInertia::Known(x) => x.to_string(),
    };
    line!(text, "IA = {{{}}}", of_links(&rotor));
    let number = |x: Option<f64>| x.map_or("0".to_string(), |x| x.to_string());
    line!(text, "FV = {{{}}}", of_links(&|_, l| number(l.joint.friction.viscous)));
    line!(text, "FS = {{{}}}", of_links(&|_, l| number(l.joint.friction.coulomb)));
    let zeros = vec!["0"; robot.links.len()].join(",");
    for key in ["FX", "FY", "FZ", "CX", "CY", "CZ"] {
        line!(text, "{key} = {{{zeros}}}");
    }
}

/// Writes symbols for joint rates, torques, the motion of the base, and gravity, because SYMORO and OpenSYMORO expect these
/// entries.
fn symbolic_vectors(robot: &Robot, names: &WrittenNames, text: &mut String) {
    line!(text, "\n(* Joint parameters *)");
    for letters in ["QP", "QDP", "GAM"] {
        let joints = 1..=robot.links.len() + robot.loops.len();
        let symbols: Vec<String> = joints.map(|j| format!("{letters}{j}")).collect();
        line!(text, "{letters} = {{{}}}", symbols.join(","));
    }
    line!(text, "\n(* Speed and acceleration of the base *)");
    for key in ["W0", "WP0", "V0", "VP0"] {
        line!(text, "{key} = {{0,0,0}}");
    }
    let [x, y, z] = robot.gravity.each_ref().map(|v| names.value(v));
    line!(text, "\n(* Acceleration of gravity *)\nG = {{{x},{y},{z}}}");
    line!(text, "\n(* Transformation of 0 frame position fT0 *)\nZ = {{1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1}}");
    line!(text, "\n(* End of definition *)");
}

/// A row of the geometric table: a link, or a frame of a loop.
struct ParFrame<'a> {
    antecedent: Option<LinkId>,
    geometry: &'a ModifiedDh,
    kind: JointKind,
    drive: Drive,
    variable: &'a Affine,
}

impl<'a> ParFrame<'a> {
    fn of_link(link: &'a Link) -> ParFrame<'a> {
        let joint = &link.joint;
        ParFrame {
            antecedent: link.antecedent,
            geometry: &link.geometry,
            kind: joint.kind,
            drive: joint.drive,
            variable: &joint.variable,
        }
    }

    fn of_loop(frame: &'a LoopFrame) -> ParFrame<'a> {
        let LoopFrame { antecedent, geometry, kind, variable } = frame;
        ParFrame { antecedent: *antecedent, geometry, kind: *kind, drive: Drive::Passive, variable }
    }

    /// The type of the joint in a .par file: 0 revolute, 1 prismatic, 2 fixed. A locked joint is written as fixed.
    fn sigma(&self) -> usize {
        match self.kind {
            _ if self.variable.terms.is_empty() => 2,
            JointKind::Revolute => 0,
            JointKind::Prismatic => 1,
            JointKind::Fixed => 2,
        }
    }
}

fn robot_name(robot: &Robot) -> String {
    allowed(robot.name.trim(), " -")
}

fn allowed(name: &str, also: &str) -> String {
    let keep = |c: char| c.is_ascii_alphanumeric() || c == '_' || also.contains(c);
    name.chars().map(|c| if keep(c) { c } else { '_' }).collect()
}

/// Adds notes on the properties that the format cannot express.
fn tell(robot: &Robot, names: &WrittenNames, notes: &mut Vec<Note>) {
    let mut note = |subject: &str, text: String| notes.push(Note { subject: subject.into(), text });
    if robot_name(robot) != robot.name {
        note("name", format!("the robot is called {} in the file", robot_name(robot)));
    }
    // Notes on links and joints.
    for (j, link) in robot.links.iter().enumerate() {
        let joint = &link.joint;
        if link.label != (j + 1).to_string() || link.name != format!("link {}", j + 1) {
            note(&link.name, format!("names are not carried: it is link {} in the file", j + 1));
        }
        if joint.kind != JointKind::Fixed && joint.variable.terms.is_empty() {
            note(&link.name, "its joint is locked: written as fixed (sigma = 2)".into());
        }
        if joint.friction.offset.is_some() {
            note(&link.name, "the offset of its friction is not carried".into());
        }
        if joint.drive_gain.is_some() {
            note(&link.name, "its drive gain is not carried".into());
        }
        tell_of_file(link, &mut note);
    }
    // Notes on coordinates and symbols.
    for (k, coordinate) in robot.coordinates.iter().enumerate() {
        if coordinate.limits != Limits::default() {
            note(&coordinate.name, "its limits are not carried".into());
        }
        if names.coordinates[k] != coordinate.name {
            note(&coordinate.name, format!("the coordinate is called {} in the file", names.coordinates[k]));
        }
    }
    for (symbol, name) in robot.symbols.iter().zip(&names.symbols) {
        if symbol.name != *name {
            note(&symbol.name, format!("the symbol is called {name} in the file"));
        }
    }
}
