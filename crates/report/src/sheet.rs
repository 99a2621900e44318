//! The data sheet of a robot: its links, the base parameters of each link with meaning, value and rule, and the base parameters
//! that contain the inertial parameters of each link. [`crate::robot`] writes the sheet as text, Markdown, LaTeX and HTML.
//!
//! A regrouping rule states how a base parameter follows from standard parameters (the ten inertial parameters of each link,
//! and rotor inertias). The variables of a robot are its coordinates and the passive joints of its loops.

use std::collections::BTreeMap;

use expr::Count;
use modeling::{BaseParameters, Rules};
use robot::value::CoordinateId;
use robot::{Inertial, JointKind, Link, LinkId, Robot, Value};
use serde::Serialize;

use crate::drawing::Drawing;
use crate::number::significant;

/// The content of the sheet of a robot.
#[derive(Clone, Debug, Serialize)]
pub struct Sheet {
    /// Name of the robot.
    pub name: String,
    /// The size of the robot in words: `2 links, 2 coordinates, 1 loop`.
    pub summary: String,
    /// Source of the robot description; `None` if the description states no source.
    pub source: Option<String>,
    /// Notes on values that were guessed or replaced when the description was read.
    pub notes: Vec<String>,
    /// The symbols of the robot (lengths and angles): name and value of each.
    pub symbols: Vec<(String, String)>,
    /// The links, in the order of the description.
    pub links: Vec<LinkLine>,
    /// Number of base parameters as text: `7 base parameters of 22 standard ones`.
    pub count: String,
    /// The base parameters, grouped by link.
    pub groups: Vec<LinkBaseParameters>,
    /// Rules of regrouped parameters that are not base parameters, but occur in the rules of base parameters. Empty if the
    /// rules are expanded.
    pub regrouped: Vec<String>,
    /// Names of the standard parameters that have no effect on the torque.
    pub no_effect: Vec<String>,
    /// The drawing of the robot for a page; `None` if a length of the robot is too large to draw.
    #[serde(skip)]
    pub drawing: Option<Drawing>,
    /// For each link and each of its standard parameters: the base parameters that contain this standard parameter.
    pub regroupings: Vec<LinkRegrouping>,
    /// Sentences that justify the number of base parameters.
    pub evidence: Vec<String>,
    /// For each function: name, and the numbers of multiplications, of additions, and of sines and cosines in one call.
    pub operations: Vec<(String, usize, usize, usize)>,
}

/// The table row for one link.
#[derive(Clone, Debug, Serialize)]
pub struct LinkLine {
    /// Number of the link, counted from 1.
    pub number: usize,
    /// Name of the link in the file.
    pub name: String,
    /// Name of the joint of the link.
    pub joint: String,
    /// Type of the joint: revolute, prismatic or fixed.
    pub kind: &'static str,
    /// Name of the antecedent of the link, or `base`.
    pub on: String,
    /// Names of the coordinates that move the joint.
    pub moves_with: String,
    /// The non-zero parameters of the link frame: `alpha -pi/2, d L1`.
    pub frame: String,
}

/// The table rows for the base parameters of one link.
#[derive(Clone, Debug, Serialize)]
pub struct LinkBaseParameters {
    /// Name of the link. The name of its joint is added if it differs.
    pub title: String,
    /// The base parameters of the link, in the order of the regressor.
    pub rows: Vec<BaseParameterRow>,
}

/// The table row for one base parameter.
#[derive(Clone, Debug, Serialize)]
pub struct BaseParameterRow {
    /// Name of the base parameter.
    pub name: String,
    /// Meaning of the base parameter in words.
    pub meaning: String,
    /// Regrouping rule of the base parameter; empty if the base parameter equals a single standard parameter.
    pub rule: String,
    /// Nominal value with unit; empty if the description has no inertials.
    pub value: String,
    /// The standard parameters that are regrouped into the base parameter.
    pub absorbed: Vec<Absorbed>,
}

/// A standard parameter that is regrouped into a base parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Absorbed {
    /// Name of the standard parameter.
    pub name: String,
    /// Meaning of the standard parameter in words.
    pub meaning: String,
    /// Factor of the standard parameter in the rule, with numbers for the symbols.
    pub factor: String,
}

/// The base parameters that contain the standard parameters of one link.
#[derive(Clone, Debug, Serialize)]
pub struct LinkRegrouping {
    /// Name of the link. The name of its joint is added if it differs.
    pub title: String,
    /// For each standard parameter: its name, and the base parameters that contain it. The list of base parameters is empty if
    /// the standard parameter has no effect on the torque.
    pub rows: Vec<(String, Vec<String>)>,
}

/// The data from which the sheet of a robot is made.
#[derive(Clone, Copy)]
pub struct SheetInput<'a> {
    /// The robot description.
    pub robot: &'a Robot,
    /// The base parameters of the robot.
    pub parameters: &'a BaseParameters,
    /// The regrouping rules of the base parameters. Nested rules name other regrouped parameters; expanded rules name only
    /// standard parameters.
    pub rules: &'a Rules,
    /// Nominal values of the base parameters; `None` if the description has no inertials.
    pub described: Option<&'a [f64]>,
    /// Values of the variables at which numerically solved loops are closed, rad (m); empty without such loops.
    pub closed_at: &'a [f64],
    /// Functions of the robot: name and number of operations of each.
    pub operations: &'a [(&'a str, Count)],
}

impl Sheet {
    /// Makes the sheet of a robot.
    pub fn new(source: &SheetInput) -> Sheet {
        let SheetInput { robot, parameters, .. } = source;
        let name = |c: usize| parameters.standard[c].display(robot).to_string();
        let notes = robot.notes.iter().chain(&robot.snapped).map(|n| format!("{}: {}", n.subject, n.text));
        let operation = |(name, c): &(&str, Count)| (name.to_string(), c.mul, c.add, c.sin_cos);
        Sheet {
            name: robot.name.clone(),
            summary: summary(robot),
            source: robot.source.clone(),
            notes: notes.collect(),
            symbols: symbols(robot),
            links: robot.links.iter().enumerate().map(|(j, link)| line(robot, j, link)).collect(),
            count: format!("{} base parameters of {} standard ones", parameters.len(), parameters.standard.len()),
            groups: groups(source),
            regrouped: source.rules.regrouped.clone(),
            no_effect: parameters.no_effect.iter().map(|&c| name(c)).collect(),
            drawing: Drawing::new(robot, source.closed_at),
            regroupings: link_regroupings(robot, parameters),
            evidence: evidence(robot, parameters),
            operations: source.operations.iter().map(operation).collect(),
        }
    }
}

fn summary(robot: &Robot) -> String {
    let counted = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let mut parts = vec![counted(robot.links.len(), "link"), counted(robot.n_coordinates(), "coordinate")];
    if !robot.loops.is_empty() {
        parts.push(counted(robot.loops.len(), "loop"));
    }
    parts.join(", ")
}

fn symbols(robot: &Robot) -> Vec<(String, String)> {
    let value = |symbol: &robot::Symbol, index: usize| match symbol.generic {
        true => "any".to_string(),
        false => significant(Value::Symbol(robot::value::SymbolId(index)).number(&robot.symbols), 6),
    };
    robot.symbols.iter().enumerate().map(|(i, s)| (s.name.clone(), trimmed(&value(s, i)))).collect()
}

/// Removes zeros at the end of the decimals of a number.
fn trimmed(text: &str) -> String {
    if !text.contains('.') || text.contains('e') {
        return text.into();
    }
    text.trim_end_matches('0').trim_end_matches('.').into()
}

fn line(robot: &Robot, j: usize, link: &Link) -> LinkLine {
    LinkLine {
        number: j + 1,
        name: link.name.clone(),
        joint: link.joint.name.clone(),
        kind: match link.joint.kind {
            JointKind::Revolute => "revolute",
            JointKind::Prismatic => "prismatic",
            JointKind::Fixed => "fixed",
        },
        on: link.antecedent.map_or("base".into(), |id| robot.link(id).name.clone()),
        moves_with: moves_with(robot, link),
        frame: frame(robot, link),
    }
}

fn moves_with(robot: &Robot, link: &Link) -> String {
    let term = |&(k, c): &(CoordinateId, f64)| {
        let coordinate = robot.coordinate_name(k);
        match c {
            1.0 => format!("+ {coordinate}"),
            -1.0 => format!("- {coordinate}"),
            c if c < 0.0 => format!("- {}*{coordinate}", -c),
            c => format!("+ {c}*{coordinate}"),
        }
    };
    let text = link.joint.variable.terms.iter().map(term).collect::<Vec<_>>().join(" ");
    let text = text.strip_prefix("+ ").unwrap_or(&text);
    if text.is_empty() { "nothing".into() } else { text.into() }
}

/// The six parameters of a link frame, gamma, b, alpha, d, theta and r: name, text in the description, and number.
pub fn geometry(robot: &Robot, link: &Link) -> [(&'static str, String, f64); 6] {
    let g = &link.geometry;
    let all = [("gamma", &g.gamma), ("b", &g.b), ("alpha", &g.alpha), ("d", &g.d), ("theta", &g.theta), ("r", &g.r)];
    let name = |k: CoordinateId| robot.coordinate_name(k).to_string();
    all.map(|(what, value)| (what, value.text(&robot.symbols, &name), value.number(&robot.symbols)))
}

fn frame(robot: &Robot, link: &Link) -> String {
    let shown = geometry(robot, link).into_iter().filter(|(_, text, _)| text != "0");
    shown.map(|(what, text, _)| format!("{what} {text}")).collect::<Vec<_>>().join(", ")
}

/// Name of a link. The name of the joint of the link is added if the two names differ.
pub(crate) fn link_title(robot: &Robot, link: LinkId) -> String {
    let link = robot.link(link);
    match link.joint.name == link.name || link.joint.name.is_empty() {
        true => link.name.clone(),
        false => format!("{} (joint {})", link.name, link.joint.name),
    }
}

fn groups(source: &SheetInput) -> Vec<LinkBaseParameters> {
    let SheetInput { robot, parameters, rules, described, .. } = *source;
    let mut groups: Vec<LinkBaseParameters> = Vec::new();
    for (k, base) in parameters.base.iter().enumerate() {
        let own = parameters.standard[base.column];
        let absorbed = |t: &modeling::Term| {
            let parameter = parameters.standard[t.parameter];
            Absorbed {
                name: parameter.display(robot).to_string(),
                meaning: modeling::standard_meaning(robot, parameter),
                factor: trimmed(&significant(t.coefficient, 4)),
            }
        };
        let row = BaseParameterRow {
            name: base.name.clone(),
            meaning: parameters.meaning(robot, k),
            rule: if base.terms.len() > 1 { rules.base[k].clone() } else { String::new() },
            value: described
                .map_or(String::new(), |x| format!("{} {}", trimmed(&significant(x[k], 4)), unit(robot, own))),
            absorbed: base.terms.iter().map(absorbed).collect(),
        };
        let title = link_title(robot, own.link);
        match groups.iter_mut().find(|group| group.title == title) {
            Some(group) => group.rows.push(row),
            None => groups.push(LinkBaseParameters { title, rows: vec![row] }),
        }
    }
    groups
}

/// The SI unit of a standard parameter.
pub fn unit(robot: &Robot, parameter: robot::StandardParameter) -> &'static str {
    match parameter.inertial {
        Inertial::M => "kg",
        Inertial::Ia if robot.link(parameter.link).joint.kind == JointKind::Prismatic => "kg",
        inertial if inertial.is_first_moment() => "kg m",
        _ => "kg m^2",
    }
}

fn link_regroupings(robot: &Robot, parameters: &BaseParameters) -> Vec<LinkRegrouping> {
    let mut holders: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for base in &parameters.base {
        base.terms.iter().for_each(|t| holders.entry(t.parameter).or_default().push(base.name.clone()));
    }
    let mut regroupings: Vec<LinkRegrouping> =
        robot.link_ids().map(|link| LinkRegrouping { title: link_title(robot, link), rows: Vec::new() }).collect();
    for (c, standard) in parameters.standard.iter().enumerate() {
        let row = (standard.display(robot).to_string(), holders.get(&c).cloned().unwrap_or_default());
        regroupings[standard.link.0].rows.push(row);
    }
    regroupings
}

fn evidence(robot: &Robot, parameters: &BaseParameters) -> Vec<String> {
    let rank = &parameters.rank;
    // An exact rank proves the number of base parameters, unless one of them is weak (has hardly any effect on the torques).
    let certificate = match rank.exact.rank() {
        Some(_) if !parameters.weak.is_empty() => {
            format!("rank {}, numeric: {}", rank.numeric, parameters.evidence_of_rank(robot))
        }
        Some(exact) => format!(
            "rank {exact}, exact: no experiment identifies more than these {exact} numbers, and the right motion identifies all of them ({})",
            rank.exact
        ),
        None => format!("rank {}, numeric: {}", rank.numeric, rank.exact),
    };
    // The numeric rank is reliable if there is a gap between kept and dropped columns.
    let numbers = format!(
        "in numbers, every kept column stands {:.1e} or more out of the span of those before it, every dropped one {:.1e} \
         or less",
        rank.smallest_kept, rank.largest_dropped
    );
    // Relations between columns of the regressor are proven either for all values of the symbols, or only for the values of this
    // robot.
    let relations = match (rank.general_relations, rank.numeric_relations) {
        (0, 0) => format!("all {} relations between columns are proven in the robot's symbols", rank.exact_relations),
        (general, numeric) => {
            let mut text =
                format!("{} relations between columns are proven in the robot's symbols", rank.exact_relations);
            if general > 0 {
                text +=
                    &format!("; {general} more hold at every value of the symbols, with coefficients known as numbers");
            }
            if numeric > 0 {
                text += &format!("; {numeric} hold only for these numbers");
            }
            text
        }
    };
    vec![certificate, numbers, relations]
}
