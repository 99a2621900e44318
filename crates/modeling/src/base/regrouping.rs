//! Finds, for each dropped column, the kept columns it consists of: D_d = sum_k beta_kd D_k.
//!
//! Three sources, in this order of trust:
//!
//! - the rules of trees ([`crate::base::rigid_regrouping`]), exact in the robot's symbols. A rule leads
//!   to columns before the dropped one. Where these are dropped themselves, their own relation is
//!   substituted;
//! - for columns that no rule explains, because loops tie them together, interpolation in a finite
//!   field ([`crate::base::interpolation`]), exact too;
//! - where that finds no closed form, the numbers of the scan.

use std::collections::BTreeMap;

use expr::{Function, Graph};
use robot::{Inertial, JointKind, LinkId, Robot, StandardParameter};

use crate::base::coefficient::Coefficient;
use crate::base::interpolation::{Relation, interpolate};
use crate::base::rank::Scan;
use crate::base::rigid_regrouping::tree_rules;
use crate::derivation::Derivation;

/// A numeric coefficient smaller than this is a rounded zero. The scan leaves about 1e-13; a true
/// coefficient is a product of at most two lengths, and two of a tenth of a millimetre give 1e-8.
const ROUNDED_ZERO: f64 = 1e-9;

/// A coefficient of a regrouping: proven in the symbols, or only a number.
#[derive(Clone, Debug)]
pub(crate) enum Beta {
    Exact(Coefficient),
    Number(f64),
}

impl Beta {
    /// The coefficient where each constant of the graph has its value.
    pub fn number(&self, graph: &Graph) -> f64 {
        match self {
            Beta::Exact(c) => c.number(graph),
            Beta::Number(x) => *x,
        }
    }

    fn plus(&self, other: &Beta, graph: &Graph) -> Beta {
        match (self, other) {
            (Beta::Exact(a), Beta::Exact(b)) => Beta::Exact(a.plus(b)),
            (a, b) => Beta::Number(a.number(graph) + b.number(graph)),
        }
    }

    fn times(&self, factor: &Coefficient, graph: &Graph) -> Beta {
        match self {
            Beta::Exact(c) => Beta::Exact(factor.times(c)),
            Beta::Number(x) => Beta::Number(factor.number(graph) * x),
        }
    }
}

/// By dropped column: the kept columns it is made of, each with its coefficient. Empty for a column
/// that is zero.
pub(crate) type Regrouping = BTreeMap<usize, Vec<(usize, Beta)>>;

/// By dropped column: what a tree rule says it is made of; these columns may be dropped themselves.
type Rules = BTreeMap<usize, Vec<(usize, Coefficient)>>;

/// The relation of every column that the scan does not keep.
pub(crate) fn regrouping(
    derivation: &mut Derivation,
    regressor: &Function,
    standard: &[StandardParameter],
    scan: &Scan,
) -> Regrouping {
    let rules = rules_by_column(derivation, standard);
    let numeric: BTreeMap<usize, &Vec<f64>> = scan.dependent.iter().map(|(c, x)| (*c, x)).collect();
    let unexplained = unexplained(derivation.robot, standard, scan, &rules, &numeric);
    let mut regrouping = solved(derivation.robot, regressor, scan, &unexplained, &numeric);
    put_in(&mut regrouping, &rules, regressor.graph());
    regrouping
}

fn rules_by_column(derivation: &mut Derivation, standard: &[StandardParameter]) -> Rules {
    let Derivation { robot, graph, constants, .. } = derivation;
    let column: BTreeMap<(LinkId, Inertial), usize> =
        standard.iter().enumerate().map(|(c, s)| ((s.link, s.inertial), c)).collect();
    tree_rules(robot, graph, constants)
        .into_iter()
        .map(|rule| (column[&rule.dropped], rule.terms.into_iter().map(|(p, c)| (column[&p], c)).collect()))
        .collect()
}

/// The dropped columns without a tree rule, with the kept columns that the numbers say they are made of.
fn unexplained(
    robot: &Robot,
    standard: &[StandardParameter],
    scan: &Scan,
    rules: &Rules,
    numeric: &BTreeMap<usize, &Vec<f64>>,
) -> Vec<Relation> {
    let dropped = (0..standard.len()).filter(|c| scan.kept.binary_search(c).is_err() && !rules.contains_key(c));
    dropped
        .map(|column| {
            let support: Vec<usize> = match numeric.get(&column) {
                Some(x) => (0..x.len()).filter(|&k| x[k].abs() > ROUNDED_ZERO).map(|k| scan.kept[k]).collect(),
                None => Vec::new(),
            };
            let own = length_degree(robot, standard[column]);
            let degrees = support.iter().map(|&k| length_degree(robot, standard[k]) - own).collect();
            Relation { column, support, degrees }
        })
        .collect()
}

/// The coefficients of the relations: from the field where it has an answer, else from the numbers.
fn solved(
    robot: &Robot,
    regressor: &Function,
    scan: &Scan,
    relations: &[Relation],
    numeric: &BTreeMap<usize, &Vec<f64>>,
) -> Regrouping {
    // Where loops are closed numerically only a column that is not there is a fact of the field.
    let exact: Vec<Option<Vec<Coefficient>>> = if robot.passive.is_empty() {
        interpolate(regressor, relations)
    } else {
        let absent = |r: &Relation| r.support.is_empty() && column_is_zero(regressor, r.column);
        relations.iter().map(|r| absent(r).then(Vec::new)).collect()
    };
    let row = |relation: &Relation, exact: Option<Vec<Coefficient>>| -> Vec<(usize, Beta)> {
        if let Some(coefficients) = exact {
            return relation.support.iter().copied().zip(coefficients.into_iter().map(Beta::Exact)).collect();
        }
        let x = numeric.get(&relation.column);
        let number = |kept: &usize| {
            let place = scan.kept.binary_search(kept).unwrap_or_default();
            (*kept, Beta::Number(x.map_or(0.0, |x| x[place])))
        };
        relation.support.iter().map(number).collect()
    };
    relations.iter().zip(exact).map(|(relation, exact)| (relation.column, row(relation, exact))).collect()
}

/// Adds the columns that tree rules drop: D_d = sum_c factor_c D_c, with the relation of c put in where
/// c is dropped too. A rule leads to columns before its own, so that those are resolved by then.
fn put_in(regrouping: &mut Regrouping, rules: &Rules, graph: &Graph) {
    for (&dropped, terms) in rules {
        let mut row: BTreeMap<usize, Beta> = BTreeMap::new();
        for (c, factor) in terms {
            let parts = match regrouping.get(c) {
                Some(parts) => parts.clone(),
                None => vec![(*c, Beta::Exact(Coefficient::one()))],
            };
            for (kept, beta) in parts {
                let term = beta.times(factor, graph);
                let sum = match row.remove(&kept) {
                    None => term,
                    Some(before) => before.plus(&term, graph),
                };
                row.insert(kept, sum);
            }
        }
        row.retain(|_, beta| !matches!(beta, Beta::Exact(c) if c.is_zero()));
        regrouping.insert(dropped, row.into_iter().collect());
    }
}

/// Whether nothing stands in a column, whatever the state.
fn column_is_zero(regressor: &Function, column: usize) -> bool {
    let output = &regressor.outputs[0];
    (0..output.rows).all(|r| output.entries[r * output.columns + column].is_zero())
}

/// Power of a length in the unit of a parameter, the mass apart.
fn length_degree(robot: &Robot, parameter: StandardParameter) -> i32 {
    match parameter.inertial {
        Inertial::M => 0,
        Inertial::Ia if robot.link(parameter.link).joint.kind == JointKind::Prismatic => 0,
        i if i.is_first_moment() => 1,
        _ => 2,
    }
}
