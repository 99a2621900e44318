//! The rank without a tolerance: the regressor in a finite field, where a zero is a zero.
//!
//! Lengths are random elements, coordinates and angles random points of the circle. What is exact in
//! the robot stays exact: right angles are in the graph, multiples of pi/12 get their cosine and sine, gear ratios are the
//! numbers they are. A column that is independent there is independent for almost every robot of this
//! structure; the chance of an accident is below 1e-12 [Schwartz 1980].

use expr::{Function, SymbolKind};

use crate::base::field::{Angles, Assignment, FieldAlgebra, Residue, twelfth_turn};
use crate::random::SplitMix;

/// The columns that are independent of those before them, in their order.
pub(crate) fn independent_columns(regressor: &Function) -> Vec<usize> {
    let mut random = SplitMix(1979);
    let graph = regressor.graph();
    let assign = |(_, kind): &(String, SymbolKind)| {
        let mut assignment = Assignment::random(&mut random);
        if let SymbolKind::Constant(x) = kind
            && let Some((cos, sin)) = twelfth_turn(*x)
        {
            (assignment.cos, assignment.sin) = (cos, sin);
        }
        assignment
    };
    let constants: Vec<Assignment> = graph.symbols().iter().map(assign).collect();
    let angles = Angles::of(graph);

    let output = &regressor.outputs[0];
    let (n, p) = (output.rows, output.columns);
    if n == 0 || p == 0 {
        return Vec::new();
    }
    // A link's eleven columns may be non-zero in only one row of each state.
    let n_states = (p.div_ceil(n) + 2).max(14);
    let mut rows: Vec<Vec<Residue>> = Vec::with_capacity(n_states * n);
    for _ in 0..n_states {
        let mut algebra = FieldAlgebra::new(graph, &angles, &constants, &mut random);
        let values = regressor.evaluate_in(&mut algebra).swap_remove(0);
        rows.extend(values.chunks(p).map(<[Residue]>::to_vec));
    }
    let mut kept = Vec::new();
    for c in 0..p {
        let Some(pivot) = rows.iter().position(|row| row[c] != Residue::ZERO) else { continue };
        let pivot = rows.swap_remove(pivot);
        let scale = pivot[c].inverse();
        for row in rows.iter_mut().filter(|row| row[c] != Residue::ZERO) {
            let factor = row[c] * scale;
            for k in c..p {
                if pivot[k] != Residue::ZERO {
                    row[k] = row[k] - factor * pivot[k];
                }
            }
        }
        kept.push(c);
    }
    kept
}
