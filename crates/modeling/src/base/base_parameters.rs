//! The base parameters: the least set on which the torque depends, and what was absorbed into each.
//!
//! tau = D X = D_base X_base. The columns of D_base are columns of D, kept from left to right (links
//! in the robot's order, each XX XY XZ YY YZ ZZ MX MY MZ M IA) when they are independent of those
//! kept before; the numbers decide which ([`crate::base::rank`]). A dropped column is a combination of kept
//! ones, D_d = sum_k beta_k D_k, and its parameter joins theirs:
//!
//! ```text
//! X_base,k = X_k + sum_d beta_kd X_d        [Gautier 1991]
//! ```
//! The numbers only choose the columns. The beta are exact in the robot's symbols ([`crate::base::regrouping`]) and are
//! checked against the numeric ones ([`crate::base::evidence`]). Their text is written only on request
//! ([`crate::base::written_rules`]).

use expr::{Function, Tape};
use nalgebra::DMatrix;
use robot::{Robot, StandardParameter};

use crate::base::evidence::{Rank, UnclearRank, clear_cut, held_against_numbers, no_more_than_exact};
use crate::base::exact_rank::independent_columns;
use crate::base::names;
use crate::base::rank::{Scan, scan};
use crate::base::regrouping::{Share, Shares, regrouping};
use crate::base::written_rules::{RuleSources, Rules};
use crate::derivation::Derivation;
use crate::kinematics::closure::Closure;
use crate::random::SplitMix;

/// The base parameters of a robot and the regrouping that leads to them.
#[derive(Clone, Debug)]
pub struct BaseParameters {
    /// The standard parameters, in the order of the columns of D.
    pub standard: Vec<StandardParameter>,
    /// In the order of the columns of D_base.
    pub base: Vec<BaseParameter>,
    /// Indices of the standard parameters that have no effect on the torque.
    pub no_effect: Vec<usize>,
    /// Indices of the standard parameters that would be base parameters for robots of this structure in
    /// general, but are not at these numbers: two lengths or angles agree, or gravity is along an axis.
    pub coincident: Vec<usize>,
    /// The evidence for the number of base parameters.
    pub rank: Rank,
    /// The data from which [`BaseParameters::rules`] writes the rules.
    pub(crate) sources: RuleSources,
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
}

/// `coefficient` times a standard parameter.
#[derive(Clone, Debug)]
pub struct Term {
    /// Index in [`BaseParameters::standard`].
    pub parameter: usize,
    /// The factor at the robot's values of its symbols.
    pub coefficient: f64,
}

impl BaseParameters {
    /// Number of base parameters.
    pub fn len(&self) -> usize {
        self.base.len()
    }

    /// Whether no parameter has an effect.
    pub fn is_empty(&self) -> bool {
        self.base.is_empty()
    }

    /// The rules as text: expanded to standard parameters where that is short, else nested.
    pub fn rules(&self) -> Rules {
        self.sources.short(&self.columns())
    }

    /// The rules expanded to standard parameters; `None` where they have more than a million summands.
    pub fn expanded_rules(&self) -> Option<Rules> {
        self.sources.expanded(&self.columns())
    }

    /// The rules as lines to print. A base parameter that absorbs nothing is printed as its name alone. Nested rules
    /// are followed by the rules of the regrouped parameters that they name.
    pub fn rule_lines(&self) -> Vec<String> {
        let rules = self.rules();
        let line = |(b, rule): (&BaseParameter, String)| if b.terms.len() > 1 { rule } else { b.name.clone() };
        let mut lines: Vec<String> = self.base.iter().zip(rules.base).map(line).collect();
        if !rules.regrouped.is_empty() {
            lines.push("with these regrouped parameters, which are no base parameters:".into());
            lines.extend(rules.regrouped);
        }
        lines
    }

    /// The columns of D that D_base keeps.
    fn columns(&self) -> Vec<usize> {
        self.base.iter().map(|b| b.column).collect()
    }

    /// D_base: the kept columns of the regressor these base parameters came from.
    pub fn regressor(&self, regressor: &Function) -> Function {
        regressor.with_columns("base_regressor", 0, &self.columns())
    }

    /// X_base from the standard parameters X.
    pub fn values(&self, standard: &[f64]) -> Vec<f64> {
        let value = |b: &BaseParameter| b.terms.iter().map(|t| t.coefficient * standard[t.parameter]).sum();
        self.base.iter().map(value).collect()
    }
}

/// The base parameters of `regressor`, which must be the derivation's own.
pub(crate) fn base_parameters(
    derivation: &mut Derivation,
    regressor: &Function,
) -> Result<BaseParameters, UnclearRank> {
    let robot = derivation.robot;
    let standard = StandardParameter::all(robot);
    let name = |c: usize| standard[c].display(robot).to_string();

    let scan = scan(&sampled(regressor, derivation.closure()), regressor.outputs[0].rows);
    let mut rank = Rank::of(&scan);
    clear_cut(&scan, &rank, name)?;

    // Passive coordinates are solved numerically, so they cannot be drawn freely in a finite field.
    let exact = robot.passive.is_empty().then(|| independent_columns(regressor));
    let mut coincident = Vec::new();
    if let Some(exact) = exact {
        rank.exact = Some(exact.len());
        no_more_than_exact(&scan, &exact, name)?;
        coincident = exact.into_iter().filter(|c| !scan.kept.contains(c)).collect();
    }

    let regrouping = regrouping(derivation, regressor, &standard, &scan);
    let shares = &regrouping.shares;
    let all_exact = |row: &&Vec<(usize, Share)>| row.iter().all(|(_, share)| share.residue.is_some());
    rank.exact_relations = shares.values().filter(all_exact).count();
    rank.numeric_relations = shares.len() - rank.exact_relations;
    held_against_numbers(&scan, shares, name)?;

    let base: Vec<BaseParameter> =
        scan.kept.iter().map(|&c| base_parameter(robot, &standard, &scan, shares, c)).collect();
    let no_effect = (0..standard.len())
        .filter(|c| scan.kept.binary_search(c).is_err() && shares.get(c).is_none_or(Vec::is_empty))
        .collect();
    let sources = RuleSources::new(regrouping, robot, &standard, regressor.graph());
    Ok(BaseParameters { standard, base, no_effect, coincident, rank, sources })
}

/// The base parameter of a kept column: what it absorbs, and its name.
fn base_parameter(
    robot: &Robot,
    standard: &[StandardParameter],
    scan: &Scan,
    shares: &Shares,
    column: usize,
) -> BaseParameter {
    let mut terms = vec![Term { parameter: column, coefficient: 1.0 }];
    let share_of = |row: &[(usize, Share)]| row.iter().find(|(kept, _)| *kept == column).map(|(_, share)| share.number);
    let absorbed = shares.iter().filter_map(|(&parameter, row)| Some((parameter, share_of(row)?)));
    terms.extend(absorbed.map(|(parameter, coefficient)| Term { parameter, coefficient }));
    let plain = standard[column].display(robot).to_string();
    let bare = if terms.len() > 1 { names::regrouped(&plain, standard[column].inertial) } else { plain };
    let name = names::base(robot, standard[column], bare);
    BaseParameter { name, column, terms, share: scan.share[column] }
}

/// D at random states with closed loops, stacked state by state.
fn sampled(regressor: &Function, closure: Option<Closure>) -> DMatrix<f64> {
    let tape = Tape::new(regressor);
    let (n, p) = (regressor.outputs[0].rows, regressor.outputs[0].columns);
    // Three times as many rows as columns, even where a link's columns are non-zero only in the row of its own joint.
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
