//! The results of `rist inspect`: base parameters, their regrouping rules, numbers of operations, and the evidence for the
//! rank.
//!
//! The number of base parameters is the rank of the regressor. A regrouping rule states how a base parameter follows from
//! standard parameters. If a reader replaced angles (1.5708 by pi/2), the results also name the base parameters that exist only
//! with the angles as given.

use std::path::Path;

use expr::Count;
use modeling::{BaseParameters, Rules, WeakParameter};
use report::sheet::{self, Sheet, SheetInput, geometry};
use robot::Robot;
use robot::format::AngleSnapping;
use robot::value::SymbolId;
use serde_json::{Value, json};

use crate::describe::description::read_robot;
use crate::describe::model::Model;
use crate::error::Error;
use crate::request::{InspectRequest, ModelOptions};

/// A model with its regrouping rules, ready to be shown as text, page or JSON.
pub struct Inspection {
    /// The derived model.
    pub model: Model,
    /// The regrouping rules: nested, or expanded into standard parameters alone.
    pub rules: Rules,
    tilted: Tilted,
}

/// Derives the model and the regrouping rules of a robot that was read from `path` with `options`.
///
/// Fails if the model cannot be derived, or if expanded rules would have more than a million terms.
pub fn inspect(
    robot: Robot,
    path: &Path,
    options: &ModelOptions,
    request: &InspectRequest,
) -> Result<Inspection, Error> {
    let model = Model::of(robot, path, options.any_size)?;
    let tilted = Tilted::new(&model, options)?;
    let rules = if request.expand_rules { expanded(&model)? } else { model.parameters.rules() };
    Ok(Inspection { model, rules, tilted })
}

impl Inspection {
    /// Text with lines of at most `width` characters.
    pub fn text(&self, width: usize) -> String {
        report::robot::text(&self.sheet(), width)
    }

    /// A page of Markdown.
    pub fn markdown(&self) -> String {
        report::robot::markdown(&self.sheet())
    }

    /// Tables of LaTeX.
    pub fn latex(&self) -> String {
        report::robot::latex(&self.sheet())
    }

    /// An HTML page on which a parameter or a link can be selected.
    pub fn html(&self) -> String {
        report::robot::html(&self.sheet())
    }

    fn sheet(&self) -> Sheet {
        let Inspection { model: derived, rules, tilted } = self;
        let nominal = nominal_values(derived);
        let operations = [
            ("regressor", derived.standard_regressor.count()),
            ("base regressor", derived.base_regressor.count()),
            ("torque", derived.torque.count()),
        ];
        let closed_at: Vec<f64> = derived.assembly.iter().map(|(_, x)| *x).collect();
        let mut sheet = Sheet::new(&SheetInput {
            robot: &derived.robot,
            parameters: &derived.parameters,
            rules,
            described: nominal.as_deref(),
            closed_at: &closed_at,
            operations: &operations,
        });
        if derived.is_compiled() {
            sheet.evidence.push("the base regressor is compiled into this program".into());
        }
        sheet.evidence.extend(assembly(derived));
        sheet.evidence.extend(tilted.sentence());
        sheet
    }

    /// All results as JSON.
    pub fn to_json(&self) -> Value {
        let Inspection { model: derived, rules, tilted } = self;
        let (robot, parameters) = (&derived.robot, &derived.parameters);
        let name = |c: usize| parameters.standard[c].display(robot).to_string();
        let names = |columns: &[usize]| columns.iter().map(|&c| name(c)).collect::<Vec<_>>();
        let nominal = nominal_values(derived);
        let count = |c: Count| json!({"mul": c.mul, "add": c.add, "sin_cos": c.sin_cos});
        let added = |(name, share): &(String, f64)| json!({"parameter": name, "share": share});
        json!({
            "robot": robot.name,
            "source": robot.source,
            "coordinates": robot.coordinates.iter().map(|c| &c.name).collect::<Vec<_>>(),
            "symbols": (0..robot.symbols.len()).map(|i| symbol(robot, i)).collect::<Vec<_>>(),
            "links": robot.links.iter().map(|l| link(robot, l)).collect::<Vec<_>>(),
            "constants": parameters.constants.iter().map(|(name, x)| (name.clone(), json!(x))).collect::<serde_json::Map<_, _>>(),
            // Both lists are in the order of the columns of their regressors.
            "standard": (0..parameters.standard.len()).map(name).collect::<Vec<_>>(),
            "base": (0..parameters.len()).map(|k| base(derived, rules, nominal.as_deref(), k)).collect::<Vec<_>>(),
            "regrouped": rules.regrouped,
            "assembly": derived.assembly.iter().map(|(name, x)| (name.clone(), json!(x))).collect::<serde_json::Map<_, _>>(),
            // Base parameters that would be added if the angles were used exactly as given; or the reason why these base
            // parameters cannot be derived.
            "as_given": tilted.appear.iter().flatten().map(added).collect::<Vec<_>>(),
            "as_given_refused": tilted.appear.as_ref().err(),
            "no_effect": names(&parameters.no_effect),
            "rank": rank(robot, parameters),
            "ops": {
                "regressor": count(derived.standard_regressor.count()),
                "base_regressor": count(derived.base_regressor.count()),
                "torque": count(derived.torque.count()),
            },
            "compiled": derived.is_compiled(),
            "notes": robot.notes.iter().chain(&robot.snapped).map(|n| json!({"subject": n.subject, "text": n.text})).collect::<Vec<_>>(),
        })
    }
}

fn expanded(model: &Model) -> Result<Rules, Error> {
    model.parameters.expanded_rules().ok_or_else(|| {
        Error::new(format_args!(
            "{}: expanded, the rules have more than a million terms; without [expand_rules] they are nested",
            model.path.display()
        ))
    })
}

/// Base parameters that would be added if angles were used exactly as given. They exist only because an axis is almost, but not
/// exactly, parallel or perpendicular to another axis.
struct Tilted {
    /// Name of each added base parameter with its share of the torque; or the reason why these base parameters cannot be
    /// derived.
    appear: Result<Vec<(String, f64)>, String>,
    /// Sentences on the angles that the reader replaced by exact angles.
    because: Vec<String>,
}

impl Tilted {
    fn new(derived: &Model, options: &ModelOptions) -> Result<Tilted, Error> {
        let robot = &derived.robot;
        let because: Vec<String> = robot.snapped.iter().map(|n| format!("{}: {}", n.subject, n.text)).collect();
        let mut tilted = Tilted { appear: Ok(Vec::new()), because };
        if tilted.because.is_empty() {
            return Ok(tilted);
        }
        let options = ModelOptions { angles: AngleSnapping::AsGiven, ..options.clone() };
        let given = read_robot(&derived.path, &options)?;
        let kept = |c: usize| derived.parameters.base.iter().any(|b| b.column == c);
        let name = |of: &Model, c: usize| of.parameters.standard[c].display(&of.robot).to_string();
        tilted.appear = match Model::of(given, &derived.path, options.any_size) {
            Ok(model) => {
                let more = model.parameters.base.iter().filter(|b| !kept(b.column));
                Ok(more.map(|b| (name(&model, b.column), b.share)).collect())
            }
            Err(e) => Err(e.to_string()),
        };
        Ok(tilted)
    }

    fn sentence(&self) -> Option<String> {
        if self.because.is_empty() {
            return None;
        }
        let because = self.because.join("; ");
        let appear = match &self.appear {
            Ok(appear) => appear,
            Err(why) => return Some(format!("the angles as given have no clear base parameters ({because}): {why}")),
        };
        if appear.is_empty() {
            return Some(format!("with the angles as given there are no more base parameters ({because})"));
        }
        let largest = appear.iter().map(|a| a.1).fold(0.0, f64::max);
        let names: Vec<&str> = appear.iter().map(|a| a.0.as_str()).collect();
        Some(format!(
            "{} more appear only with the angles as given ({because}): {}; they carry {largest:.0e} of the torque",
            names.len(),
            names.join(" ")
        ))
    }
}

/// A sentence on the configuration at which the solver closed the loops first; `None` without numerically solved loops.
fn assembly(derived: &Model) -> Option<String> {
    if derived.assembly.is_empty() {
        return None;
    }
    let (q, passive) = derived.assembly.split_at(derived.robot.n_coordinates());
    // Rounded to six decimals; adding 0 turns -0 into 0.
    let list = |of: &[(String, f64)]| {
        let value = |(name, x): &(String, f64)| format!("{name} = {}", (x * 1e6).round() / 1e6 + 0.0);
        of.iter().map(value).collect::<Vec<_>>().join(", ")
    };
    Some(format!(
        "at {} the loops are closed by {} (rad, m), and every other configuration is followed from there; another start \
         may choose another assembly",
        list(q),
        list(passive)
    ))
}

/// The base parameters from the inertial parameters of the description; `None` if the description has no inertial parameters,
/// or if a symbol has no value.
fn nominal_values(derived: &Model) -> Option<Vec<f64>> {
    let lacks_value = derived.robot.symbols.iter().any(|s| s.generic);
    derived.nominal_parameters().filter(|_| !lacks_value)
}

/// A link as JSON: its joint, its frame relative to its antecedent's frame, and its inertial parameters if they are known.
fn link(robot: &Robot, link: &robot::Link) -> Value {
    let entry = |(name, text, number): (&str, String, f64)| {
        let number = if number.is_finite() { json!(number) } else { Value::Null };
        (name.to_string(), json!({"text": text, "number": number}))
    };
    let terms = link.joint.variable.terms.iter();
    json!({
        "name": link.name,
        "joint": link.joint.name,
        "label": link.label,
        "antecedent": link.antecedent.map(|id| &robot.link(id).name),
        "kind": format!("{:?}", link.joint.kind).to_lowercase(),
        "moves_with": terms.map(|(k, factor)| json!({"coordinate": robot.coordinate_name(*k), "factor": factor})).collect::<Vec<_>>(),
        "geometry": geometry(robot, link).into_iter().map(entry).collect::<serde_json::Map<_, _>>(),
        "inertial": link.inertial,
    })
}

/// Base parameter `k` as JSON: its rule, its meaning, and the standard parameters that are regrouped into it.
fn base(derived: &Model, rules: &Rules, nominal: Option<&[f64]>, k: usize) -> Value {
    let (robot, parameters) = (&derived.robot, &derived.parameters);
    let b = &parameters.base[k];
    let name = |c: usize| parameters.standard[c].display(robot).to_string();
    // Only expanded rules have symbolic coefficients.
    let symbolic = |t: usize| rules.coefficients.get(k).map_or(Value::Null, |c| json!(c[t]));
    let term = |(i, t): (usize, &modeling::Term)| json!({"parameter": name(t.parameter), "coefficient": t.coefficient, "symbolic": symbolic(i)});
    json!({
        "name": b.name,
        "parameter": name(b.column),
        "rule": rules.base[k],
        "meaning": parameters.meaning(robot, k),
        "value": nominal.map(|x| x[k]),
        "unit": sheet::unit(robot, parameters.standard[b.column]),
        "share": b.share,
        "terms": b.terms.iter().enumerate().map(term).collect::<Vec<_>>(),
    })
}

/// A symbol of the geometry as JSON, with its value; null if the symbol has no value.
fn symbol(robot: &Robot, i: usize) -> Value {
    let value = match robot.symbols[i].generic {
        true => Value::Null,
        false => json!(robot::Value::Symbol(SymbolId(i)).number(&robot.symbols)),
    };
    json!({"name": robot.symbols[i].name, "value": value})
}

/// The rank of the regressor and the evidence for it, as JSON.
fn rank(robot: &Robot, parameters: &BaseParameters) -> Value {
    let rank = &parameters.rank;
    let weak = |w: &WeakParameter| json!({"parameter": parameters.standard[w.column].display(robot).to_string(), "share": w.share});
    json!({
        "weak": parameters.weak.iter().map(weak).collect::<Vec<_>>(),
        "left_out": rank.left_out,
        "numeric": rank.numeric,
        "exact": rank.exact.rank(),
        "evidence": parameters.evidence_of_rank(robot),
        // The gap between kept and dropped columns is infinite if no column was dropped; JSON has no infinity.
        "gap": if rank.gap().is_finite() { json!(rank.gap()) } else { Value::Null },
        "smallest_kept": rank.smallest_kept,
        "largest_dropped": rank.largest_dropped,
        "exact_relations": rank.exact_relations,
        "general_relations": rank.general_relations,
        "numeric_relations": rank.numeric_relations,
    })
}
