//! Determines the independent columns of a regressor without a tolerance: the regressor is evaluated in a finite field, which
//! has no rounding.
//!
//! Lengths are random elements, coordinates and angles random points of the circle. Exact values of the robot stay exact: right
//! angles are in the graph, multiples of pi/12 get their cosine and sine, gear ratios keep their values. A column that is
//! independent in the field is independent for almost every robot of this structure; the probability of an error is below 1e-12
//! [Schwartz 1980].

use std::collections::BTreeMap;

use expr::{Function, Graph, SymbolKind};

use crate::base::angles::GraphAngles;
use crate::base::field::{Assignment, Residue, twelfth_turn};
use crate::base::field_algebra::FieldAlgebra;
use random::SplitMix;

/// Seed of the random field elements for the rank of a robot without passive joints.
const FIELD_SEED: u64 = 1979;
/// Number of random states beyond the number of states that would give as many rows as the regressor has columns.
const EXTRA_STATES: usize = 2;
/// Smallest number of random states. It exceeds eleven because each state may give only one non-zero row for the eleven columns
/// of a link.
const FEWEST_STATES: usize = 14;

/// The columns of the regressor that are independent of the columns before them, in ascending order; determined in a finite
/// field.
pub(crate) fn independent_columns(regressor: &Function) -> Vec<usize> {
    let mut random = SplitMix(FIELD_SEED);
    let graph = regressor.graph();
    let constants = assigned(graph, &mut random);
    let angles = GraphAngles::of(graph);

    let output = &regressor.outputs[0];
    let (n, p) = (output.rows, output.columns);
    if n == 0 || p == 0 {
        return Vec::new();
    }
    let n_states = (p.div_ceil(n) + EXTRA_STATES).max(FEWEST_STATES);
    let mut echelon = Echelon::default();
    for _ in 0..n_states {
        let mut algebra = FieldAlgebra::new(graph, &angles, &constants, &mut random);
        let values = regressor.evaluate_in(&mut algebra).swap_remove(0);
        for row in values.chunks(p) {
            echelon.add(row.to_vec());
        }
    }
    echelon.columns()
}

/// The field elements of all constants of a graph, by symbol: random, except the exact cosine and sine of multiples of pi/12.
pub(crate) fn assigned(graph: &Graph, random: &mut SplitMix) -> Vec<Assignment> {
    let assign = |(_, kind): &(String, SymbolKind)| {
        let mut assignment = Assignment::random(random);
        if let SymbolKind::Constant(x) = kind
            && let Some((cos, sin)) = twelfth_turn(*x)
        {
            (assignment.cos, assignment.sin) = (cos, sin);
        }
        assignment
    };
    graph.symbols().iter().map(assign).collect()
}

/// Independent rows over the finite field in echelon form: the first non-zero entry of each row is one.
#[derive(Default)]
pub(crate) struct Echelon {
    /// Column of the first non-zero entry of a row -> the row.
    rows: BTreeMap<usize, Vec<Residue>>,
}

impl Echelon {
    /// Adds a row. Returns whether the row is independent of the rows that were added before.
    pub(crate) fn add(&mut self, mut row: Vec<Residue>) -> bool {
        for c in 0..row.len() {
            if row[c] == Residue::ZERO {
                continue;
            }
            let Some(pivot) = self.rows.get(&c) else {
                let scale = row[c].inverse();
                row[c..].iter_mut().for_each(|x| *x = *x * scale);
                self.rows.insert(c, row);
                return true;
            };
            let factor = row[c];
            for (x, p) in row[c..].iter_mut().zip(&pivot[c..]) {
                if *p != Residue::ZERO {
                    *x = *x - factor * *p;
                }
            }
        }
        false
    }

    /// The columns that are independent of the columns before them, that is, the pivot columns of the rows.
    pub(crate) fn columns(&self) -> Vec<usize> {
        self.rows.keys().copied().collect()
    }
}
