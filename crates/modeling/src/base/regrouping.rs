//! Determines the relation of each dropped column of the regressor D to the kept columns: D_d = sum_k beta_kd D_k.
//!
//! The coefficients have three sources, the most reliable first:
//!
//! - the rules of trees ([`crate::base::rigid_regrouping`]), exact in the robot's symbols. A rule expresses a dropped column by
//!   columns before it. If one of these columns is dropped too, the relation of this column is substituted;
//! - for columns without a rule, because loops couple them, interpolation in a finite field ([`crate::base::interpolation`]),
//!   exact too;
//! - if interpolation finds no closed form, the numeric coefficients of the scan.
//!
//! The rules are stored unexpanded: each has columns of the link and its antecedent. Here they are multiplied out only as
//! numbers; [`crate::base::written_rules`] writes them as text.

use std::collections::{BTreeMap, BTreeSet};

use expr::{Function, Graph};
use robot::{Inertial, JointKind, LinkId, Robot, StandardParameter};

use crate::base::closed::closed_point::ClosedPoints;
use crate::base::coefficient::Coefficient;
use crate::base::evidence::agree;
use crate::base::field::{Assignment, Residue};
use crate::base::interpolation::{Relation, interpolate};
use crate::base::rank::Scan;
use crate::base::rigid_regrouping::tree_rules;
use crate::derivation::Derivation;
use random::SplitMix;

/// A numeric coefficient of a relation counts as zero if it is below this value. The rounding of the scan is about 1e-13. A
/// true coefficient is a product of at most two lengths in m, and two lengths of 0.1 mm give 1e-8.
const ROUNDED_ZERO: f64 = 1e-9;

/// A coefficient beta of a relation between columns: exact in the symbols, or only a number.
#[derive(Clone, Debug)]
pub(crate) enum Beta {
    Exact(Coefficient),
    Number(f64),
}

impl Beta {
    /// The numeric value of the coefficient, and its element of the finite field if it is exact.
    fn share(&self, graph: &Graph, constants: &[Assignment]) -> Share {
        match self {
            Beta::Exact(c) => Share::of(c, graph, constants),
            Beta::Number(x) => Share { number: *x, residue: None },
        }
    }
}

/// The coefficient of a kept column after all rules are substituted, as numbers and not as text. For a chain of n oblique links
/// the texts grow faster than any power of n, but the number of coefficients grows as n^2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Share {
    /// The numeric value, at the robot's values of its symbols.
    pub number: f64,
    /// The value in a finite field at random elements of the symbols, where a zero is exact. `None` if a factor is only a number.
    pub residue: Option<Residue>,
}

impl Share {
    fn of(c: &Coefficient, graph: &Graph, constants: &[Assignment]) -> Share {
        Share { number: c.number(graph), residue: Some(c.residue(constants)) }
    }

    fn plus(self, other: Share) -> Share {
        let residue = self.residue.zip(other.residue).map(|(a, b)| a + b);
        Share { number: self.number + other.number, residue }
    }

    fn times(self, factor: Share) -> Share {
        let residue = self.residue.zip(factor.residue).map(|(a, b)| a * b);
        Share { number: factor.number * self.number, residue }
    }
}

/// The relations of the dropped columns, both as separate rules and with every rule substituted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Regrouping {
    /// Dropped column without a tree rule -> its kept columns and their coefficients. The list is empty for a column that is
    /// zero.
    pub solved: BTreeMap<usize, Vec<(usize, Beta)>>,
    /// Dropped column with a tree rule -> the columns of the rule and their coefficients.
    pub rules: TreeRules,
    /// Dropped column -> its kept columns and their coefficients, with every rule substituted.
    pub shares: Shares,
}

impl Regrouping {
    /// The `weak` columns, and the dropped columns whose rules contain weak columns. The relations of these dropped columns
    /// omit the contribution of weak columns.
    pub(crate) fn built_on(&self, weak: &[usize]) -> BTreeSet<usize> {
        let mut built: BTreeSet<usize> = weak.iter().copied().collect();
        for (dropped, terms) in &self.rules {
            if terms.iter().any(|(c, _)| built.contains(c)) {
                built.insert(*dropped);
            }
        }
        built
    }
}

/// Dropped column -> its kept columns, each with its coefficient.
pub(crate) type Shares = BTreeMap<usize, Vec<(usize, Share)>>;

/// Dropped column -> the columns of its tree rule and their coefficients; these columns may be dropped themselves.
pub(crate) type TreeRules = BTreeMap<usize, Vec<(usize, Coefficient)>>;

/// Determines the relation of every column that `scan` does not keep. `closed`: finds points that close the loops; `None`: not
/// available.
pub(crate) fn regrouping(
    derivation: &mut Derivation,
    regressor: &Function,
    standard: &[StandardParameter],
    scan: &Scan,
    closed: Option<&ClosedPoints>,
) -> Regrouping {
    let mut rules = rules_by_column(derivation, standard);
    // Remove the rules of kept columns: a column with a rule is kept if a column on the rule's right-hand side is too weak to be
    // kept.
    rules.retain(|column, _| scan.kept.binary_search(column).is_err());
    let numeric: BTreeMap<usize, &Vec<f64>> = scan.dependent.iter().map(|(c, x)| (*c, x)).collect();
    let unexplained = unexplained(derivation.robot, standard, scan, &rules, &numeric);
    let solved = solved(derivation.robot, regressor, scan, &unexplained, &numeric, closed);
    let shares = put_in(&solved, &rules, regressor.graph());
    Regrouping { solved, rules, shares }
}

fn rules_by_column(derivation: &mut Derivation, standard: &[StandardParameter]) -> TreeRules {
    let Derivation { robot, graph, constants, .. } = derivation;
    let column: BTreeMap<(LinkId, Inertial), usize> =
        standard.iter().enumerate().map(|(c, s)| ((s.link, s.inertial), c)).collect();
    tree_rules(robot, graph, constants)
        .into_iter()
        .map(|rule| (column[&rule.dropped], rule.terms.into_iter().map(|(p, c)| (column[&p], c)).collect()))
        .collect()
}

/// The dropped columns without a tree rule, each with the kept columns for which the dropped column has a non-zero numeric
/// coefficient.
fn unexplained(
    robot: &Robot,
    standard: &[StandardParameter],
    scan: &Scan,
    rules: &TreeRules,
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

/// Coefficients of the relations: exact if the interpolation in the finite field finds exact coefficients, otherwise numeric
/// from the scan.
fn solved(
    robot: &Robot,
    regressor: &Function,
    scan: &Scan,
    relations: &[Relation],
    numeric: &BTreeMap<usize, &Vec<f64>>,
    closed: Option<&ClosedPoints>,
) -> BTreeMap<usize, Vec<(usize, Beta)>> {
    let number = |relation: &Relation, kept: usize| -> f64 {
        let place = scan.kept.binary_search(&kept).unwrap_or_default();
        numeric.get(&relation.column).map_or(0.0, |x| x[place])
    };
    let mut exact: Vec<Option<Vec<Coefficient>>> = match closed {
        _ if robot.passive.is_empty() => interpolate(regressor, relations, None),
        Some(closed) => interpolate(regressor, relations, Some(closed)),
        None => vec![None; relations.len()],
    };
    for (relation, exact) in relations.iter().zip(&mut exact).filter(|_| !robot.passive.is_empty()) {
        // The closed points (random states with closed loops) may belong to another assembly of the loops than the numbers of
        // the robot's file. Then the coefficients at these points differ from the numeric coefficients and are not used.
        let agrees = |(&kept, c): (&usize, &Coefficient)| agree(c.number(regressor.graph()), number(relation, kept));
        let is_of_another = exact.as_ref().is_some_and(|c| !relation.support.iter().zip(c).all(agrees));
        // A column that is zero as an expression is zero in every assembly.
        let is_absent = relation.support.is_empty() && column_is_zero(regressor, relation.column);
        *exact = exact.take().filter(|_| !is_of_another).or(is_absent.then(Vec::new));
    }
    let row = |relation: &Relation, exact: Option<Vec<Coefficient>>| -> Vec<(usize, Beta)> {
        if let Some(coefficients) = exact {
            return relation.support.iter().copied().zip(coefficients.into_iter().map(Beta::Exact)).collect();
        }
        relation.support.iter().map(|&kept| (kept, Beta::Number(number(relation, kept)))).collect()
    };
    relations.iter().zip(exact).map(|(relation, exact)| (relation.column, row(relation, exact))).collect()
}

/// Seed of the random field elements of the symbols in [`put_in`].
const SHARE_SEED: u64 = 1990;

/// Relations of all dropped columns: the solved relations, and the relations from the rules D_d = sum_c factor_c D_c. If a
/// column c is dropped too, the relation of c is substituted. The columns c come before d, so their relations are already
/// expanded.
fn put_in(solved: &BTreeMap<usize, Vec<(usize, Beta)>>, rules: &TreeRules, graph: &Graph) -> Shares {
    let mut random = SplitMix(SHARE_SEED);
    let constants: Vec<Assignment> = graph.symbols().iter().map(|_| Assignment::random(&mut random)).collect();
    let of_solved = |(k, beta): &(usize, Beta)| (*k, beta.share(graph, &constants));
    let mut shares: Shares = solved.iter().map(|(&c, row)| (c, row.iter().map(of_solved).collect())).collect();
    for (&dropped, terms) in rules {
        let mut row: BTreeMap<usize, Share> = BTreeMap::new();
        for (c, factor) in terms {
            let factor = Share::of(factor, graph, &constants);
            let kept = [(*c, Share { number: 1.0, residue: Some(Residue::ONE) })];
            for &(kept, share) in shares.get(c).map_or(&kept[..], Vec::as_slice) {
                let term = share.times(factor);
                let sum = row.get(&kept).map_or(term, |before| before.plus(term));
                row.insert(kept, sum);
            }
        }
        row.retain(|_, share| share.residue != Some(Residue::ZERO));
        shares.insert(dropped, row.into_iter().collect());
    }
    shares
}

/// Whether a column of the regressor is identically zero.
fn column_is_zero(regressor: &Function, column: usize) -> bool {
    let output = &regressor.outputs[0];
    (0..output.rows).all(|r| output.entries[r * output.columns + column].is_zero())
}

/// The power of length in the unit of a parameter, kg m^degree.
fn length_degree(robot: &Robot, parameter: StandardParameter) -> i32 {
    match parameter.inertial {
        Inertial::M => 0,
        Inertial::Ia if robot.link(parameter.link).joint.kind == JointKind::Prismatic => 0,
        i if i.is_first_moment() => 1,
        _ => 2,
    }
}
