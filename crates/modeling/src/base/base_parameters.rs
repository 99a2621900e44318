//! The base parameters: the smallest set that determines the torque, and the parameters that each one absorbed.
//!
//! tau = D X = D_base X_base. The columns of D_base are columns of D, kept from left to right (links
//! in the robot's order, each XX XY XZ YY YZ ZZ MX MY MZ M IA) when they are independent of the columns
//! kept before: in a finite field where loops allow it ([`crate::base::exact_rank`]), else numerically
//! ([`crate::base::rank`]). A dropped column is a combination of kept
//! columns, D_d = sum_k beta_k D_k, and its parameter is added to theirs:
//!
//! ```text
//! X_base,k = X_k + sum_d beta_kd X_d        [Gautier 1991]
//! ```
//! The numeric rank must equal the rank in the field, and the chosen columns must be numerically independent. Where the
//! numeric rank is lower because some columns are too weak, the numeric columns are kept and the weak ones are listed
//! ([`WeakParameter`]). The beta are exact in the robot's symbols ([`crate::base::regrouping`]) and are checked against
//! the numeric beta. Where any of this fails there are no base parameters ([`crate::base::gate`]). The text of the rules
//! is written only on request ([`crate::base::written_rules`]).

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
    /// The standard parameters, in the order of the columns of D.
    pub standard: Vec<StandardParameter>,
    /// The base parameters, in the order of the columns of D_base.
    pub base: Vec<BaseParameter>,
    /// Indices of the standard parameters that have no effect on the torque.
    pub no_effect: Vec<usize>,
    /// Parameters that are independent for almost every robot of this structure, but whose columns are so weak at these
    /// numbers that no motion excites them: they are omitted.
    pub weak: Vec<WeakParameter>,
    /// The evidence for the number of base parameters.
    pub rank: Rank,
    /// The constants that rules and coefficients may name, with their values in m or rad: the symbols of the file, and
    /// numbers by their place (`d3`, `alpha5`; always their magnitude).
    pub constants: Vec<(String, f64)>,
    /// Why there are no base parameters; `base` then holds the standard parameters, each for itself.
    pub refused: Option<UnclearRank>,
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
    /// The parameter itself first, then the parameters that it absorbed, by column.
    pub terms: Vec<Term>,
    /// Norm of the component of its column that is independent of the columns before it, relative to the norm of the
    /// largest column: a bound of its weight in the torque.
    pub share: f64,
}

/// A standard parameter whose column is too weak for every motion.
#[derive(Clone, Copy, Debug)]
pub struct WeakParameter {
    /// Its column in D.
    pub column: usize,
    /// The omitted component of its column, relative to the largest column in the torque of the same joint.
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

impl Derivation<'_> {
    /// The base parameters of `regressor`, which must be the regressor of this derivation. Fails when the rank is not
    /// clear-cut.
    pub fn base_parameters(&mut self, regressor: &Function) -> Result<BaseParameters, UnclearRank> {
        let robot = self.robot;
        let standard = StandardParameter::all(robot);
        let Settled { scan, regrouping, weak, left_out, rank } = settled(self, regressor, &standard)?;
        let shares = &regrouping.shares;

        // Each kept column is a base parameter. A dropped column that is part of no base parameter has no effect.
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

    /// The base parameters of `regressor`; where they are refused although all numbers are finite, the standard parameters,
    /// each for itself ([`BaseParameters::refused`]). Results that follow from the standard parameters are right at any rank.
    ///
    /// Fails where a torque is not finite, or where the loops never close.
    pub fn parameters_at_any_rank(&mut self, regressor: &Function) -> Result<BaseParameters, UnclearRank> {
        self.base_parameters(regressor).or_else(|refused| match refused {
            UnclearRank::NotFinite { .. } | UnclearRank::NeverCloses(_) => Err(refused),
            _ => Ok(ungrouped(self, regressor, refused)),
        })
    }
}

/// The standard parameters of `regressor`, each for itself, for functions that need no base parameters.
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

/// The kept columns, and the relations of the dropped columns to them.
struct Settled {
    scan: Scan,
    regrouping: Regrouping,
    /// Columns of the field that are too weak to be kept.
    weak: Vec<usize>,
    /// Column whose relation omits the contribution of weak columns -> size of the omission relative to the largest column.
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

    // Which columns are independent: by numbers, and exactly, in a finite field where loops allow it.
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

    // The beta of each dropped column.
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

/// Counts the relations by how they are known: exactly, at general points, numerically.
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

/// The columns that may be kept.
struct ColumnChoice {
    /// The numerically independent columns.
    numeric: Scan,
    /// Whether the numeric distances have a clear gap.
    is_clear: Result<(), UnclearRank>,
    /// The columns of the field where their numeric distances stand out; the numeric columns where the field has no result.
    chosen: Result<Scan, UnclearRank>,
    exact: ExactRank,
    /// The columns that are independent in the field.
    columns: Vec<usize>,
}

/// The columns to keep, with the numeric evidence: the columns of the field where it has a result. `exact` may ask whether
/// the numeric distances of given columns stand out.
fn choice(
    triangle: &DMatrix<f64>,
    exact: impl FnOnce(&dyn Fn(&[usize]) -> bool, usize) -> (ExactRank, Vec<usize>),
    name: impl Fn(usize) -> String,
) -> Result<ColumnChoice, UnclearRank> {
    let not_finite =
        |broken: Vec<usize>| UnclearRank::NotFinite { parameters: broken.into_iter().map(&name).collect() };
    let numeric = scan(triangle, None).map_err(not_finite)?;
    let is_clear = clear_cut(&numeric, &Rank::of(&numeric), &name);
    // The numeric scan alone has one threshold for all robots. Columns that the field has chosen may have smaller distances
    // where these still stand out clearly.
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

/// The base parameter of a kept column: the parameters that it absorbs, and its name.
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
