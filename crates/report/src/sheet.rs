//! The sheet of a description: links, base parameters by link with meaning, value and rule, and the base parameters that
//! contain the ten numbers of each link. [`crate::robot`] writes it as text, Markdown, LaTeX and HTML.

use std::collections::BTreeMap;

use expr::Count;
use modeling::{BaseParameters, Rules};
use robot::value::CoordinateId;
use robot::{Inertial, JointKind, Link, LinkId, Robot, Value};
use serde::Serialize;

use crate::drawing::Drawing;
use crate::number::significant;

/// The content of the sheet.
#[derive(Clone, Debug, Serialize)]
pub struct Sheet {
    /// Name of the robot.
    pub name: String,
    /// `2 links, 2 coordinates, 1 loop`.
    pub summary: String,
    /// Source of the description.
    pub source: Option<String>,
    /// Notes on values that the reader guessed or replaced.
    pub notes: Vec<String>,
    /// Names and values of lengths and angles.
    pub symbols: Vec<(String, String)>,
    /// The links, in the order of the description.
    pub links: Vec<LinkLine>,
    /// `7 base parameters of 22 standard ones`.
    pub count: String,
    /// Base parameters by link.
    pub groups: Vec<LinkBaseParameters>,
    /// Rules of regrouped parameters that are no base parameters, where rules are nested.
    pub regrouped: Vec<String>,
    /// Standard parameters that have no effect on the torque.
    pub no_effect: Vec<String>,
    /// The drawing of the robot for a page; `None` where its lengths cannot be drawn.
    #[serde(skip)]
    pub drawing: Option<Drawing>,
    /// The base parameters that contain each standard parameter, by link, in the order of the links.
    pub regroupings: Vec<LinkRegrouping>,
    /// The evidence for the number of base parameters, in sentences.
    pub evidence: Vec<String>,
    /// Functions with the multiplications, additions, and sines and cosines of one call.
    pub operations: Vec<(String, usize, usize, usize)>,
}

/// A link in one line.
#[derive(Clone, Debug, Serialize)]
pub struct LinkLine {
    /// Its number, from 1.
    pub number: usize,
    /// Its name in the file.
    pub name: String,
    /// Name of its joint.
    pub joint: String,
    /// revolute, prismatic or fixed.
    pub kind: &'static str,
    /// Its antecedent, or base.
    pub on: String,
    /// The coordinates that its joint follows.
    pub moves_with: String,
    /// The non-zero parameters of its frame: `alpha -pi/2, d L1`.
    pub frame: String,
}

/// The base parameters of a link.
#[derive(Clone, Debug, Serialize)]
pub struct LinkBaseParameters {
    /// Name of the link, with its joint.
    pub title: String,
    /// Its base parameters, in the order of the regressor.
    pub rows: Vec<BaseParameterRow>,
}

/// A base parameter.
#[derive(Clone, Debug, Serialize)]
pub struct BaseParameterRow {
    /// Its name.
    pub name: String,
    /// Its meaning.
    pub meaning: String,
    /// Its rule; empty where it absorbs no other parameter.
    pub rule: String,
    /// Its nominal value with its unit; empty without inertials in the description.
    pub value: String,
    /// The standard parameters that it absorbs.
    pub absorbed: Vec<Absorbed>,
}

/// A standard parameter that a base parameter absorbs.
#[derive(Clone, Debug, Serialize)]
pub struct Absorbed {
    /// Name of the standard parameter.
    pub name: String,
    /// The meaning of the standard parameter.
    pub meaning: String,
    /// Its factor at the values of the symbols.
    pub factor: String,
}

/// The base parameters that contain the standard parameters of a link.
#[derive(Clone, Debug, Serialize)]
pub struct LinkRegrouping {
    /// Name of the link, with its joint.
    pub title: String,
    /// Name of each standard parameter, and the base parameters that contain it; empty where it has no effect.
    pub rows: Vec<(String, Vec<String>)>,
}

/// The data from which a sheet is made.
#[derive(Clone, Copy)]
pub struct SheetInput<'a> {
    /// The description.
    pub robot: &'a Robot,
    /// Its base parameters.
    pub parameters: &'a BaseParameters,
    /// Their rules, nested or expanded.
    pub rules: &'a Rules,
    /// Their nominal values; `None` without inertials in the description.
    pub described: Option<&'a [f64]>,
    /// The variables at which numerically solved loops are closed, rad or m; empty without such loops.
    pub closed_at: &'a [f64],
    /// Functions with their counts.
    pub operations: &'a [(&'a str, Count)],
}

impl Sheet {
    /// The sheet of a robot.
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

/// The number without zeros at the end of a fraction.
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

/// gamma, b, alpha, d, theta, r: names, texts in the description, and numbers.
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

/// Name of a link, with its joint.
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
    // An exact rank is a certificate unless a base parameter is weak.
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
    // The gap between kept and dropped columns shows how reliable the numeric rank is.
    let numbers = format!(
        "in numbers, every kept column stands {:.1e} or more out of the span of those before it, every dropped one {:.1e} \
         or less",
        rank.smallest_kept, rank.largest_dropped
    );
    // Relations between columns: proven in symbols, for all values, or only for these values.
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
