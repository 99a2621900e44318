//! The base parameters: the smallest set of parameters that determines the torque, each with the parameters that it absorbs.
//!
//! tau = D X = D_base X_base, X: standard parameters, D: their regressor. The columns of D_base are columns of D. From left to
//! right (links in the robot's order, each XX XY XZ YY YZ ZZ MX MY MZ M IA), a column is kept if it is independent of the
//! columns kept before it. Independence is decided in a finite field if the loops allow it ([`crate::base::exact_rank`]),
//! otherwise numerically ([`crate::base::rank`]). A dropped column is a combination of kept columns, D_d = sum_k beta_kd D_k,
//! so its parameter is added to the parameters of these columns:
//!
//! ```text
//! X_base,k = X_k + sum_d beta_kd X_d        [Gautier 1991]
//! ```
//! The numeric rank must equal the rank in the field, and the chosen columns must be numerically independent. If the numeric rank
//! is lower because some columns are too weak, the numerically independent columns are kept and the weak ones are listed
//! ([`WeakParameter`]). The beta are exact in the robot's symbols ([`crate::base::regrouping`]) and are checked against the
//! numeric beta. If any check fails, there are no base parameters ([`crate::base::gate`]). The text of the rules is written only
//! on request ([`crate::base::written_rules`]).

use std::collections::BTreeMap;

use expr::{Function, SymbolKind};
use nalgebra::DMatrix;
use robot::{Robot, StandardParameter};

use crate::base::closed::closed_rank::{ClosedRank, closed_rank};
use crate::base::evidence::{ExactRank, Rank};
use crate::base::exact_rank::independent_columns;
use crate::base::gate::{clear_cut, compared_with_numbers, of_one_rank, stand_out};
use crate::base::names;
use crate::base::rank::{Scan, scan};
use crate::base::regrouping::{Regrouping, Share, Shares, regrouping};
use crate::base::samples::sampled;
use crate::base::triangle::triangle;
use crate::base::unclear_rank::UnclearRank;
use crate::base::weak::{MOST_LEFT_OUT, WEAK_GAP, are_weak, left_out};
use crate::base::written_rules::{RuleSources, Rules};
use crate::derivation::Derivation;

/// The base parameters of a robot and the regrouping that leads to them.
#[derive(Clone, Debug)]
pub struct BaseParameters {
    /// The standard inertial parameters of all links, in the order of the columns of their regressor D.
    pub standard: Vec<StandardParameter>,
    /// The base parameters, in the order of the columns of the base regressor D_base.
    pub base: Vec<BaseParameter>,
    /// Indices of the standard parameters that have no effect on the torque.
    pub no_effect: Vec<usize>,
    /// Standard parameters whose columns in the regressor are so weak that no motion excites the parameters, although these
    /// parameters are identifiable for almost every other robot of this structure. They are omitted.
    pub weak: Vec<WeakParameter>,
    /// The rank of the regressor (number of base parameters) and the evidence for it.
    pub rank: Rank,
    /// The constants that rules and coefficients may name, with their values in m or rad: symbols of the robot's file, and
    /// numbers named by their place (`d3`, `alpha5`). The value of a number is its magnitude.
    pub constants: Vec<(String, f64)>,
    /// The reason why there are no base parameters; `None` if there are base parameters. With a reason, `base` holds the
    /// standard parameters, not regrouped.
    pub refused: Option<UnclearRank>,
    /// The data from which [`BaseParameters::rules`] writes the regrouping rules.
    pub(crate) sources: RuleSources,
}

/// A base parameter: a standard parameter plus multiples of the parameters that it absorbs.
#[derive(Clone, Debug)]
pub struct BaseParameter {
    /// Name as in SYMORO: `XXR2` if the parameter absorbs others, `MY2` if it absorbs no other parameter. Without gravity, the
    /// name of a first moment contains the length through which it acts: `D2MXR4`.
    pub name: String,
    /// Index of the column that is kept for this parameter, in the standard regressor D.
    pub column: usize,
    /// The summands: first the standard parameter itself, then the parameters that it absorbs, in the order of their columns.
    pub terms: Vec<Term>,
    /// Norm of that component of the parameter's regressor column that is independent of the columns before it, divided by the
    /// norm of the largest column. This share bounds the contribution of the parameter to the torque.
    pub share: f64,
}

/// A standard parameter that is omitted, because its regressor column is too weak in every motion.
#[derive(Clone, Copy, Debug)]
pub struct WeakParameter {
    /// Index of the parameter's column in the standard regressor D.
    pub column: usize,
    /// Norm of the omitted component of the parameter's regressor column, divided by the norm of the largest column in the
    /// torque of the same joint.
    pub share: f64,
}

/// A summand of a base parameter: a coefficient times a standard parameter.
#[derive(Clone, Debug)]
pub struct Term {
    /// Index of the standard parameter in [`BaseParameters::standard`].
    pub parameter: usize,
    /// The numeric value of the coefficient, at the robot's values of its symbols.
    pub coefficient: f64,
}

impl BaseParameters {
    /// Number of base parameters.
    pub fn len(&self) -> usize {
        self.base.len()
    }

    /// Whether there are no base parameters, because no parameter has an effect on the torque.
    pub fn is_empty(&self) -> bool {
        self.base.is_empty()
    }

    /// The regrouping rules as text, one per base parameter. If rules in standard parameters are short, they are used;
    /// otherwise the rules also name other regrouped parameters.
    pub fn rules(&self) -> Rules {
        self.sources.short(&self.columns())
    }

    /// The regrouping rules as text, in standard parameters only; `None` if the rules have more than a million summands.
    pub fn expanded_rules(&self) -> Option<Rules> {
        self.sources.expanded(&self.columns())
    }

    /// The regrouping rules as lines to print. A base parameter that absorbs nothing is printed as its name alone. If rules name
    /// regrouped parameters, the rules of these parameters follow.
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

    /// The indices of the columns of the standard regressor D that are kept in the base regressor D_base.
    fn columns(&self) -> Vec<usize> {
        self.base.iter().map(|b| b.column).collect()
    }

    /// The base regressor D_base as a function: the kept columns of `regressor` D, from which these base parameters were derived.
    pub fn regressor(&self, regressor: &Function) -> Function {
        regressor.with_columns("base_regressor", 0, &self.columns())
    }

    /// The values of the base parameters, computed from the values `standard` of the standard parameters.
    pub fn values(&self, standard: &[f64]) -> Vec<f64> {
        let value = |b: &BaseParameter| b.terms.iter().map(|t| t.coefficient * standard[t.parameter]).sum();
        self.base.iter().map(value).collect()
    }
}

impl Derivation<'_> {
    /// Determines the base parameters of `regressor`, which must be the standard regressor of this derivation. Fails if the rank
    /// is not clear-cut.
    pub fn base_parameters(&mut self, regressor: &Function) -> Result<BaseParameters, UnclearRank> {
        let robot = self.robot;
        let standard = StandardParameter::all(robot);
        let Settled { scan, regrouping, weak, left_out, rank } = settled(self, regressor, &standard)?;
        let shares = &regrouping.shares;

        // Each kept column is a base parameter. If no base parameter absorbs a dropped column, the column has no effect on the
        // torque.
        let base: Vec<BaseParameter> =
            scan.kept.iter().map(|&c| base_parameter(robot, &standard, &scan, shares, c)).collect();
        let no_effect = (0..standard.len())
            .filter(|c| scan.kept.binary_search(c).is_err() && shares.get(c).is_none_or(Vec::is_empty))
            .filter(|c| !left_out.contains_key(c))
            .collect();
        let weak = weak.into_iter().map(|column| WeakParameter { column, share: left_out[&column] }).collect();
        let places = self.constants.places(&self.graph);
        let constants = constants(regressor, &places);
        let sources = RuleSources::new(regrouping, robot, &standard, regressor.graph(), places);
        Ok(BaseParameters { standard, base, no_effect, weak, rank, constants, refused: None, sources })
    }

    /// Determines the base parameters of `regressor`. If base parameters are refused although all numbers are finite, the
    /// result holds the standard parameters without regrouping ([`BaseParameters::refused`]). Results that follow from the
    /// standard parameters are right at any rank.
    ///
    /// Fails if a torque is not finite, or if the loops never close.
    pub fn parameters_at_any_rank(&mut self, regressor: &Function) -> Result<BaseParameters, UnclearRank> {
        self.base_parameters(regressor).or_else(|refused| match refused {
            UnclearRank::NotFinite { .. } | UnclearRank::NeverCloses(_) => Err(refused),
            _ => Ok(ungrouped(self, regressor, refused)),
        })
    }
}

/// The standard parameters without regrouping, in the form of base parameters, with the reason `refused`. They are for
/// functions that need no base parameters.
fn ungrouped(derivation: &Derivation, regressor: &Function, refused: UnclearRank) -> BaseParameters {
    let robot = derivation.robot;
    let standard = StandardParameter::all(robot);
    let itself = |(column, s): (usize, &StandardParameter)| {
        let terms = vec![Term { parameter: column, coefficient: 1.0 }];
        BaseParameter { name: s.display(robot).to_string(), column, terms, share: 0.0 }
    };
    let base = standard.iter().enumerate().map(itself).collect();
    let places = derivation.constants.places(&derivation.graph);
    let constants = constants(regressor, &places);
    let sources = RuleSources::new(Regrouping::default(), robot, &standard, regressor.graph(), places);
    let (no_effect, weak, rank) = (Vec::new(), Vec::new(), Rank::of(&Scan::default()));
    BaseParameters { standard, base, no_effect, weak, rank, constants, refused: Some(refused), sources }
}

/// The kept columns, the relations between dropped and kept columns, and the evidence for the rank.
struct Settled {
    scan: Scan,
    regrouping: Regrouping,
    /// Columns that are independent in the finite field, but numerically too weak to be kept.
    weak: Vec<usize>,
    /// For each dropped column whose relation omits weak columns: norm of the omitted component, divided by the norm of the
    /// largest column.
    left_out: BTreeMap<usize, f64>,
    rank: Rank,
}

fn settled(
    derivation: &mut Derivation,
    regressor: &Function,
    standard: &[StandardParameter],
) -> Result<Settled, UnclearRank> {
    let robot = derivation.robot;
    let name = |c: usize| standard[c].display(robot).to_string();

    // Determines the independent columns numerically, and exactly in a finite field if the loops allow it.
    let (sampled, joints) = (sampled(regressor, derivation.closure(), &[]), regressor.outputs[0].rows);
    let triangle = triangle(&sampled, joints);
    let mut closed = None;
    let exact = |stand_out: &dyn Fn(&[usize]) -> bool, expected: usize| {
        if robot.passive.is_empty() {
            let columns = independent_columns(regressor);
            return (ExactRank::Free(columns.len()), columns);
        }
        match closed_rank(derivation, regressor, stand_out, expected) {
            Ok(found) => {
                let ClosedRank { columns, other_assemblies, .. } = closed.insert(found);
                (ExactRank::Closed { rank: columns.len(), other_assemblies: *other_assemblies }, columns.clone())
            }
            Err(reason) => (ExactRank::Unknown(reason), Vec::new()),
        }
    };
    let ColumnChoice { numeric, is_clear, chosen, exact, columns } = choice(&triangle, exact, name)?;

    // Finds the coefficients beta of each dropped column, and compares these coefficients with numeric coefficients.
    let mut related = |scan: Scan, weak: &[usize]| {
        let points = closed.as_ref().map(|closed| &closed.points);
        let regrouping = regrouping(derivation, regressor, standard, &scan, points);
        compared_with_numbers(&scan, &regrouping, weak, name).map(|()| (scan, regrouping))
    };
    let mut weak = Vec::new();
    let (scan, regrouping) = match chosen.and_then(|scan| related(scan, &[])) {
        Ok(found) => found,
        Err(refusal) => {
            weak = columns.iter().copied().filter(|c| numeric.kept.binary_search(c).is_err()).collect();
            let has_more = exact.rank().is_some_and(|exact| exact > numeric.kept.len());
            let is_cut = has_more && Rank::of(&numeric).gap() >= WEAK_GAP;
            if !is_cut || !are_weak(robot, regressor, &numeric, &weak) {
                is_clear?;
                exact.rank().map_or(Ok(()), |_| of_one_rank(&numeric, &columns, name))?;
                return Err(refusal);
            }
            related(numeric, &weak)?
        }
    };
    let left_out = left_out(&sampled, joints, &regrouping.shares, &regrouping.built_on(&weak));
    let most = left_out.values().copied().fold(0.0, f64::max);
    if most > MOST_LEFT_OUT {
        let weak = weak.iter().map(|c| (name(*c), left_out[c])).collect();
        return Err(UnclearRank::Weak { weak, largest_dropped: most });
    }
    let mut rank = Rank { exact, left_out: most, ..Rank::of(&scan) };
    count_relations(&mut rank, &regrouping.shares, &left_out, closed.as_ref());
    Ok(Settled { scan, regrouping, weak, left_out, rank })
}

/// Counts the relations between columns by the evidence for the relation: exact, checked at general points of the finite field,
/// or numeric.
fn count_relations(rank: &mut Rank, shares: &Shares, left_out: &BTreeMap<usize, f64>, closed: Option<&ClosedRank>) {
    for (&column, row) in shares {
        let support: Vec<usize> = row.iter().map(|(kept, _)| *kept).collect();
        let is_exact = row.iter().all(|(_, share)| share.residue.is_some());
        let count = if left_out.contains_key(&column) {
            &mut rank.numeric_relations
        } else if is_exact {
            &mut rank.exact_relations
        } else if closed.is_some_and(|closed| closed.is_spanned(column, &support)) {
            &mut rank.general_relations
        } else {
            &mut rank.numeric_relations
        };
        *count += 1;
    }
}

/// (name, value) of the named constants of the regressor. A number that the robot's file has at several places is listed once
/// for each place.
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

/// The possible choices of the columns to keep.
struct ColumnChoice {
    /// The result of the numeric scan, with the columns that are numerically independent.
    numeric: Scan,
    /// Ok if the numeric scan is clear-cut: the smallest distance of a kept column (from the span of the columns before it) is
    /// much larger than the largest distance of a dropped column.
    is_clear: Result<(), UnclearRank>,
    /// The columns to keep. These are the independent columns of the finite field, if the numeric distances of these columns
    /// are clearly above rounding. If the field has no result, these are the numerically independent columns.
    chosen: Result<Scan, UnclearRank>,
    exact: ExactRank,
    /// The columns that are independent in the finite field; empty if the field has no result.
    columns: Vec<usize>,
}

/// Chooses the columns to keep: the independent columns of the finite field if the field has a result, otherwise the
/// numerically independent columns. `exact(stand_out, expected)` determines the rank in the field; `stand_out` says whether the
/// numeric distances of given columns are clearly above rounding.
fn choice(
    triangle: &DMatrix<f64>,
    exact: impl FnOnce(&dyn Fn(&[usize]) -> bool, usize) -> (ExactRank, Vec<usize>),
    name: impl Fn(usize) -> String,
) -> Result<ColumnChoice, UnclearRank> {
    let not_finite =
        |broken: Vec<usize>| UnclearRank::NotFinite { parameters: broken.into_iter().map(&name).collect() };
    let numeric = scan(triangle, None).map_err(not_finite)?;
    let is_clear = clear_cut(&numeric, &Rank::of(&numeric), &name);
    // The numeric scan has one threshold for all robots. The distance of a column from the span of the columns before it may be
    // below this threshold if the column was chosen in the finite field and its distance is clearly above rounding.
    let chosen = |columns: &[usize]| -> Result<Scan, UnclearRank> {
        if is_clear.is_ok() && numeric.kept == columns {
            return Ok(numeric.clone());
        }
        let chosen = scan(triangle, Some(columns)).map_err(not_finite)?;
        stand_out(&chosen, columns, &name).map(|()| chosen)
    };
    let (exact, columns) = exact(&|columns: &[usize]| chosen(columns).is_ok(), numeric.kept.len());
    let chosen = match exact.rank() {
        Some(_) => chosen(&columns),
        None => is_clear.clone().map(|()| numeric.clone()),
    };
    Ok(ColumnChoice { numeric, is_clear, chosen, exact, columns })
}

/// Makes the base parameter of a kept column: its name, and the parameters that it absorbs.
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
