//! `rist inspect`: the base parameters, their rules, the counts and the evidence.

use std::fmt::Write;

use clap::Args;
use expr::Count;
use modeling::Rules;
use rist::{Model, ModelOptions};
use robot::JointKind;
use robot::format::Angles;
use serde_json::{Value, json};

use crate::failure::{Failure, print};
use crate::model::ModelArguments;

/// Show a robot's base parameters, regrouping rules, operation counts and rank evidence
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Print JSON instead of text
    #[arg(long)]
    json: bool,

    /// Write the rules in the standard parameters alone, however long they are [default: while all of them stay below
    /// 200000 characters; beyond, they name the regrouped parameters of the next link]
    #[arg(long)]
    expand_rules: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let robot = arguments.model.read()?;
    let model = Model::of(robot, &arguments.model.model)?;
    let (robot, derived) = (&model.robot, &model);
    let tilted = Tilted::new(arguments, derived)?;
    let rules = if arguments.expand_rules { expanded(derived)? } else { derived.parameters.rules() };
    if arguments.json {
        print(&(format!("{:#}\n", as_json(derived, &rules, &tilted))))?;
    } else {
        print(&(as_text(derived, &rules) + &tilted.text()))?;
    }
    let parameters = &derived.parameters;
    if parameters.coincident.is_empty() {
        return Ok(());
    }
    let names: Vec<String> =
        parameters.coincident.iter().map(|&c| parameters.standard[c].display(robot).to_string()).collect();
    Err(Failure::verdict(format_args!(
        "{}: the numeric and the exact rank disagree. For robots of this structure in general {} would be base \
         parameters; at these numbers they are not. If two lengths or angles are equal on purpose, give them one \
         symbol; if gravity is along an axis on purpose, give the axis exactly",
        arguments.model.model.display(),
        names.join(" ")
    )))
}

fn expanded(derived: &Model) -> Result<Rules, Failure> {
    derived.parameters.expanded_rules().ok_or_else(|| {
        Failure::new(format_args!(
            "{}: expanded, the rules have more than a million terms; without --expand-rules they are nested",
            derived.path.display()
        ))
    })
}

/// Base parameters that the angles exactly as given would add. They appear only because some axis is almost, but not
/// quite, parallel or at right angles to another.
struct Tilted {
    /// Name and share of the torque; or why the angles as given have no base parameters.
    appear: Result<Vec<(String, f64)>, String>,
    /// The angles that were taken for others.
    because: Vec<String>,
}

impl Tilted {
    fn new(arguments: &Arguments, derived: &Model) -> Result<Tilted, Failure> {
        let robot = &derived.robot;
        let because: Vec<String> = robot.snapped.iter().map(|n| format!("{}: {}", n.subject, n.text)).collect();
        let mut tilted = Tilted { appear: Ok(Vec::new()), because };
        if tilted.because.is_empty() {
            return Ok(tilted);
        }
        let options = ModelOptions { angles: Angles::AsGiven, ..arguments.model.options() };
        let given = rist::read_robot(&arguments.model.model, &options)?;
        let kept = |c: usize| derived.parameters.base.iter().any(|b| b.column == c);
        let name = |of: &Model, c: usize| of.parameters.standard[c].display(&of.robot).to_string();
        tilted.appear = match Model::of(given, &arguments.model.model) {
            Ok(model) => {
                let more = model.parameters.base.iter().filter(|b| !kept(b.column));
                Ok(more.map(|b| (name(&model, b.column), b.share)).collect())
            }
            Err(e) => Err(e.to_string()),
        };
        Ok(tilted)
    }

    fn text(&self) -> String {
        if self.because.is_empty() {
            return String::new();
        }
        let because = self.because.join("; ");
        let appear = match &self.appear {
            Ok(appear) => appear,
            Err(why) => return format!("\nthe angles as given have no clear base parameters ({because}): {why}\n"),
        };
        if appear.is_empty() {
            return format!("\nwith the angles as given the base parameters are the same ({because})\n");
        }
        let largest = appear.iter().map(|a| a.1).fold(0.0, f64::max);
        let names: Vec<&str> = appear.iter().map(|a| a.0.as_str()).collect();
        format!(
            "\n{} more appear only with the angles as given ({because}): {}; they carry {largest:.0e} of the torque\n",
            names.len(),
            names.join(" ")
        )
    }
}

fn as_json(derived: &Model, rules: &Rules, tilted: &Tilted) -> Value {
    let robot = &derived.robot;
    let parameters = &derived.parameters;
    let name = |c: usize| parameters.standard[c].display(robot).to_string();
    let count = |c: Count| json!({"mul": c.mul, "add": c.add, "sin_cos": c.sin_cos});
    // Nested rules have no coefficients in full.
    let base = |(k, b): (usize, &modeling::BaseParameter)| {
        let symbolic = |t: usize| rules.coefficients.get(k).map_or(Value::Null, |c| json!(c[t]));
        let term = |(i, t): (usize, &modeling::Term)| json!({"parameter": name(t.parameter), "coefficient": t.coefficient, "symbolic": symbolic(i)});
        json!({
            "name": b.name,
            "parameter": name(b.column),
            "rule": rules.base[k],
            "share": b.share,
            "terms": b.terms.iter().enumerate().map(term).collect::<Vec<_>>(),
        })
    };
    let rank = &parameters.rank;
    json!({
        "robot": robot.name,
        "source": robot.source,
        "coordinates": robot.coordinates.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "links": robot.links.iter().map(|l| json!({"name": l.name, "joint": l.joint.name, "label": l.label})).collect::<Vec<_>>(),
        "standard": (0..parameters.standard.len()).map(name).collect::<Vec<_>>(),
        "base": parameters.base.iter().enumerate().map(base).collect::<Vec<_>>(),
        "regrouped": rules.regrouped,
        "as_given": tilted
            .appear
            .iter()
            .flatten()
            .map(|(name, share)| json!({"parameter": name, "share": share}))
            .collect::<Vec<_>>(),
        "as_given_refused": tilted.appear.as_ref().err(),
        "coincident": parameters.coincident.iter().map(|&c| name(c)).collect::<Vec<_>>(),
        "no_effect": parameters.no_effect.iter().map(|&c| name(c)).collect::<Vec<_>>(),
        "rank": {
            "numeric": rank.numeric,
            "exact": rank.exact,
            // JSON has no infinity, which stands for a model without dropped columns.
            "gap": if rank.gap().is_finite() { json!(rank.gap()) } else { Value::Null },
            "smallest_kept": rank.smallest_kept,
            "largest_dropped": rank.largest_dropped,
            "exact_relations": rank.exact_relations,
            "numeric_relations": rank.numeric_relations,
        },
        "ops": {
            "regressor": count(derived.standard_regressor.count()),
            "base_regressor": count(derived.base_regressor.count()),
            "torque": count(derived.torque.count()),
        },
        "compiled": derived.is_compiled(),
        "notes": robot.notes.iter().chain(&robot.snapped).map(|n| json!({"subject": n.subject, "text": n.text})).collect::<Vec<_>>(),
    })
}

fn as_text(derived: &Model, rules: &Rules) -> String {
    let robot = &derived.robot;
    let parameters = &derived.parameters;
    let name = |c: usize| parameters.standard[c].display(robot).to_string();
    let mut text = String::new();
    // Writing to a string cannot fail.
    macro_rules! line {
        ($($part:tt)*) => {{ let _ = writeln!(text, $($part)*); }};
    }
    let loops = match robot.loops.len() {
        0 => String::new(),
        n => format!(", {n} loops"),
    };
    line!("{}: {} links, {} coordinates{loops}", robot.name, robot.links.len(), robot.n_coordinates());
    if let Some(source) = &robot.source {
        line!("source: {source}");
    }
    for note in robot.notes.iter().chain(&robot.snapped) {
        line!("note: {}: {}", note.subject, note.text);
    }
    line!();
    line!("{:<4} {:<24} {:<24} {:<10} {:<8} moves with", "link", "name", "joint", "kind", "label");
    for (j, link) in robot.links.iter().enumerate() {
        let kind = match link.joint.kind {
            JointKind::Revolute => "revolute",
            JointKind::Prismatic => "prismatic",
            JointKind::Fixed => "fixed",
        };
        let terms: Vec<String> = link
            .joint
            .variable
            .terms
            .iter()
            .map(|&(k, c)| {
                let coordinate = robot.coordinate_name(k);
                match c {
                    1.0 => format!("+ {coordinate}"),
                    -1.0 => format!("- {coordinate}"),
                    c if c < 0.0 => format!("- {}*{coordinate}", -c),
                    c => format!("+ {c}*{coordinate}"),
                }
            })
            .collect();
        let moves = terms.join(" ");
        let moves = moves.strip_prefix("+ ").unwrap_or(&moves);
        let moves = if moves.is_empty() { "nothing" } else { moves };
        line!("{:<4} {:<24} {:<24} {:<10} {:<8} {moves}", j + 1, link.name, link.joint.name, kind, link.label);
    }
    line!();
    line!("{} base parameters of {} standard ones:", parameters.len(), parameters.standard.len());
    for (b, rule) in parameters.base.iter().zip(&rules.base) {
        let rule = if b.terms.len() > 1 { rule.as_str() } else { "" };
        line!("  {:<10} {rule}", b.name);
    }
    if !rules.regrouped.is_empty() {
        line!("with these regrouped parameters, which are no base parameters:");
        rules.regrouped.iter().for_each(|rule| line!("  {rule}"));
    }
    if !parameters.no_effect.is_empty() {
        let names: Vec<String> = parameters.no_effect.iter().map(|&c| name(c)).collect();
        line!("{} without effect: {}", names.len(), names.join(" "));
    }
    let rank = &parameters.rank;
    line!();
    let certificate = match rank.exact {
        Some(exact) if exact == rank.numeric => {
            format!("rank {exact}, exact: the same columns are independent in a finite field.")
        }
        Some(exact) => {
            format!("rank {} at these numbers, {exact} for robots of this structure in general.", rank.numeric)
        }
        None => format!("rank {}, numeric: the loops are closed by a search.", rank.numeric),
    };
    line!(
        "{certificate} In numbers, every kept column stands {:.1e} or more out of the span of those before it, every \
         dropped one {:.1e} or less",
        rank.smallest_kept,
        rank.largest_dropped
    );
    match rank.numeric_relations {
        0 => line!("all {} relations between columns are proven in the robot's symbols", rank.exact_relations),
        n => line!(
            "{} relations between columns are proven in the robot's symbols; {n} hold only for these numbers",
            rank.exact_relations
        ),
    }
    line!();
    line!("operations a call       mul    add  sin_cos");
    let counts = [
        ("regressor", &derived.standard_regressor),
        ("base regressor", &derived.base_regressor),
        ("torque", &derived.torque),
    ];
    for (name, function) in counts {
        let c = function.count();
        line!("  {name:<18} {:>6} {:>6} {:>8}", c.mul, c.add, c.sin_cos);
    }
    if derived.is_compiled() {
        line!("the base regressor is compiled into this program");
    }
    text
}
