//! Finds the coefficients of dropped columns for which there is no joint-by-joint rule. The coefficients are solved for at
//! random points of a finite field, then interpolated in the robot's symbols.
//!
//! Loops of passive joints cause dependencies of columns that no joint-by-joint rule describes. If a column is numerically a
//! combination of a few others, the combination is solved for exactly at random states and random symbols modulo a prime. Then a
//! Laurent polynomial in the relevant symbols, of the right physical dimension, is fitted and checked at further points. Only an
//! exact fit is accepted.

use std::collections::{BTreeMap, BTreeSet};

use expr::{Function, SymbolKind};

use crate::base::angles::GraphAngles;
use crate::base::closed::closed_point::ClosedPoints;
use crate::base::closed::curve::{curve, regressor_rows};
use crate::base::coefficient::{Atom, Coefficient, Monomial, residue};
use crate::base::exact_rank::Echelon;
use crate::base::field::{Assignment, Residue, solve};
use crate::base::field_algebra::FieldAlgebra;
use random::SplitMix;

/// A column that may be a linear combination of other columns: `column` = sum_k x_k support_k, with unknown coefficients x_k.
pub(crate) struct Relation {
    pub column: usize,
    pub support: Vec<usize>,
    /// For each coefficient x_k, the power of length (m) in the unit of x_k.
    pub degrees: Vec<i32>,
}

/// For each relation, its coefficients x_k in the finite field; `None` if no x satisfies the relation, or more than one.
type Solutions = Vec<Option<Vec<Residue>>>;

/// Random field elements of the constants, and the coefficients of all relations at these elements.
type SamplePoint = (Vec<Assignment>, Solutions);

/// Upper bound of numerator and denominator of a rational number in a coefficient. The rational factors of coefficients are
/// halves, doubles and small numbers of links.
const MAX_RATIO: i64 = 64;

/// Number of curves of closed states through each closed point.
const CURVES_PER_POINT: usize = 3;
/// Number of closed points that are tried with given constants. The search ends at a point whose assembly of the loops gives
/// the regressor the independent columns that were chosen.
const TRIED_ASSEMBLIES: usize = 8;

/// Largest number of unknown coefficients of monomials in a fit. k angles with powers up to s have (2 s + 2)^k monomials. Each
/// monomial takes an evaluation of the columns and a row of a dense matrix: a fit with 256 monomials takes about ten
/// milliseconds, a fit with 4096 takes some minutes. Three angles at s = 2 (216) and four at s = 1 (256) are allowed; the loops
/// of the models that come with the project need at most 23.
const MAX_UNKNOWNS: usize = 256;
/// Largest number of unknowns of a fit for a robot with loops. The number is smaller than `MAX_UNKNOWNS`, because each point
/// must close the loops, which takes some milliseconds.
const MAX_UNKNOWNS_OF_LOOPS: usize = 40;
/// Largest power of a cosine in the monomials of a fit.
const MAX_MONOMIAL_SIZE: i32 = 3;
/// Number of points of a fit beyond the number of unknowns, so that a fit that is not exact fails.
const CHECK_POINTS: usize = 2;
/// Seed of the random field elements for the fits.
const FIELD_SEED: u64 = 1995;
/// Number of random states beyond the number of unknowns, when a relation is solved.
const EXTRA_STATES: usize = 3;
/// Number of orders of a power series along a curve beyond the number of unknowns.
const EXTRA_ORDERS: usize = 2;

/// Finds the coefficients x_k of each relation as functions of the robot's symbols. `None` if the relation does not hold for
/// every value of the symbols, if an x_k is no Laurent polynomial of small degree, or if there are too many unknowns.
///
/// With `closed`, the states close the loops; without it, all inputs of the regressor are free.
pub(crate) fn interpolate(
    regressor: &Function,
    relations: &[Relation],
    closed: Option<&ClosedPoints>,
) -> Vec<Option<Vec<Coefficient>>> {
    if relations.is_empty() {
        return Vec::new();
    }
    let (function, relations) = restricted(regressor, relations);
    let mut samples = FieldSamples::new(&function, &relations, closed);
    let reference = samples.draw(None);
    let solutions = samples.solve_at(&reference);
    if solutions.iter().all(Option::is_none) {
        return vec![None; relations.len()];
    }
    let depends = dependencies(&mut samples, &relations, &reference, &solutions);

    let mut points: Vec<SamplePoint> = vec![(reference, solutions)];
    let mut fitted = Vec::new();
    for (r, relation) in relations.iter().enumerate() {
        let coefficients = points[0].1[r].clone().and_then(|x| {
            // Every coefficient must be exact, so the first coefficient without a result ends the fit of the relation.
            let coefficient = |k: usize| {
                if depends[r][k].is_empty() {
                    // The coefficient depends on no symbol, so the coefficient is a number and needs no fit.
                    return x[k].as_ratio(MAX_RATIO).map(|(n, d)| Coefficient::ratio((n.into(), d.into())));
                }
                fit(&mut samples, &mut points, r, k, &depends[r][k], relation.degrees[k])
            };
            (0..relation.support.len()).map(coefficient).collect::<Option<Vec<_>>>()
        });
        fitted.push(coefficients);
    }
    fitted
}

/// The regressor restricted to the columns of the relations, and the relations with the new column numbers.
fn restricted(regressor: &Function, relations: &[Relation]) -> (Function, Vec<Relation>) {
    let named = |r: &Relation| r.support.iter().copied().chain([r.column]).collect::<Vec<_>>();
    let columns: BTreeSet<usize> = relations.iter().flat_map(named).collect();
    let columns: Vec<usize> = columns.into_iter().collect();
    let place = |c: usize| columns.binary_search(&c).unwrap_or_default();
    let moved = |r: &Relation| Relation {
        column: place(r.column),
        support: r.support.iter().map(|&c| place(c)).collect(),
        degrees: r.degrees.clone(),
    };
    (regressor.with_columns("related", 0, &columns), relations.iter().map(moved).collect())
}

/// For each relation and each of its coefficients x_k, the symbols on which x_k depends. To find these symbols, each symbol is
/// changed alone.
fn dependencies(
    samples: &mut FieldSamples,
    relations: &[Relation],
    reference: &[Assignment],
    solutions: &Solutions,
) -> Vec<Vec<Vec<usize>>> {
    let mut depends: Vec<Vec<Vec<usize>>> = relations.iter().map(|r| vec![Vec::new(); r.support.len()]).collect();
    if relations.iter().all(|r| r.support.is_empty()) {
        return depends;
    }
    let constants: Vec<usize> =
        (0..samples.n_symbols()).filter(|&s| samples.is_read[s] && samples.is_constant(s)).collect();
    for s in constants {
        let moved = samples.draw(Some((reference, s)));
        let changed = samples.solve_at(&moved);
        for (r, (old, new)) in solutions.iter().zip(&changed).enumerate() {
            if let (Some(old), Some(new)) = (old, new) {
                for k in (0..old.len()).filter(|&k| old[k] != new[k]) {
                    depends[r][k].push(s);
                }
            }
        }
    }
    depends
}

/// Fits coefficient x_k of relation r by a Laurent polynomial in `symbols` whose terms have the power `degree` of length. Larger
/// and larger sets of monomials are tried. `None` without an exact fit.
fn fit(
    samples: &mut FieldSamples,
    points: &mut Vec<SamplePoint>,
    r: usize,
    k: usize,
    symbols: &[usize],
    degree: i32,
) -> Option<Coefficient> {
    for size in 1..=MAX_MONOMIAL_SIZE {
        let most = if samples.closed.is_some() { MAX_UNKNOWNS_OF_LOOPS } else { MAX_UNKNOWNS };
        if n_monomials(samples, symbols, degree, size) > most {
            return None;
        }
        let monomials = monomials(samples, symbols, degree, size);
        if monomials.is_empty() {
            continue;
        }
        while points.len() < monomials.len() + CHECK_POINTS {
            let constants = samples.draw(None);
            let solutions = samples.solve_at(&constants);
            points.push((constants, solutions));
        }
        // At each point: sum_m a_m m(point) = x_k(point) in the field; m: monomials, a_m: unknown rational factors.
        let rows: Option<Vec<Vec<Residue>>> = points
            .iter()
            .map(|(constants, solutions)| {
                let mut row: Vec<Residue> = monomials.iter().map(|m| residue(m, constants)).collect();
                row.push(solutions[r].as_ref()?[k]);
                Some(row)
            })
            .collect();
        let Some(x) = solve(rows?, monomials.len()) else { continue };
        let mut sum = Coefficient::zero();
        // The factors are rational, so each field element is converted back to a ratio of small integers.
        for (monomial, x) in monomials.into_iter().zip(x) {
            let (n, d) = x.as_ratio(MAX_RATIO)?;
            sum = sum.plus(&Coefficient::product(monomial, (n.into(), d.into())));
        }
        return Some(sum);
    }
    None
}

/// All products of powers of the symbols in which the powers of lengths add up to `degree`. Each length has a power from -size to
/// size + 1, each cosine up to size, each sine up to one.
fn monomials(samples: &FieldSamples, symbols: &[usize], degree: i32, size: i32) -> Vec<Monomial> {
    let mut all: Vec<(Monomial, i32)> = vec![(Vec::new(), 0)];
    // Multiply every product so far by each power of the next symbol; `length` is the sum of the powers of lengths.
    for &s in symbols {
        let id = s as u32;
        let mut next = Vec::new();
        for (monomial, length) in &all {
            if samples.is_angle[s] {
                for sine in 0..=1 {
                    for cosine in 0..=size {
                        let mut m = monomial.clone();
                        m.extend([(Atom::Cos(id), cosine), (Atom::Sin(id), sine)].into_iter().filter(|f| f.1 != 0));
                        next.push((m, *length));
                    }
                }
            } else {
                for power in -size..=size + 1 {
                    let mut m = monomial.clone();
                    m.extend(Some((Atom::Length(id), power)).filter(|f| f.1 != 0));
                    next.push((m, length + power));
                }
            }
        }
        all = next;
    }
    all.retain(|m| m.1 == degree);
    all.into_iter()
        .map(|(mut monomial, _)| {
            monomial.sort();
            monomial
        })
        .collect()
}

/// The number of monomials that [`monomials`] would make, computed without making them.
fn n_monomials(samples: &FieldSamples, symbols: &[usize], degree: i32, size: i32) -> usize {
    let mut by_power = BTreeMap::from([(0, 1_usize)]);
    for &s in symbols {
        let mut next: BTreeMap<i32, usize> = BTreeMap::new();
        for (&power, &count) in &by_power {
            // Cosines and sines have no unit, so they do not change the sum of the powers of lengths.
            let (powers, times) =
                if samples.is_angle[s] { (0..=0, 2 * (size + 1) as usize) } else { (-size..=size + 1, 1) };
            for more in powers {
                let sum = next.entry(power + more).or_insert(0);
                *sum = sum.saturating_add(count.saturating_mul(times));
            }
        }
        by_power = next;
    }
    by_power.get(&degree).copied().unwrap_or(0)
}

/// Evaluates the columns of the relations in the finite field, at given constants and random states.
struct FieldSamples<'a> {
    function: &'a Function,
    relations: &'a [Relation],
    angles: GraphAngles,
    /// For each symbol: whether the symbol is the argument of a sine or cosine.
    is_angle: Vec<bool>,
    /// For each symbol: whether the function or the closure of the loops depends on the symbol.
    is_read: Vec<bool>,
    closed: Option<&'a ClosedPoints>,
    random: SplitMix,
}

impl<'a> FieldSamples<'a> {
    fn new(function: &'a Function, relations: &'a [Relation], closed: Option<&'a ClosedPoints>) -> Self {
        let graph = function.graph();
        let mut is_angle = vec![false; graph.symbols().len()];
        let mut is_read = is_angle.clone();
        // The symbols of the closure function are the first symbols of the regressor function.
        for graph in [Some(graph), closed.map(|closed| closed.closure.graph())].into_iter().flatten() {
            for node in graph.nodes() {
                if let expr::Node::Symbol(s) = node {
                    is_read[s.0 as usize] = true;
                }
                if let expr::Node::Sin(a) | expr::Node::Cos(a) = node
                    && let expr::Node::Symbol(s) = graph.node(*a)
                {
                    is_angle[s.0 as usize] = true;
                }
            }
        }
        FieldSamples {
            function,
            relations,
            angles: GraphAngles::of(graph),
            is_angle,
            is_read,
            closed,
            random: SplitMix(FIELD_SEED),
        }
    }

    fn n_symbols(&self) -> usize {
        self.function.graph().symbols().len()
    }

    fn is_constant(&self, s: usize) -> bool {
        matches!(self.function.graph().symbols()[s].1, SymbolKind::Constant(_))
    }

    /// Draws random field elements for all symbols. With `moved` = (reference, s), only symbol s is drawn; the other symbols
    /// keep their elements from `reference`.
    fn draw(&mut self, moved: Option<(&[Assignment], usize)>) -> Vec<Assignment> {
        match (moved, self.closed) {
            (None, Some(closed)) => closed.constants(&mut self.random).unwrap_or_default(),
            (None, None) => (0..self.n_symbols()).map(|_| Assignment::random(&mut self.random)).collect(),
            (Some((reference, s)), _) => {
                let mut assignments = reference.to_vec();
                assignments[s] = Assignment::random(&mut self.random);
                assignments
            }
        }
    }

    /// Solves each relation for its coefficients at these constants; `None` for a relation without a unique solution.
    fn solve_at(&mut self, constants: &[Assignment]) -> Solutions {
        let largest = self.relations.iter().map(|r| r.support.len()).max().unwrap_or(0);
        let rows = match self.closed {
            None => Some(self.free_rows(constants, largest)),
            Some(closed) => self.closed_rows(closed, constants, largest),
        };
        let Some(rows) = rows else { return vec![None; self.relations.len()] };
        let pick = |r: &Relation| {
            let picked =
                |row: &Vec<Residue>| -> Vec<Residue> { r.support.iter().chain([&r.column]).map(|&c| row[c]).collect() };
            solve(rows.iter().map(picked).collect(), r.support.len())
        };
        self.relations.iter().map(pick).collect()
    }

    /// Rows of the function at random states. There are more states than unknowns, so the additional rows check the solution.
    fn free_rows(&mut self, constants: &[Assignment], unknowns: usize) -> Vec<Vec<Residue>> {
        let output = &self.function.outputs[0];
        // In each state, a column may be non-zero in only one row, so each unknown needs a state.
        let n_states = unknowns + EXTRA_STATES;
        let mut rows = Vec::new();
        for _ in 0..n_states {
            let mut algebra = FieldAlgebra::new(self.function.graph(), &self.angles, constants, &mut self.random);
            let values = self.function.evaluate_in(&mut algebra).swap_remove(0);
            rows.extend(values.chunks(output.columns).map(<[Residue]>::to_vec).take(output.rows));
        }
        rows
    }

    /// Rows of the function along curves of closed states, as coefficients of power series. `None` if the loops do not close in
    /// the field, or if no tried assembly has the expected independent columns.
    fn closed_rows(
        &mut self,
        closed: &ClosedPoints,
        constants: &[Assignment],
        unknowns: usize,
    ) -> Option<Vec<Vec<Residue>>> {
        let is_related = |c: &usize| self.relations.iter().any(|r| r.column == *c);
        let kept: Vec<usize> = (0..self.function.outputs[0].columns).filter(|c| !is_related(c)).collect();
        let order = unknowns.max(kept.len() / CURVES_PER_POINT) + EXTRA_ORDERS;
        for _ in 0..TRIED_ASSEMBLIES {
            let point = closed.point_at(constants, &mut self.random)?;
            let (mut rows, mut echelon) = (Vec::new(), Echelon::default());
            for _ in 0..CURVES_PER_POINT {
                let Ok(along) = curve(closed, &point, order, &mut self.random) else { continue };
                let of_curve = regressor_rows(self.function, &self.angles, &point, along, order, &mut self.random);
                rows.extend(of_curve.unwrap_or_default().concat());
            }
            rows.iter().for_each(|row| {
                echelon.add(row.clone());
            });
            // Other assemblies of the loops may have other independent columns; their rows are not used.
            if echelon.columns() == kept {
                return Some(rows);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use expr::{Graph, Output};

    use super::*;

    /// Checks that `n_monomials`, which bounds the work, equals the number of monomials that are made.
    #[test]
    fn monomials_are_counted_before_they_are_made() {
        let mut g = Graph::new();
        let symbols: Vec<_> =
            (0..4).map(|k| g.symbol(&format!("x{k}"), SymbolKind::Constant(0.1 + f64::from(k)))).collect();
        let (cos, product) = (g.cos(symbols[0]), g.mul(symbols[1], symbols[2]));
        let product = g.mul(product, cos);
        let sine = g.sin(symbols[3]);
        let entry = g.add(product, sine);
        let output = Output { name: "y".into(), rows: 1, columns: 1, entries: vec![entry] };
        let function = Function::new("f", &g, Vec::new(), vec![output]);
        let samples = FieldSamples::new(&function, &[], None);
        for size in 1..=3 {
            for degree in -2..=2 {
                for symbols in [&[0][..], &[1, 2], &[0, 1, 2, 3]] {
                    let made = monomials(&samples, symbols, degree, size).len();
                    assert_eq!(n_monomials(&samples, symbols, degree, size), made, "{symbols:?} {degree} {size}");
                }
            }
        }
    }
}
