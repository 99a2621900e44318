//! Computes curves of closed states through a closed point of a finite field, and the rows of the regressor along them.
//!
//! The coordinates move along a random line, q(t) = q_0 + q_1 t. The passive variables p follow order by order,
//!
//! ```text
//! J_p p_k = -e_k        e_k the coefficient of t^k in e with p known up to t^(k-1)
//! ```
//! e: closure error, J_p: its Jacobian by p. All rows of e must vanish, not only the rows from which p is solved. If another
//! row does not vanish, the loops do not move with these constants. dq and ddq are random and constant along the curve, because
//! they are free at every state. A relation between columns with constant coefficients holds at every state if and only if it
//! holds for each coefficient of the series. At a general point, if some orders bring no new row, no later order brings one
//! [Schwartz 1980].

use std::collections::BTreeMap;

use expr::{Function, Node, Symbol, SymbolKind};

use crate::base::angles::GraphAngles;
use crate::base::closed::closed_point::{ClosedPoint, ClosedPoints};
use crate::base::closed::reason::NoCertificate;
use crate::base::closed::series::{CurveInput, SeriesAlgebra, TaylorSeries};
use crate::base::field::{Residue, solve};
use random::SplitMix;

/// The variables along a random curve of closed states through the point, as series up to t^order. Fails if the loops do not move
/// at this point.
pub(crate) fn curve(
    points: &ClosedPoints,
    point: &ClosedPoint,
    order: usize,
    random: &mut SplitMix,
) -> Result<BTreeMap<Symbol, CurveInput>, NoCertificate> {
    let n = points.variables.n;
    let m = points.variables.len() - n;
    // The coordinates follow q(t) = q_0 + q_1 t with random q_1.
    let mut inputs = points.inputs(&point.state);
    for symbol in &points.symbols[..n] {
        if let Some(moving) = inputs.get_mut(symbol) {
            moving.value = TaylorSeries(vec![moving.value.at(0), Residue::random(random)]);
        }
    }
    let evaluated = |inputs: &BTreeMap<Symbol, CurveInput>, order: usize| {
        let graph = points.closure.graph();
        let mut algebra = SeriesAlgebra::new(graph, &points.closure_angles, &point.constants, inputs, order);
        let values = points.closure.evaluate_in(&mut algebra);
        if algebra.broken { Err(NoCertificate::Singular) } else { Ok(values) }
    };
    // Take m independent rows of the Jacobian J_p at the point and invert them once (m: number of passive variables). The
    // inverse is used for every order.
    let j: Vec<Vec<Residue>> =
        evaluated(&inputs, 0)?[1].chunks(m.max(1)).map(|row| row.iter().map(|x| x.at(0)).collect()).collect();
    let (rows, inverse) = independent(&j, m).ok_or(NoCertificate::Singular)?;
    // Solve J_p p_k = -e_k for the coefficients p_k of the passive variables, order by order.
    for k in 1..=order {
        let e = evaluated(&inputs, k)?.swap_remove(0);
        for (p, weights) in inverse.iter().enumerate() {
            let step = rows.iter().zip(weights).fold(Residue::ZERO, |sum, (&r, &w)| sum + w * e[r].at(k));
            if let Some(moving) = inputs.get_mut(&points.symbols[n + p]) {
                moving.value.0.resize(k, Residue::ZERO);
                moving.value.0.push(-step);
            }
        }
    }
    // The rows of the closure error e that were not used must vanish too, otherwise the loop does not move.
    let moves = evaluated(&inputs, order)?[0].iter().all(|e| e.0.is_empty());
    if moves { Ok(inputs) } else { Err(NoCertificate::Overconstrained) }
}

/// The indices of m independent rows of the Jacobian `j`, and the inverse of the matrix of these rows; `None` if the rank of
/// `j` is below m.
fn independent(j: &[Vec<Residue>], m: usize) -> Option<(Vec<usize>, Vec<Vec<Residue>>)> {
    let mut rows: Vec<usize> = Vec::new();
    let mut echelon: Vec<(usize, Vec<Residue>)> = Vec::new();
    for (r, row) in j.iter().enumerate() {
        let mut row = row.clone();
        for (c, pivot) in &echelon {
            let factor = row[*c];
            row.iter_mut().zip(pivot).for_each(|(x, p)| *x = *x - factor * *p);
        }
        if let Some(c) = row.iter().position(|x| *x != Residue::ZERO) {
            let scale = row[c].inverse();
            echelon.push((c, row.iter().map(|x| *x * scale).collect()));
            rows.push(r);
        }
    }
    if rows.len() < m {
        return None;
    }
    // Column i of the inverse solves J x = unit vector i.
    let column = |i: usize| {
        let augmented = rows.iter().enumerate().map(|(k, &r)| {
            let unit = if k == i { Residue::ONE } else { Residue::ZERO };
            [j[r].as_slice(), &[unit]].concat()
        });
        solve(augmented.collect(), m)
    };
    let columns: Vec<Vec<Residue>> = (0..m).map(column).collect::<Option<_>>()?;
    let inverse = (0..m).map(|p| columns.iter().map(|c| c[p]).collect()).collect();
    Some((rows, inverse))
}

/// The rows of the regressor along the curve `along`, as coefficients of the powers of t: `[order][row][column]`.
pub(crate) fn regressor_rows(
    regressor: &Function,
    angles: &GraphAngles,
    point: &ClosedPoint,
    mut along: BTreeMap<Symbol, CurveInput>,
    order: usize,
    random: &mut SplitMix,
) -> Result<Vec<Vec<Vec<Residue>>>, NoCertificate> {
    let graph = regressor.graph();
    for node in graph.nodes() {
        if let Node::Symbol(s) = *node
            && graph.symbols()[s.0 as usize].1 == SymbolKind::Input
        {
            along.entry(s).or_insert_with(|| CurveInput::still(Residue::random(random)));
        }
    }
    let mut algebra = SeriesAlgebra::new(graph, angles, &point.constants, &along, order);
    let entries = regressor.evaluate_in(&mut algebra).swap_remove(0);
    if algebra.broken {
        return Err(NoCertificate::Singular);
    }
    let rows = entries.chunks(regressor.outputs[0].columns.max(1));
    Ok((0..=order).map(|k| rows.clone().map(|row| row.iter().map(|x| x.at(k)).collect()).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derivation::Derivation;

    /// A four-bar that can close because the offsets normal to its plane add up (0.05 = 0.03 + 0.02), and because its constant
    /// angles add up too.
    #[test]
    fn a_loop_closes_in_the_field_by_numbers_that_add_up() {
        let text = "convention: khalil-kleinfinger
name: test
gravity: [0, -9.81, 0]
symbols: {L0: 0.5, L1: 0.2, L2: 0.45, L3: 0.35}
coordinates: [q1]
links:
  - {link: 1, antecedent: base, theta: q1 + 0.3}
  - {link: 2, antecedent: 1, joint: revolute, drive: passive, start: 0.5, d: L1, r: 0.05}
  - {link: 3, antecedent: base, joint: revolute, drive: passive, start: 1.5, d: L0, r: 0.03}
loops:
  - cut: {antecedent: 2, joint: revolute, d: L2, start: 1}
    twin: {antecedent: 3, d: L3, r: 0.02, theta: 0.7}
";
        let robot = robot::format::read_yaml(text, "test.yaml").unwrap();
        let mut derivation = Derivation::new(&robot).unwrap();
        let closure = derivation.closure_function().unwrap();
        let points = ClosedPoints::new(&mut derivation, closure).unwrap();
        for seed in 0..4 {
            let random = &mut SplitMix(seed);
            let point = points.point(random, false).unwrap();
            let along = curve(&points, &point, 6, random).unwrap();
            // The passive variables move, in higher orders of t too.
            assert!(points.symbols[1..].iter().all(|s| along[s].value.at(6) != Residue::ZERO));
            // With the same constants there are other closed states.
            let other = points.point_at(&point.constants, random).unwrap();
            assert_ne!(other.state.points, point.state.points);
        }
    }
}
