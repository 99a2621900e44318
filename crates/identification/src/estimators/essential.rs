//! Essential parameters: the smallest set of parameters with nearly the same residual.
//!
//! Backward elimination [Pham, Gautier 1991] sets the parameter with the largest relative standard deviation to zero.
//! It continues while that deviation exceeds `ratio` times the smallest and the residual norm has grown by less than
//! `growth`. It needs the triangle only, not the data.

use numerics::least_squares::{Solution, solve};
use numerics::triangle::{Triangle, select};

/// The limits at which elimination stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elimination {
    /// Largest over smallest relative standard deviation that may remain.
    pub ratio: f64,
    /// Largest total relative growth of the residual norm.
    pub growth: f64,
}

impl Default for Elimination {
    fn default() -> Elimination {
        Elimination { ratio: 10.0, growth: 0.02 }
    }
}

/// The parameters kept and their solution.
#[derive(Clone, Debug)]
pub struct Essential {
    /// Columns kept, in order.
    pub kept: Vec<usize>,
    /// Dropped columns, in the order of dropping.
    pub dropped: Vec<usize>,
    /// The solution, its parameters in the order of `kept`.
    pub solution: Solution,
    /// The values of all p parameters: zero where dropped.
    pub x: Vec<f64>,
    /// Residual norm over the residual norm with all parameters.
    pub growth: f64,
}

/// Eliminates from a (weighted) triangle.
pub fn essential(triangle: &Triangle, limits: Elimination) -> Essential {
    let p = triangle.columns();
    let mut kept: Vec<usize> = (0..p).collect();
    let mut dropped = Vec::new();
    let norm = |t: &Triangle, s: &Solution| t.squares(&s.x).1.sqrt();
    let mut solution = solve(triangle);
    let full = norm(triangle, &solution);
    let mut growth = 1.0;
    while kept.len() > 1 {
        // The parameter with the largest relative sigma is the candidate, unless that is within `ratio` of the smallest.
        let relative: Vec<f64> = (0..kept.len()).map(|c| relative_sigma(&solution, c)).collect();
        let smallest = relative.iter().copied().fold(f64::INFINITY, f64::min);
        let Some(worst) = (0..kept.len()).max_by(|&a, &b| relative[a].total_cmp(&relative[b])) else { break };
        if relative[worst] <= limits.ratio * smallest {
            break;
        }
        // Without it the residual norm may exceed the norm with all parameters by `growth`.
        let mut fewer = kept.clone();
        let candidate = fewer.remove(worst);
        let reduced = select(triangle, &fewer);
        let next = solve(&reduced);
        let grown = if full > 0.0 { norm(&reduced, &next) / full } else { 1.0 };
        if grown > 1.0 + limits.growth {
            break;
        }
        (kept, solution, growth) = (fewer, next, grown);
        dropped.push(candidate);
    }
    let mut x = vec![0.0; p];
    kept.iter().zip(&solution.x).for_each(|(&c, &v)| x[c] = v);
    Essential { kept, dropped, solution, x, growth }
}

/// sigma / |x| of parameter c; infinite where it is not determined.
fn relative_sigma(solution: &Solution, c: usize) -> f64 {
    if !solution.determined[c] || solution.x[c] == 0.0 {
        return f64::INFINITY;
    }
    (solution.variance * solution.inverse[(c, c)]).sqrt() / solution.x[c].abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::triangle::TriangleBuilder;
    use random::Random;

    #[test]
    fn parameters_that_are_zero_go() {
        let mut random = Random::new(4);
        let truth = [3.0, 0.0, -1.0, 0.0, 0.5];
        let mut rows = TriangleBuilder::new(5);
        for _ in 0..500 {
            let row: Vec<f64> = (0..5).map(|_| random.normal()).collect();
            let y: f64 = row.iter().zip(truth).map(|(a, b)| a * b).sum();
            rows.push(&row, y + 0.2 * random.normal());
        }
        let triangle = rows.finish();
        let found = essential(&triangle, Elimination::default());
        assert_eq!(found.kept, [0, 2, 4]);
        assert_eq!((found.x[1], found.x[3]), (0.0, 0.0));
        assert!(found.growth >= 1.0 && found.growth < 1.02, "{}", found.growth);
        assert_eq!(found.solution.rank, 3);
    }

    #[test]
    fn a_selection_is_the_smaller_problem() {
        let mut random = Random::new(9);
        let (mut a, mut b) = (TriangleBuilder::new(3), TriangleBuilder::new(2));
        for _ in 0..100 {
            let row = [random.normal(), random.normal(), random.normal()];
            let y = random.normal();
            a.push(&row, y);
            b.push(&[row[2], row[0]], y);
        }
        let (whole, part) = (a.finish(), b.finish());
        let (x, y) = (solve(&select(&whole, &[2, 0])), solve(&part));
        for c in 0..2 {
            assert!((x.x[c] - y.x[c]).abs() < 1e-13);
        }
        assert!((x.variance - y.variance).abs() < 1e-12);
    }
}
