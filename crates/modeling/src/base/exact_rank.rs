//! The rank without a tolerance: the regressor in a finite field, where a zero is a zero.
//!
//! Lengths are random elements, coordinates and angles random points of the circle. What is exact in
//! the robot stays exact: right angles are in the graph, multiples of pi/12 get their cosine and sine, gear ratios are the
//! numbers they are. A column that is independent there is independent for almost every robot of this
//! structure; the chance of an accident is below 1e-12 [Schwartz 1980].

use std::collections::BTreeMap;

use expr::{Function, Graph, SymbolKind};

use crate::base::angles::Angles;
use crate::base::field::{Assignment, Residue, twelfth_turn};
use crate::base::field_algebra::FieldAlgebra;
use random::SplitMix;

/// The columns that are independent of those before them, in their order.
pub(crate) fn independent_columns(regressor: &Function) -> Vec<usize> {
    let mut random = SplitMix(1979);
    let graph = regressor.graph();
    let constants = assigned(graph, &mut random);
    let angles = Angles::of(graph);

    let output = &regressor.outputs[0];
    let (n, p) = (output.rows, output.columns);
    if n == 0 || p == 0 {
        return Vec::new();
    }
    // A link's eleven columns may be non-zero in only one row of each state.
    let n_states = (p.div_ceil(n) + 2).max(14);
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

/// The elements that stand for the constants: random, but for the cosine and sine of multiples of pi/12.
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

/// Independent rows, each one at its first entry and zero before it.
#[derive(Default)]
pub(crate) struct Echelon {
    /// By the column of the first entry.
    rows: BTreeMap<usize, Vec<Residue>>,
}

impl Echelon {
    /// Whether the row is independent of those that were added before.
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

    /// The columns that are independent of those before them: where the rows begin.
    pub(crate) fn columns(&self) -> Vec<usize> {
        self.rows.keys().copied().collect()
    }
}
