//! The base parameters: the least set on which the torque depends, and what was absorbed into each.
//!
//! tau = D X = D_base X_base. The columns of D_base are columns of D, kept from left to right (links
//! in the robot's order, each XX XY XZ YY YZ ZZ MX MY MZ M IA) when they are independent of those
//! kept before, in a finite field where loops allow it ([`crate::base::exact_rank`]), else by the numbers
//! ([`crate::base::rank`]). A dropped column is a combination of kept
//! ones, D_d = sum_k beta_k D_k, and its parameter joins theirs:
//!
//! ```text
//! X_base,k = X_k + sum_d beta_kd X_d        [Gautier 1991]
//! ```
//! The numbers must find the same rank, and the chosen columns independent. The beta are exact in the robot's symbols
//! ([`crate::base::regrouping`]) and are checked against the numeric ones. Where any of this fails there are no base
//! parameters ([`crate::base::gate`]). Their text is written only on request
//! ([`crate::base::written_rules`]).

use std::collections::BTreeMap;

use expr::{Function, SymbolKind, Tape};
use nalgebra::DMatrix;
use robot::{Robot, StandardParameter};

use crate::base::closed::closed_rank::closed_rank;
use crate::base::evidence::{ExactRank, Rank};
use crate::base::exact_rank::independent_columns;
use crate::base::gate::{clear_cut, held_against_numbers, of_one_rank, stand_out};
use crate::base::names;
use crate::base::rank::{Scan, scan};
use crate::base::regrouping::{Share, Shares, regrouping};
use crate::base::triangle::triangle;
use crate::base::unclear_rank::UnclearRank;
use crate::base::written_rules::{RuleSources, Rules};
use crate::derivation::Derivation;
use crate::kinematics::closure::Closure;
use random::SplitMix;

/// The base parameters of a robot and the regrouping that leads to them.
#[derive(Clone, Debug)]
pub struct BaseParameters {
    /// The standard parameters, in the order of the columns of D.
    pub standard: Vec<StandardParameter>,
    /// In the order of the columns of D_base.
    pub base: Vec<BaseParameter>,
    /// Indices of the standard parameters that have no effect on the torque.
    pub no_effect: Vec<usize>,
    /// The evidence for the number of base parameters.
    pub rank: Rank,
    /// What rules and coefficients may name, with its value, m or rad: the symbols of the file, and numbers by their place
    /// (`d3`, `alpha5`; always their magnitude).
    pub constants: Vec<(String, f64)>,
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
    let joints = regressor.outputs[0].rows;

    // Which columns are independent: by numbers, and exactly, in a finite field where loops allow it.
    let sampled = sampled(regressor, derivation.closure());
    let mut closed = None;
    let exact = |stand_out: &dyn Fn(&[usize]) -> bool, expected: usize| {
        if derivation.robot.passive.is_empty() {
            let columns = independent_columns(regressor);
            return (ExactRank::Free(columns.len()), columns);
        }
        match closed_rank(derivation, regressor, stand_out, expected) {
            Ok(found) => {
                let columns = closed.insert(found).columns.clone();
                let other_assemblies = closed.as_ref().is_some_and(|c| c.other_assemblies);
                (ExactRank::Closed { rank: columns.len(), other_assemblies }, columns)
            }
            Err(reason) => (ExactRank::Unknown(reason), Vec::new()),
        }
    };
    let (scan, exact) = chosen_columns(&sampled, joints, exact, name)?;
    let mut rank = Rank::of(&scan);
    rank.exact = exact;

    // The beta of each dropped column, and how each is known: exactly, at general points, by numbers.
    let regrouping = regrouping(derivation, regressor, &standard, &scan, closed.as_ref().map(|closed| &closed.points));
    let shares = &regrouping.shares;
    for (&column, row) in shares {
        let support: Vec<usize> = row.iter().map(|(kept, _)| *kept).collect();
        let count = if row.iter().all(|(_, share)| share.residue.is_some()) {
            &mut rank.exact_relations
        } else if closed.as_ref().is_some_and(|closed| closed.is_spanned(column, &support)) {
            &mut rank.general_relations
        } else {
            &mut rank.numeric_relations
        };
        *count += 1;
    }
    held_against_numbers(&scan, shares, name)?;

    // Each kept column is a base parameter; a dropped one that joins none has no effect.
    let base: Vec<BaseParameter> =
        scan.kept.iter().map(|&c| base_parameter(robot, &standard, &scan, shares, c)).collect();
    let no_effect = (0..standard.len())
        .filter(|c| scan.kept.binary_search(c).is_err() && shares.get(c).is_none_or(Vec::is_empty))
        .collect();
    let places = derivation.constants.places(&derivation.graph);
    let constants = constants(regressor, &places);
    let sources = RuleSources::new(regrouping, robot, &standard, regressor.graph(), places);
    Ok(BaseParameters { standard, base, no_effect, rank, constants, sources })
}

/// The named constants of the regressor, each number at each of its places.
fn constants(regressor: &Function, places: &BTreeMap<String, Vec<String>>) -> Vec<(String, f64)> {
    let symbols = regressor.graph().symbols().iter();
    let constant = |(name, kind): &(String, SymbolKind)| match kind {
        SymbolKind::Constant(x) => Some((name.clone(), *x)),
        SymbolKind::Input => None,
    };
    symbols
        .filter_map(constant)
        .flat_map(|(name, x)| {
            let names = places.get(&name).cloned().unwrap_or(vec![name]);
            names.into_iter().map(move |name| (name, x))
        })
        .collect()
}

/// The columns to keep, with the evidence of the numbers: those of the field where there are such. `exact` may ask
/// whether columns stand out by the numbers.
fn chosen_columns(
    sampled: &DMatrix<f64>,
    joints: usize,
    exact: impl FnOnce(&dyn Fn(&[usize]) -> bool, usize) -> (ExactRank, Vec<usize>),
    name: impl Fn(usize) -> String,
) -> Result<(Scan, ExactRank), UnclearRank> {
    let not_finite =
        |broken: Vec<usize>| UnclearRank::NotFinite { parameters: broken.into_iter().map(&name).collect() };
    let triangle = triangle(sampled, joints);
    let numeric = scan(&triangle, None).map_err(not_finite)?;
    let is_clear = clear_cut(&numeric, &Rank::of(&numeric), &name);
    // The numbers alone draw the line at one distance for all robots. Where the chosen columns stand out of the others
    // clearly, they may do so by less.
    let chosen = |columns: &[usize]| -> Result<Scan, UnclearRank> {
        if is_clear.is_ok() && numeric.kept == columns {
            return Ok(numeric.clone());
        }
        let chosen = scan(&triangle, Some(columns)).map_err(not_finite)?;
        stand_out(&chosen, columns, &name).map(|()| chosen)
    };
    let (exact, columns) = exact(&|columns: &[usize]| chosen(columns).is_ok(), numeric.kept.len());
    if exact.rank().is_none() {
        return is_clear.map(|()| (numeric, exact));
    }
    let scan = chosen(&columns).or_else(|weak| {
        is_clear?;
        of_one_rank(&numeric, &columns, &name)?;
        Err(weak)
    })?;
    Ok((scan, exact))
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
