//! Solves numerically for the passive coordinates of loops, if these coordinates are not affine functions of the other
//! coordinates.
//!
//! A loop is closed if its two cut frames C and T coincide. e holds the position of T in C, m, and the vector part of the
//! rotation between them. With J_p = de/dq_p, the iteration is
//!
//! ```text
//! q_p <- q_p - J_p^+ e        [Gauss-Newton, halved while |e| grows]
//! ```
//! until e is at the level of rounding errors. Near a singular configuration, J_p is almost rank-deficient. The ratio of its
//! smallest to its largest singular value measures how near the configuration is. Loops without common passive joints are
//! blocks of J_p, each with its own singular values.

use expr::{Function, Output, Tape, Workspace};
use nalgebra::{DMatrix, DVector};
use std::fmt;

use random::SplitMix;

/// A loop counts as closed if its closure error |e| (m and rad), divided by the largest entry of the Jacobian J_p of e by the
/// passive coordinates (at least 1), is at most this value.
const CLOSED_LOOP_ERROR: f64 = 1e-11;
/// A configuration counts as singular if the ratio of smallest to largest singular value of the Jacobian J_p (closure error by
/// passive coordinates) is below this value.
const SINGULAR_VALUE_RATIO: f64 = 1e-6;
/// Sampled configurations keep away from singular configurations: their ratio of smallest to largest singular value of the
/// Jacobian J_p (closure error by passive coordinates) is at least this value. The same holds for all configurations on a path
/// between samples.
const FAR_FROM_SINGULAR: f64 = 1e-2;
/// Largest number of Gauss-Newton steps of a search. Near the solution, each step doubles the number of correct digits. The
/// halved steps before that need fewer steps than this number.
const MAX_STEPS: usize = 60;
/// A Gauss-Newton step is halved until |e| decreases, but at most down to about this fraction. The smallest step is then taken in
/// any case, to escape from a minimum of |e| above zero.
const SMALLEST_FRACTION: f64 = 1e-3;
/// After the search, a loop also counts as closed if its closure error is at most this many times [`CLOSED_LOOP_ERROR`]. Rounding
/// may prevent a smaller closure error.
const ALMOST_CLOSED_RATIO: f64 = 100.0;
/// If the ratio of smallest to largest pivot of a block of the Jacobian J_p is above this value, the block is inverted by LU
/// instead of a pseudoinverse.
const INVERTIBLE_PIVOT_RATIO: f64 = 1e-2;
/// Largest number of sweeps of a singular value decomposition; about ten are usual.
const MAX_SVD_SWEEPS: usize = 200;
/// Largest step of a coordinate along a path within one assembly mode of the loops, rad or m. The step is small compared with
/// the distance between assembly modes, which meet only in singular configurations.
const LARGEST_STRIDE: f64 = 0.05;
/// Number of random configurations that are tried until the loops close at one of them. The search may fail for loops that
/// close at fewer than one in a thousand configurations.
const MAX_RANDOM_TRIES: usize = 2000;
/// Number of attempts of the search for a closed configuration after which the random coordinates cover a whole turn.
const ATTEMPTS_PER_TURN: usize = 100;
/// Seed of the random search for a closed configuration near q = 0.
const ORIGIN_SEED: u64 = 7;
/// Number of paths that are tried for each requested sample of closed configurations. Many paths end immediately, at the limit of
/// the assembly mode.
const PATHS_PER_SAMPLE: usize = 20;

/// Solves numerically for the passive coordinates of one robot with loops.
pub struct Closure {
    tape: Tape,
    work: Workspace,
    start: Vec<f64>,
    n_equations: usize,
    blocks: Vec<Block>,
    /// A closed configuration (q, q_p) of the assembly mode to which the search from the start leads; `None` until this
    /// configuration is computed.
    origin: Option<(Vec<f64>, Vec<f64>)>,
}

/// A diagonal block of the Jacobian J_p. It belongs to loops that are solved together, and consists of the indices of the
/// equations (rows) and of the passive coordinates (columns) of these loops.
struct Block {
    rows: Vec<usize>,
    columns: Vec<usize>,
}

impl Block {
    /// The diagonal blocks of the Jacobian J_p, found from its non-zero entries.
    fn all(jacobian: &Output) -> Vec<Block> {
        let m = jacobian.columns;
        let mut blocks: Vec<Block> = (0..m).map(|c| Block { rows: Vec::new(), columns: vec![c] }).collect();
        for row in 0..jacobian.rows {
            let meets = |c: usize| !jacobian.entries[row * m + c].is_zero();
            let (met, mut others): (Vec<Block>, Vec<Block>) =
                blocks.into_iter().partition(|b| b.columns.iter().any(|&c| meets(c)));
            let mut one = Block { rows: Vec::new(), columns: Vec::new() };
            for block in met {
                one.rows.extend(block.rows);
                one.columns.extend(block.columns);
            }
            if !one.columns.is_empty() {
                one.rows.push(row);
                others.push(one);
            }
            blocks = others;
        }
        for block in &mut blocks {
            block.rows.sort_unstable();
            block.columns.sort_unstable();
        }
        blocks.sort_by_key(|b| b.columns[0]);
        blocks
    }

    fn of(&self, j: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.rows.len(), self.columns.len(), |r, c| j[(self.rows[r], self.columns[c])])
    }
}

/// The reason why the passive coordinates were not found for given coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum NotClosed {
    /// The loops cannot be closed for these coordinates, or the search found no solution.
    NotClosed {
        /// Norm of the closure error e at the end of the search, m and rad.
        gap: f64,
    },
    /// The configuration is singular: the coordinates do not determine the passive coordinates.
    Singular {
        /// Smallest singular value of the Jacobian J_p, divided by the largest: zero in a singular configuration.
        ratio: f64,
    },
}

impl fmt::Display for NotClosed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotClosed::NotClosed { gap } => {
                write!(f, "the loops do not close at these coordinates: the gap is {gap:.1e} m (rad)")
            }
            NotClosed::Singular { ratio } => write!(
                f,
                "the configuration is singular: the coordinates do not determine the passive joints (ratio of \
                 singular values {ratio:.1e})"
            ),
        }
    }
}

impl std::error::Error for NotClosed {}

impl Closure {
    /// Makes the solver from the function of [`crate::Derivation::closure_function`]: inputs `q`, `passive`; outputs closure
    /// error `e` and its Jacobian `j`. `start`: passive coordinates from which searches start.
    pub(crate) fn new(function: &Function, start: Vec<f64>) -> Closure {
        let tape = Tape::new(function);
        let work = tape.workspace();
        let blocks = Block::all(&function.outputs[1]);
        Closure { work, start, n_equations: function.outputs[0].rows, blocks, tape, origin: None }
    }

    /// The passive coordinates at `q`, rad or m, searched from `guess`; `None`: from the start that the robot's file gives.
    pub fn solve(&mut self, q: &[f64], guess: Option<&[f64]>) -> Result<Vec<f64>, NotClosed> {
        self.solve_with_ratio(q, guess).map(|(passive, _)| passive)
    }

    /// The passive coordinates at `q`, and the ratio of smallest to largest singular value of the Jacobian J_p at this
    /// configuration.
    fn solve_with_ratio(&mut self, q: &[f64], guess: Option<&[f64]>) -> Result<(Vec<f64>, f64), NotClosed> {
        let mut passive = DVector::from_column_slice(guess.unwrap_or(&self.start));
        let (mut e, mut j) = self.at(q, &passive);
        for _ in 0..MAX_STEPS {
            // A closure error of NaN ends the search. Such an error counts as not closed below.
            if !is_finite(&e, &j) {
                break;
            }
            let is_closed = e.norm() <= CLOSED_LOOP_ERROR * size(&j);
            let Some(step) = self.step(&e, &j) else { break };
            let mut fraction = 1.0;
            loop {
                let next = &passive - fraction * &step;
                let (e_next, j_next) = self.at(q, &next);
                if e_next.norm() < e.norm() || fraction < SMALLEST_FRACTION {
                    (passive, e, j) = (next, e_next, j_next);
                    break;
                }
                if is_closed {
                    break;
                }
                fraction *= 0.5;
            }
            // After the loop counts as closed, one more step is made. This step squares the closure error, down to rounding.
            // Without the step, the error of the passive coordinates would exceed the closure error near singular
            // configurations.
            if is_closed {
                break;
            }
        }
        let gap = e.norm();
        // A closure error of NaN counts as not closed.
        if gap.is_nan() || gap > ALMOST_CLOSED_RATIO * CLOSED_LOOP_ERROR * size(&j) {
            return Err(NotClosed::NotClosed { gap });
        }
        let ratio = self.ratio(&e, &j);
        if ratio < SINGULAR_VALUE_RATIO {
            return Err(NotClosed::Singular { ratio });
        }
        Ok((passive.iter().copied().collect(), ratio))
    }

    /// The passive coordinates at `q`, rad or m, in the assembly mode to which the robot's start leads. The assembly mode is
    /// followed in small steps from a fixed origin, so that the result depends only on `q`.
    pub fn passive(&mut self, q: &[f64]) -> Result<Vec<f64>, NotClosed> {
        if self.origin.is_none() {
            self.origin = self.find_origin(q.len());
        }
        let Some(origin) = self.origin.clone() else { return Err(NotClosed::NotClosed { gap: f64::INFINITY }) };
        let reached = self.follow(&origin, q);
        // If the path ends before q, this last search fails and reports the reason.
        self.solve(q, Some(&reached.1))
    }

    /// The closure error e and its Jacobian J_p by the passive coordinates, at a configuration.
    pub(crate) fn at(&mut self, q: &[f64], passive: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let inputs = [q, passive.as_slice()].concat();
        let mut outputs = vec![0.0; self.tape.n_outputs()];
        self.tape.evaluate(&inputs, &mut self.work, &mut outputs);
        let (e, j) = outputs.split_at(self.n_equations);
        (DVector::from_column_slice(e), DMatrix::from_row_slice(self.n_equations, passive.len(), j))
    }

    /// Samples closed configurations (q, q_p) of one assembly mode. From the origin, q moves in small steps to random
    /// configurations. The path stays away from singular configurations, where assembly modes meet. Fewer than `count`
    /// configurations are found if the loops close at few configurations.
    pub(crate) fn sample(&mut self, n: usize, count: usize, random: &mut SplitMix) -> Vec<(Vec<f64>, Vec<f64>)> {
        let mut found: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        let Some(origin) = self.find_origin(n) else { return found };
        let mut at = origin.clone();
        for _ in 0..PATHS_PER_SAMPLE * count {
            if found.len() == count {
                break;
            }
            let goal: Vec<f64> = (0..n).map(|_| std::f64::consts::PI * random.unit()).collect();
            let reached = self.follow(&at, &goal);
            if reached.0 != at.0 {
                found.push(reached.clone());
                at = reached;
            } else {
                at = origin.clone();
            }
        }
        found
    }

    /// Finds a closed configuration (q, q_p) of the assembly mode to which the start leads. Every call gives the same
    /// configuration. It is at q = 0 if the loops close there and are not singular; otherwise it is at random coordinates near
    /// zero, with a fixed seed. `None` if no configuration was found.
    pub fn find_origin(&mut self, n: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let random = &mut SplitMix(ORIGIN_SEED);
        (0..MAX_RANDOM_TRIES).find_map(|attempt| {
            // The range of the random coordinates starts at zero, to which the start belongs, and grows with each attempt.
            let range = std::f64::consts::PI * (attempt as f64 / ATTEMPTS_PER_TURN as f64).min(1.0);
            let q: Vec<f64> = (0..n).map(|_| range * random.unit()).collect();
            let (passive, ratio) = self.solve_with_ratio(&q, None).ok()?;
            (ratio > FAR_FROM_SINGULAR).then_some((q, passive))
        })
    }

    /// The last configuration (q, q_p) on the straight path from `from` to `goal` up to which the loops close in one assembly
    /// mode.
    ///
    /// J_p is singular at configurations where assembly modes meet, and a step across one of them may end in another assembly
    /// mode. So a step is so short that the ratio of singular values, extrapolated from its last change, decreases by at most
    /// half.
    fn follow(&mut self, from: &(Vec<f64>, Vec<f64>), goal: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let length = from.0.iter().zip(goal).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let (mut at, mut done) = (from.clone(), 0.0);
        let (e, j) = self.at(&from.0, &DVector::from_column_slice(&from.1));
        let (mut ratio, mut slope) = (self.ratio(&e, &j), 1.0_f64);
        while done < length {
            let stride = LARGEST_STRIDE.min(0.5 * ratio / slope).min(length - done);
            let fraction = if stride < length - done { (done + stride) / length } else { 1.0 };
            let q: Vec<f64> = from.0.iter().zip(goal).map(|(a, b)| a + fraction * (b - a)).collect();
            let Ok((passive, next)) = self.solve_with_ratio(&q, Some(&at.1)) else { break };
            if next <= FAR_FROM_SINGULAR {
                break;
            }
            slope = ((next - ratio).abs() / stride).max(1.0);
            (at, ratio) = ((q, passive), next);
            done = if fraction < 1.0 { done + stride } else { length };
        }
        at
    }

    /// The Gauss-Newton step J_p^+ e of the passive coordinates, computed block by block; `None` if a decomposition fails.
    fn step(&self, e: &DVector<f64>, j: &DMatrix<f64>) -> Option<DVector<f64>> {
        let mut step = DVector::zeros(j.ncols());
        for block in self.blocks.iter().filter(|b| !b.rows.is_empty()) {
            let right = DVector::from_iterator(block.rows.len(), block.rows.iter().map(|&row| e[row]));
            let solved = solved(block.of(j), &right)?;
            for (x, &column) in solved.iter().zip(&block.columns) {
                step[column] = *x;
            }
        }
        Some(step)
    }

    /// Smallest singular value of the Jacobian J_p, divided by the largest: the minimum over its blocks. Zero if a number is not
    /// finite.
    fn ratio(&self, e: &DVector<f64>, j: &DMatrix<f64>) -> f64 {
        if !is_finite(e, j) {
            return 0.0;
        }
        let ratio = |block: &Block| {
            // With fewer equations than passive joints, some joints are not determined.
            if block.rows.len() < block.columns.len() {
                return None;
            }
            let values = block.of(j).try_svd(false, false, f64::EPSILON, MAX_SVD_SWEEPS)?.singular_values;
            Some(values.min() / values.max())
        };
        self.blocks.iter().map(|block| ratio(block).unwrap_or(0.0)).fold(1.0, f64::min)
    }
}

/// The product J^+ e with the pseudoinverse J^+ of a block; `None` if the decomposition fails.
fn solved(j: DMatrix<f64>, e: &DVector<f64>) -> Option<DVector<f64>> {
    if j.is_square() {
        let lu = j.clone().full_piv_lu();
        let pivots = lu.u().diagonal().abs();
        if pivots.min() > INVERTIBLE_PIVOT_RATIO * pivots.max() {
            return lu.solve(e);
        }
    }
    let svd = j.try_svd(true, true, f64::EPSILON, MAX_SVD_SWEEPS)?;
    svd.solve(e, SINGULAR_VALUE_RATIO * svd.singular_values.max()).ok()
}

fn is_finite(e: &DVector<f64>, j: &DMatrix<f64>) -> bool {
    e.iter().chain(j).all(|x| x.is_finite())
}

/// Divisor of a closure error before the error is compared with its bound: the largest magnitude of an entry of J_p, at least
/// 1.
fn size(j: &DMatrix<f64>) -> f64 {
    j.iter().fold(1.0, |largest, x| x.abs().max(largest))
}
