//! Essential parameters: the smallest set of parameters with nearly the same residual.
//!
//! Backward elimination [Pham, Gautier 1991] sets the parameter with the largest relative standard deviation to zero.
//! Elimination continues while the largest relative standard deviation exceeds `ratio` times the smallest, and while the
//! residual norm has grown by less than `growth`. Only the triangle (R of QR) of the rows is needed, not the data.

use numerics::least_squares::{Solution, solve};
use numerics::triangle::{Triangle, select};

/// The limits at which elimination stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elimination {
    /// Elimination stops if the largest relative standard deviation is at most this factor times the smallest.
    pub ratio: f64,
    /// Largest relative growth of the residual norm in total: 0.02 is 2 %.
    pub growth: f64,
}

impl Default for Elimination {
    fn default() -> Elimination {
        Elimination { ratio: 10.0, growth: 0.02 }
    }
}

/// The essential parameters and their solution.
#[derive(Clone, Debug)]
pub struct Essential {
    /// The columns that are kept, ascending.
    pub kept: Vec<usize>,
    /// The eliminated columns, in the order of elimination.
    pub dropped: Vec<usize>,
    /// The solution with the kept parameters only, in the order of `kept`.
    pub solution: Solution,
    /// The values of all p parameters; zero for an eliminated parameter.
    pub x: Vec<f64>,
    /// Residual norm with the kept parameters, divided by the residual norm with all parameters; at least 1.
    pub growth: f64,
}

/// Finds the essential parameters from a triangle of weighted rows.
pub fn essential(triangle: &Triangle, limits: Elimination) -> Essential {
    let p = triangle.columns();
    let mut kept: Vec<usize> = (0..p).collect();
    let mut dropped = Vec::new();
    let norm = |t: &Triangle, s: &Solution| t.squares(&s.x).1.sqrt();
    let mut solution = solve(triangle);
    let full = norm(triangle, &solution);
    let mut growth = 1.0;
    while kept.len() > 1 {
        // The candidate is the parameter with the largest relative sigma, if this sigma exceeds `ratio` times the smallest
        // relative sigma.
        let relative: Vec<f64> = (0..kept.len()).map(|c| relative_sigma(&solution, c)).collect();
        let smallest = relative.iter().copied().fold(f64::INFINITY, f64::min);
        let Some(worst) = (0..kept.len()).max_by(|&a, &b| relative[a].total_cmp(&relative[b])) else { break };
        if relative[worst] <= limits.ratio * smallest {
            break;
        }
        // Without the candidate the residual norm must stay within 1 + `growth` of the norm with all parameters.
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

/// The relative standard deviation sigma / |x| of parameter c. Infinite if the parameter is not determined or zero.
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
