//! Coefficients of columns that no tree rule explains. They are solved for at random points of a finite
//! field, then interpolated in the robot's symbols.
//!
//! Loops of passive joints make columns depend on each other in ways no joint-by-joint rule sees.
//! Where the numbers say that a column is a combination of a few others, the combination is solved
//! exactly at random states and random symbols modulo a prime; then a Laurent polynomial in the
//! symbols that matter, of the right physical dimension, is fitted and checked at further points.
//! A fit that is not exact is no fit.

use expr::{Function, SymbolKind};

use crate::base::coefficient::{Atom, Coefficient, Monomial, residue};
use crate::base::field::{Assignment, FieldAlgebra, Residue, solve};
use crate::random::SplitMix;

/// One column to explain: `column` = sum_k x_k support_k, the x_k unknown.
pub(crate) struct Relation {
    pub column: usize,
    pub support: Vec<usize>,
    /// Power of a length of each x_k.
    pub degrees: Vec<i32>,
}

/// The x_k of each relation in the field; `None` where no x or more than one satisfies it.
type Solutions = Vec<Option<Vec<Residue>>>;

/// What the constants were, and the solutions there.
type Point = (Vec<Assignment>, Solutions);

/// Numerator and denominator of a rational in a coefficient are at most this: what lengths and angles
/// leave behind are halves, doubles and small counts of links.
const MAX_RATIO: i64 = 64;

/// The x_k of each relation; `None` when the relation does not hold for every value of the symbols,
/// or is no Laurent polynomial of small degree.
pub(crate) fn interpolate(function: &Function, relations: &[Relation]) -> Vec<Option<Vec<Coefficient>>> {
    let mut samples = FieldSamples::new(function, relations);
    let reference = samples.draw(None);
    let solutions = samples.solve_at(&reference);
    let depends = dependencies(&mut samples, relations, &reference, &solutions);

    let mut points: Vec<Point> = vec![(reference, solutions)];
    let mut fitted = Vec::new();
    for (r, relation) in relations.iter().enumerate() {
        let Some(x) = points[0].1[r].clone() else {
            fitted.push(None);
            continue;
        };
        let mut coefficients = Some(Vec::new());
        for k in 0..relation.support.len() {
            let coefficient = if depends[r][k].is_empty() {
                // A number needs no fit.
                x[k].as_ratio(MAX_RATIO).map(|(n, d)| Coefficient::ratio((n.into(), d.into())))
            } else {
                fit(&mut samples, &mut points, r, k, &depends[r][k], relation.degrees[k])
            };
            coefficients = coefficients.zip(coefficient).map(|(mut list, c)| {
                list.push(c);
                list
            });
        }
        fitted.push(coefficients);
    }
    fitted
}

/// Per relation and x_k, the symbols it depends on: one is moved at a time.
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
    let constants: Vec<usize> = (0..samples.n_symbols()).filter(|&s| samples.is_constant(s)).collect();
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

/// x_k of relation r as a polynomial in the symbols it depends on: monomials of growing size are tried.
fn fit(
    samples: &mut FieldSamples,
    points: &mut Vec<Point>,
    r: usize,
    k: usize,
    symbols: &[usize],
    degree: i32,
) -> Option<Coefficient> {
    for size in 1..=3 {
        let monomials = monomials(samples, symbols, degree, size);
        if monomials.is_empty() {
            continue;
        }
        // Two points more than unknowns: a fit that is not exact fails there.
        while points.len() < monomials.len() + 2 {
            let constants = samples.draw(None);
            let solutions = samples.solve_at(&constants);
            points.push((constants, solutions));
        }
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
        for (monomial, x) in monomials.into_iter().zip(x) {
            let (n, d) = x.as_ratio(MAX_RATIO)?;
            sum = sum.plus(&Coefficient::product(monomial, (n.into(), d.into())));
        }
        return Some(sum);
    }
    None
}

/// Products of powers of the symbols with the given total power of lengths: each length between
/// -size and size + 1, each cosine up to size, each sine up to one.
fn monomials(samples: &FieldSamples, symbols: &[usize], degree: i32, size: i32) -> Vec<Monomial> {
    let mut all: Vec<(Monomial, i32)> = vec![(Vec::new(), 0)];
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

/// The function in the field, at constants of choice and random states.
struct FieldSamples<'a> {
    function: &'a Function,
    relations: &'a [Relation],
    /// Whether the symbol is the argument of a sine or cosine.
    is_angle: Vec<bool>,
    random: SplitMix,
}

impl<'a> FieldSamples<'a> {
    fn new(function: &'a Function, relations: &'a [Relation]) -> Self {
        let graph = function.graph();
        let mut is_angle = vec![false; graph.symbols().len()];
        for node in graph.nodes() {
            if let expr::Node::Sin(a) | expr::Node::Cos(a) = node
                && let expr::Node::Symbol(s) = graph.node(*a)
            {
                is_angle[s.0 as usize] = true;
            }
        }
        FieldSamples { function, relations, is_angle, random: SplitMix(1995) }
    }

    fn n_symbols(&self) -> usize {
        self.function.graph().symbols().len()
    }

    fn is_constant(&self, s: usize) -> bool {
        matches!(self.function.graph().symbols()[s].1, SymbolKind::Constant(_))
    }

    /// Random assignments for all symbols, or for one of them with the others as in the reference.
    fn draw(&mut self, moved: Option<(&[Assignment], usize)>) -> Vec<Assignment> {
        match moved {
            None => (0..self.n_symbols()).map(|_| Assignment::random(&mut self.random)).collect(),
            Some((reference, s)) => {
                let mut assignments = reference.to_vec();
                assignments[s] = Assignment::random(&mut self.random);
                assignments
            }
        }
    }

    /// Solves every relation at these constants, over enough random states to leave rows over.
    fn solve_at(&mut self, constants: &[Assignment]) -> Solutions {
        let output = &self.function.outputs[0];
        let largest = self.relations.iter().map(|r| r.support.len()).max().unwrap_or(0);
        // A column may live in one row only.
        let n_states = largest + 3;
        let mut rows = Vec::new();
        for _ in 0..n_states {
            let mut algebra = FieldAlgebra::new(self.function.graph(), constants, &mut self.random);
            let values = self.function.evaluate_in(&mut algebra).swap_remove(0);
            rows.extend(values.chunks(output.columns).map(<[Residue]>::to_vec).take(output.rows));
        }
        let pick = |r: &Relation| {
            let picked =
                |row: &Vec<Residue>| -> Vec<Residue> { r.support.iter().chain([&r.column]).map(|&c| row[c]).collect() };
            solve(rows.iter().map(picked).collect(), r.support.len())
        };
        self.relations.iter().map(pick).collect()
    }
}
