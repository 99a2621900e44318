//! The base parameters: the least set on which the torque depends, and what was absorbed into each.
//!
//! tau = D X = D_base X_base. The columns of D_base are columns of D, kept from left to right (links
//! in the robot's order, each XX XY XZ YY YZ ZZ MX MY MZ M IA) when they are independent of those
//! kept before; the numbers decide which ([`crate::rank`]). A dropped column is a combination of kept
//! ones, D_d = sum_k beta_k D_k, and its parameter joins theirs:
//!
//! ```text
//! X_base,k = X_k + sum_d beta_kd X_d        [Gautier 1991]
//! ```
//! The numbers choose columns and no more: the beta are exact in the robot's symbols, by the rules of
//! trees ([`crate::rigid_regrouping`]) and, where loops make further relations, by interpolation in a
//! finite field ([`crate::interpolation`]). They are then held against the numeric ones.

use std::collections::BTreeMap;
use std::fmt;

use expr::{Function, Tape};
use nalgebra::DMatrix;
use robot::{Inertial, JointKind, LinkId, Robot, StandardParameter};

use crate::closure::Closure;
use crate::coefficient::Coefficient;
use crate::derivation::{Derivation, NeverCloses};
use crate::exact_rank::independent_columns;
use crate::field::SplitMix;
use crate::interpolation::{Question, interpolate};
use crate::rank::{CLEAR_GAP, Scan, scan};
use crate::rigid_regrouping::relations;
use crate::{names, rule};

/// The base parameters of a robot and the regrouping that leads to them.
#[derive(Clone, Debug)]
pub struct BaseParameters {
    /// The standard parameters, in the order of the columns of D.
    pub standard: Vec<StandardParameter>,
    /// In the order of the columns of D_base.
    pub base: Vec<BaseParameter>,
    /// Indices of the standard parameters that move nothing.
    pub no_effect: Vec<usize>,
    /// Indices of the standard parameters that would be base parameters for robots of this structure in
    /// general, but are not at these numbers: two lengths or angles agree, or gravity is along an axis.
    pub coincident: Vec<usize>,
    pub rank: Rank,
}

/// One base parameter.
#[derive(Clone, Debug)]
pub struct BaseParameter {
    /// SYMORO's name: `XXR2` when something was absorbed, `MY2` when not; without gravity a first
    /// moment carries the length through which it acts: `D2MXR4`.
    pub name: String,
    /// Its column in D.
    pub column: usize,
    /// Itself first, then what it absorbed, by column.
    pub terms: Vec<Term>,
    /// What its column adds to those before it, relative to the largest column: what weight it can have in
    /// the torque.
    pub share: f64,
    /// The terms as a formula: `XXR2 = XX2 - YY2 - D2^2*(M3 + M4)`.
    pub rule: String,
}

/// `coefficient` times a standard parameter.
#[derive(Clone, Debug)]
pub struct Term {
    /// Index in [`BaseParameters::standard`].
    pub parameter: usize,
    pub coefficient: f64,
    /// The coefficient in the robot's symbols; a number where no closed form was found.
    pub symbolic: String,
}

/// The evidence for a rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank {
    /// Number of base parameters.
    pub numeric: usize,
    /// The rank in a finite field, without a tolerance; `None` where loops are closed numerically,
    /// since their passive coordinates are no free elements of a field.
    pub exact: Option<usize>,
    /// Smallest relative distance of a kept column from the span of those before it.
    pub smallest_kept: f64,
    /// Largest relative distance of a dropped one; zero columns count with their norm relative to
    /// the largest column's.
    pub largest_dropped: f64,
    /// How many relations are proven in the symbols, and how many are only numeric.
    pub exact_relations: usize,
    pub numeric_relations: usize,
}

impl Rank {
    /// smallest_kept / largest_dropped, at least 1e3 for a clear-cut rank; infinite when nothing
    /// dropped leaves any distance.
    pub fn gap(&self) -> f64 {
        self.smallest_kept / self.largest_dropped
    }
}

/// Why no base parameters are given: the evidence, for the caller to show.
#[derive(Clone, Debug)]
pub enum UnclearRank {
    /// Some columns are neither clearly independent nor clearly dependent.
    Gap { rank: Rank, doubtful: Vec<(String, f64)> },
    /// The loops were never found closed.
    NeverCloses(NeverCloses),
    /// Columns that the numbers keep although they are dependent for every robot of this structure.
    Exact { numeric: usize, exact: usize, only_numeric: Vec<String> },
    /// The exact coefficient and the numeric one of a regrouping differ.
    Disagreement { dropped: String, kept: String, exact: f64, numeric: f64 },
}

impl fmt::Display for UnclearRank {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UnclearRank::Gap { rank, doubtful } => {
                write!(
                    f,
                    "the rank is not clear-cut: {} columns are independent, the weakest of them by {:.1e}, but a \
                     dropped one stands out by {:.1e} (a factor of {:.0e}; {:.0e} is clear). In doubt:",
                    rank.numeric,
                    rank.smallest_kept,
                    rank.largest_dropped,
                    rank.gap(),
                    CLEAR_GAP
                )?;
                for (name, distance) in doubtful {
                    write!(f, " {name} ({distance:.1e})")?;
                }
                write!(f, ". Look for a length or an angle that is almost, but not quite, zero or a right angle.")
            }
            UnclearRank::NeverCloses(e) => e.fmt(f),
            UnclearRank::Exact { numeric, exact, only_numeric } => write!(
                f,
                "the numeric rank is {numeric}, the exact one {exact}: rounding makes these look independent, which \
                 they are not: {}",
                only_numeric.join(" ")
            ),
            UnclearRank::Disagreement { dropped, kept, exact, numeric } => write!(
                f,
                "the exact rule and the numbers disagree on what {kept} absorbs of {dropped}: {exact} and {numeric}"
            ),
        }
    }
}

impl std::error::Error for UnclearRank {}

impl From<NeverCloses> for UnclearRank {
    fn from(e: NeverCloses) -> UnclearRank {
        UnclearRank::NeverCloses(e)
    }
}

impl BaseParameters {
    /// Number of base parameters.
    pub fn len(&self) -> usize {
        self.base.len()
    }

    pub fn is_empty(&self) -> bool {
        self.base.is_empty()
    }

    /// D_base: the kept columns of the regressor these base parameters came from.
    pub fn regressor(&self, regressor: &Function) -> Function {
        let columns: Vec<usize> = self.base.iter().map(|b| b.column).collect();
        regressor.with_columns("base_regressor", 0, &columns)
    }

    /// X_base from the standard parameters X.
    pub fn values(&self, standard: &[f64]) -> Vec<f64> {
        let value = |b: &BaseParameter| b.terms.iter().map(|t| t.coefficient * standard[t.parameter]).sum();
        self.base.iter().map(value).collect()
    }
}

/// A coefficient of a rule: proven in the symbols, or only a number.
#[derive(Clone, Debug)]
enum Beta {
    Exact(Coefficient),
    Number(f64),
}

pub(crate) fn base_parameters(
    derivation: &mut Derivation,
    regressor: &Function,
) -> Result<BaseParameters, UnclearRank> {
    let robot = derivation.robot;
    let standard = StandardParameter::all(robot);
    let scan = scan(sampled(regressor, derivation.closure()));
    let mut rank = evidence(&scan);
    let name = |c: usize| standard[c].display(robot).to_string();
    if rank.gap() < CLEAR_GAP {
        let in_doubt = |&c: &usize| {
            let d = scan.distance[c];
            d >= rank.largest_dropped && d <= rank.smallest_kept
        };
        let doubtful = (0..standard.len()).filter(in_doubt).map(|c| (name(c), scan.distance[c])).collect();
        return Err(UnclearRank::Gap { rank, doubtful });
    }

    let exact = if robot.passive.is_empty() { independent_columns(regressor) } else { scan.kept.clone() };
    rank.exact = robot.passive.is_empty().then_some(exact.len());
    let (numeric, exact_rank) = (scan.kept.len(), exact.len());
    if numeric > exact_rank {
        let only_numeric = scan.kept.iter().filter(|c| !exact.contains(c)).map(|&c| name(c)).collect();
        return Err(UnclearRank::Exact { numeric, exact: exact_rank, only_numeric });
    }
    let coincident = exact.into_iter().filter(|c| !scan.kept.contains(c)).collect();

    let betas = regrouping(derivation, regressor, &standard, &scan);
    let (exact, numeric): (Vec<_>, Vec<_>) =
        betas.values().partition(|row| row.iter().all(|(_, beta)| matches!(beta, Beta::Exact(_))));
    (rank.exact_relations, rank.numeric_relations) = (exact.len(), numeric.len());

    let graph = regressor.graph();
    let number = |beta: &Beta| match beta {
        Beta::Exact(c) => c.number(graph),
        Beta::Number(x) => *x,
    };
    held_against_numbers(&scan, &betas, number, name)?;

    let mut base = Vec::new();
    for &column in &scan.kept {
        let own = Term { parameter: column, coefficient: 1.0, symbolic: "1".into() };
        let mut terms = vec![own];
        let mut formula = vec![(column, rule::Factor::one())];
        for (&dropped, row) in &betas {
            if let Some((_, beta)) = row.iter().find(|(k, _)| *k == column) {
                let (symbolic, factors) = match beta {
                    Beta::Exact(c) => (c.display(graph).to_string(), rule::Factor::summands(c, graph)),
                    Beta::Number(x) => (rule::rounded(*x).to_string(), vec![rule::Factor::number(*x)]),
                };
                terms.push(Term { parameter: dropped, coefficient: number(beta), symbolic });
                formula.extend(factors.into_iter().map(|factor| (dropped, factor)));
            }
        }
        let bare = names::regrouped(robot, standard[column], terms.len() > 1);
        let rule = rule::text(&bare, &formula, &name);
        base.push(BaseParameter {
            name: names::base(robot, standard[column], bare),
            column,
            terms,
            share: scan.share[column],
            rule,
        });
    }
    let no_effect = (0..standard.len())
        .filter(|c| scan.kept.binary_search(c).is_err() && betas.get(c).is_none_or(Vec::is_empty))
        .collect();
    Ok(BaseParameters { standard, base, no_effect, coincident, rank })
}

/// D at random states, one below the other; loops closed.
fn sampled(regressor: &Function, closure: Option<Closure>) -> DMatrix<f64> {
    let tape = Tape::new(regressor);
    let (n, p) = (regressor.outputs[0].rows, regressor.outputs[0].columns);
    // Three times as many rows as columns, counting for a joint only its own row.
    let n_states = if n == 0 { 0 } else { 3 * p.div_ceil(n) + 8 };
    let mut random = SplitMix(1995);
    let closed = closure.map(|mut closure| closure.sample(n, n_states, &mut random));
    let n_states = closed.as_ref().map_or(n_states, Vec::len);
    let mut states = Vec::with_capacity(n_states * tape.n_inputs());
    for s in 0..n_states {
        match &closed {
            Some(closed) => states.extend(closed[s].0.iter().chain(&closed[s].1)),
            None => states.extend((0..n).map(|_| std::f64::consts::PI * random.unit())),
        }
        // Rates that let inertia, centrifugal and gravity terms weigh alike.
        for scale in [2.0, 4.0] {
            states.extend((0..n).map(|_| scale * random.unit()));
        }
    }
    let mut values = vec![0.0; n_states * n * p];
    tape.evaluate_many(&states, &mut tape.workspace(), &mut values);
    DMatrix::from_row_slice(n_states * n, p, &values)
}

fn evidence(scan: &Scan) -> Rank {
    let smallest_kept = scan.kept.iter().map(|&c| scan.distance[c]).fold(1.0, f64::min);
    let dropped = scan.zero.iter().copied().chain(scan.dependent.iter().map(|d| d.0));
    let largest_dropped = dropped.map(|c| scan.distance[c]).fold(0.0, f64::max);
    Rank {
        numeric: scan.kept.len(),
        exact: None,
        smallest_kept,
        largest_dropped,
        exact_relations: 0,
        numeric_relations: 0,
    }
}

/// For each dropped column, the kept columns it is made of.
fn regrouping(
    derivation: &mut Derivation,
    regressor: &Function,
    standard: &[StandardParameter],
    scan: &Scan,
) -> BTreeMap<usize, Vec<(usize, Beta)>> {
    let Derivation { robot, graph, constants, .. } = derivation;
    let column: BTreeMap<(LinkId, Inertial), usize> =
        standard.iter().enumerate().map(|(c, s)| ((s.link, s.inertial), c)).collect();
    let tree: BTreeMap<usize, Vec<(usize, Coefficient)>> = relations(robot, graph, constants)
        .into_iter()
        .map(|r| (column[&r.dropped], r.terms.into_iter().map(|(p, c)| (column[&p], c)).collect()))
        .collect();

    let numeric: BTreeMap<usize, &Vec<f64>> = scan.dependent.iter().map(|(c, x)| (*c, x)).collect();
    let questions: Vec<Question> = (0..standard.len())
        .filter(|c| scan.kept.binary_search(c).is_err() && !tree.contains_key(c))
        .map(|c| {
            let support: Vec<usize> = match numeric.get(&c) {
                Some(x) => (0..x.len()).filter(|&k| x[k].abs() > 1e-9).map(|k| scan.kept[k]).collect(),
                None => Vec::new(),
            };
            let degree = |k: &usize| length_degree(robot, standard[*k]) - length_degree(robot, standard[c]);
            Question { column: c, degrees: support.iter().map(degree).collect(), support }
        })
        .collect();

    let mut betas: BTreeMap<usize, Vec<(usize, Beta)>> = BTreeMap::new();
    // Where loops are closed numerically only a column that is not there is a fact of the field.
    let answers = if robot.passive.is_empty() {
        interpolate(regressor, &questions)
    } else {
        let absent = |q: &Question| q.support.is_empty() && column_is_zero(regressor, q.column);
        questions.iter().map(|q| absent(q).then(Vec::new)).collect()
    };
    for (question, answer) in questions.iter().zip(answers) {
        let row = match answer {
            Some(x) => question.support.iter().copied().zip(x.into_iter().map(Beta::Exact)).collect(),
            None => {
                let x = numeric.get(&question.column);
                let number = |k: &usize| {
                    let place = scan.kept.binary_search(k).unwrap_or_default();
                    (*k, Beta::Number(x.map_or(0.0, |x| x[place])))
                };
                question.support.iter().map(number).collect()
            }
        };
        betas.insert(question.column, row);
    }
    // A tree's rule leads to columns before it; those are resolved by then.
    let graph = regressor.graph();
    for (&dropped, terms) in &tree {
        let mut row: BTreeMap<usize, Beta> = BTreeMap::new();
        for (c, factor) in terms {
            let parts = match betas.get(c) {
                Some(parts) => parts.clone(),
                None => vec![(*c, Beta::Exact(Coefficient::one()))],
            };
            for (k, beta) in parts {
                let term = match beta {
                    Beta::Exact(beta) => Beta::Exact(factor.times(&beta)),
                    Beta::Number(x) => Beta::Number(factor.number(graph) * x),
                };
                let sum = match (row.remove(&k), term) {
                    (None, term) => term,
                    (Some(Beta::Exact(a)), Beta::Exact(b)) => Beta::Exact(a.plus(&b)),
                    (Some(a), b) => {
                        let value = |beta: &Beta| match beta {
                            Beta::Exact(c) => c.number(graph),
                            Beta::Number(x) => *x,
                        };
                        Beta::Number(value(&a) + value(&b))
                    }
                };
                row.insert(k, sum);
            }
        }
        row.retain(|_, beta| !matches!(beta, Beta::Exact(c) if c.is_zero()));
        betas.insert(dropped, row.into_iter().collect());
    }
    betas
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

/// The exact coefficients must be the numeric ones, to the accuracy of the latter.
fn held_against_numbers(
    scan: &Scan,
    betas: &BTreeMap<usize, Vec<(usize, Beta)>>,
    number: impl Fn(&Beta) -> f64,
    name: impl Fn(usize) -> String,
) -> Result<(), UnclearRank> {
    let nothing = vec![0.0; scan.kept.len()];
    let rows = scan.dependent.iter().map(|(c, x)| (*c, x)).chain(scan.zero.iter().map(|&c| (c, &nothing)));
    for (dropped, x) in rows {
        for (place, &kept) in scan.kept.iter().enumerate() {
            let beta = betas[&dropped].iter().find(|(k, _)| *k == kept);
            let exact = beta.map_or(0.0, |(_, beta)| number(beta));
            // The weakest kept column amplifies rounding by the inverse of its distance.
            if (exact - x[place]).abs() > 1e-6 * (1.0 + exact.abs()) {
                let (dropped, kept) = (name(dropped), name(kept));
                return Err(UnclearRank::Disagreement { dropped, kept, exact, numeric: x[place] });
            }
        }
    }
    Ok(())
}
