//! Coefficients of columns that no tree rule explains: read off at random points of a finite field,
//! then interpolated in the robot's symbols.
//!
//! Loops of passive joints make columns depend on each other in ways no joint-by-joint rule sees.
//! Where the numbers say that a column is a combination of a few others, the combination is solved
//! exactly at random states and random symbols modulo a prime; then a Laurent polynomial in the
//! symbols that matter, of the right physical dimension, is fitted and checked at further points.
//! A fit that is not exact is no fit.

use expr::{Function, SymbolKind};

use crate::coefficient::{Atom, Coefficient, Monomial, residue};
use crate::field::{FieldAlgebra, Residue, SplitMix, Worth, solve};

/// One column to explain: `column` = sum_k x_k support_k.
pub(crate) struct Question {
    pub column: usize,
    pub support: Vec<usize>,
    /// Power of a length of each x_k.
    pub degrees: Vec<i32>,
}

/// The x_k of each question; `None` when the relation does not hold for every value of the symbols,
/// or is no Laurent polynomial of small degree.
pub(crate) fn interpolate(function: &Function, questions: &[Question]) -> Vec<Option<Vec<Coefficient>>> {
    let mut laboratory = Laboratory::new(function, questions);
    let constants: Vec<usize> = (0..laboratory.n_symbols()).filter(|&s| laboratory.is_constant(s)).collect();
    let reference = laboratory.draw(None);
    let answers = laboratory.ask(&reference);

    // Which symbols does each coefficient depend on? Move one at a time.
    let mut depends: Vec<Vec<Vec<usize>>> = questions.iter().map(|q| vec![Vec::new(); q.support.len()]).collect();
    if questions.iter().any(|q| !q.support.is_empty()) {
        for &s in &constants {
            let moved = laboratory.draw(Some((&reference, s)));
            let changed = laboratory.ask(&moved);
            for (q, (old, new)) in answers.iter().zip(&changed).enumerate() {
                if let (Some(old), Some(new)) = (old, new) {
                    for k in (0..old.len()).filter(|&k| old[k] != new[k]) {
                        depends[q][k].push(s);
                    }
                }
            }
        }
    }

    let mut points: Vec<(Vec<Worth>, Answers)> = vec![(reference, answers)];
    let mut fitted = Vec::new();
    for (q, question) in questions.iter().enumerate() {
        let mut coefficients = Some(Vec::new());
        for k in 0..question.support.len() {
            let fit = points[0].1[q].clone().and_then(|answer| {
                // A constant needs no fit; the other points confirm it below.
                if depends[q][k].is_empty() {
                    let (n, d) = answer[k].as_ratio(MAX_RATIO)?;
                    return Some(Coefficient::ratio((n.into(), d.into())));
                }
                fit(&mut laboratory, &mut points, q, k, &depends[q][k], question.degrees[k])
            });
            coefficients = coefficients.zip(fit).map(|(mut list, c)| {
                list.push(c);
                list
            });
        }
        let holds = points[0].1[q].is_some();
        fitted.push(coefficients.filter(|_| holds));
    }
    fitted
}

const MAX_RATIO: i64 = 64;

type Answers = Vec<Option<Vec<Residue>>>;

/// Tries monomials of growing size in the symbols that matter.
fn fit(
    laboratory: &mut Laboratory,
    points: &mut Vec<(Vec<Worth>, Answers)>,
    q: usize,
    k: usize,
    symbols: &[usize],
    degree: i32,
) -> Option<Coefficient> {
    for size in 1..=3 {
        let monomials = monomials(laboratory, symbols, degree, size);
        if monomials.is_empty() {
            continue;
        }
        // Two points more than unknowns: a fit that is not exact fails there.
        while points.len() < monomials.len() + 2 {
            let constants = laboratory.draw(None);
            let answers = laboratory.ask(&constants);
            points.push((constants, answers));
        }
        let rows: Option<Vec<Vec<Residue>>> = points
            .iter()
            .map(|(constants, answers)| {
                let mut row: Vec<Residue> = monomials.iter().map(|m| residue(m, constants)).collect();
                row.push(answers[q].as_ref()?[k]);
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
fn monomials(laboratory: &Laboratory, symbols: &[usize], degree: i32, size: i32) -> Vec<Monomial> {
    let mut all: Vec<(Monomial, i32)> = vec![(Vec::new(), 0)];
    for &s in symbols {
        let id = s as u32;
        let mut next = Vec::new();
        for (monomial, length) in &all {
            if laboratory.is_angle[s] {
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

/// The function, evaluated in the field wherever one likes.
struct Laboratory<'a> {
    function: &'a Function,
    questions: &'a [Question],
    /// Whether the symbol is the argument of a sine or cosine.
    is_angle: Vec<bool>,
    random: SplitMix,
}

impl<'a> Laboratory<'a> {
    fn new(function: &'a Function, questions: &'a [Question]) -> Self {
        let graph = function.graph();
        let mut is_angle = vec![false; graph.symbols().len()];
        for node in graph.nodes() {
            if let expr::Node::Sin(a) | expr::Node::Cos(a) = node
                && let expr::Node::Symbol(s) = graph.node(*a)
            {
                is_angle[s.0 as usize] = true;
            }
        }
        Laboratory { function, questions, is_angle, random: SplitMix(1995) }
    }

    fn n_symbols(&self) -> usize {
        self.function.graph().symbols().len()
    }

    fn is_constant(&self, s: usize) -> bool {
        matches!(self.function.graph().symbols()[s].1, SymbolKind::Constant(_))
    }

    /// Random worths for all symbols, or for one of them with the others as in the reference.
    fn draw(&mut self, moved: Option<(&[Worth], usize)>) -> Vec<Worth> {
        match moved {
            None => (0..self.n_symbols()).map(|_| Worth::random(&mut self.random)).collect(),
            Some((reference, s)) => {
                let mut worths = reference.to_vec();
                worths[s] = Worth::random(&mut self.random);
                worths
            }
        }
    }

    /// Solves every question at these constants, over enough random states to leave rows over.
    fn ask(&mut self, constants: &[Worth]) -> Answers {
        let output = &self.function.outputs[0];
        let largest = self.questions.iter().map(|q| q.support.len()).max().unwrap_or(0);
        // A column may live in one row only.
        let n_states = largest + 3;
        let mut rows = Vec::new();
        for _ in 0..n_states {
            let mut algebra = FieldAlgebra::new(self.function.graph(), constants, &mut self.random);
            let values = self.function.evaluate_in(&mut algebra).swap_remove(0);
            rows.extend(values.chunks(output.columns).map(<[Residue]>::to_vec).take(output.rows));
        }
        let pick = |q: &Question| {
            let picked =
                |row: &Vec<Residue>| -> Vec<Residue> { q.support.iter().chain([&q.column]).map(|&c| row[c]).collect() };
            solve(rows.iter().map(picked).collect(), q.support.len())
        };
        self.questions.iter().map(pick).collect()
    }
}
