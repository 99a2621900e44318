//! Determines the type of linkage of a loop with four sides and equal opposite sides.
//!
//! Such a loop can be assembled in two ways: as a parallelogram, v_1 = -v_3, or crossed, as an antiparallelogram. v_i: vector of
//! side i. The two assemblies coincide only if all sides lie along one line. The assembly of the robot is the closed loop that is
//! nearest to the start values of the passive joints. It is found by
//!
//! ```text
//! x <- x - J^+ e        [Gauss-Newton, halved while |e| grows]
//! ```
//! x: the passive variables, e: the gap of the polygon ([`crate::polygon`]) with all coordinates at zero, J: Jacobian of e with
//! respect to x, J^+: its pseudo-inverse.

use crate::linear_angle::wrapped;
use crate::polygon::{Polygon, Side};

/// The type of linkage of a loop with four sides, at the closed loop that is nearest to the start values of the passive joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Linkage {
    /// Opposite sides stay parallel.
    Parallelogram,
    /// The sides form an antiparallelogram: the passive joints are no affine function of the coordinates.
    Crossed,
    /// All sides lie along one line, so both types coincide.
    Stretched,
    /// The type is unknown: no closed loop was found, or the file gives no start values and the loop is open with all passive
    /// variables at zero.
    NoStart,
}

/// A loop counts as closed if its gap is at most this value. Lengths are relative to the longest side, angles in rad. Start
/// values in a file have six digits.
const CLOSED_GAP: f64 = 1e-5;
/// Opposite sides count as parallel and equal if the difference of their vectors is at most this value, relative to the longest
/// side.
const PARALLEL_SIDES_GAP: f64 = 10.0 * CLOSED_GAP;
/// The search ends if the gap is below this value. Lengths are relative to the longest side, angles in rad.
const SEARCH_END_GAP: f64 = 1e-14;
/// Largest number of steps of the search. Near a solution, a few steps are enough for two or three unknowns.
const MAX_SEARCH_STEPS: usize = 60;
/// Step lengths are halved down to this fraction of the Gauss-Newton step, and not further.
const SMALLEST_STEP_FRACTION: f64 = 1e-3;

/// The type of linkage of four `groups` of sides of a polygon, in the order of the loop. `start`: a value for every variable:
/// zero for the `n` coordinates, then the start values of the passive variables.
pub(crate) fn linkage(polygon: &Polygon, groups: [&[usize]; 4], start: &[f64], n: usize) -> Linkage {
    let size = polygon.sides.iter().map(|s| s.vector[0].hypot(s.vector[1])).fold(0.0, f64::max);
    let search = PolygonSearch { polygon, size, unknown: unknown(polygon, n) };
    let is_given = search.unknown.iter().any(|&k| start[k] != 0.0);
    let mut x = start.to_vec();
    if !is_given && norm(&search.gap(&x)) > CLOSED_GAP {
        return Linkage::NoStart;
    }
    search.close(&mut x);
    // The vectors of the four sides at the closed loop, divided by the longest side.
    let [a, b, c, d] = groups.map(|sides| {
        sides.iter().fold([0.0, 0.0], |sum, &k| {
            let [u, v] = turned(&polygon.sides[k], &x);
            [sum[0] + u / size, sum[1] + v / size]
        })
    });
    if norm(&search.gap(&x)) > CLOSED_GAP {
        return Linkage::NoStart;
    }
    // |a x b| = 0 means that all sides lie along one line. a = -c and b = -d means that the sides form a parallelogram.
    if (a[0] * b[1] - a[1] * b[0]).abs() < CLOSED_GAP {
        return Linkage::Stretched;
    }
    let apart = [a[0] + c[0], a[1] + c[1], b[0] + d[0], b[1] + d[1]];
    if norm(&apart) < PARALLEL_SIDES_GAP { Linkage::Parallelogram } else { Linkage::Crossed }
}

/// Indices of the passive variables that rotate a side of the polygon or its end; the search changes only these.
fn unknown(polygon: &Polygon, n: usize) -> Vec<usize> {
    let moves = |k: &usize| polygon.turn[*k] != 0.0 || polygon.sides.iter().any(|s| s.turn[*k] != 0.0);
    (n..polygon.turn.len()).filter(moves).collect()
}

struct PolygonSearch<'a> {
    polygon: &'a Polygon,
    size: f64,
    unknown: Vec<usize>,
}

impl PolygonSearch<'_> {
    /// The gap of the polygon: its x and y components divided by the longest side, and the angle between its two ends, rad.
    fn gap(&self, x: &[f64]) -> [f64; 3] {
        let angle = wrapped(dot(&self.polygon.turn, x) - self.polygon.angle);
        self.polygon.sides.iter().fold([0.0, 0.0, angle], |gap, side| {
            let [u, v] = turned(side, x);
            [gap[0] + u / self.size, gap[1] + v / self.size, angle]
        })
    }

    /// Column k of the Jacobian: de/dx_k.
    fn column(&self, x: &[f64], k: usize) -> [f64; 3] {
        self.polygon.sides.iter().fold([0.0, 0.0, self.polygon.turn[k]], |sum, side| {
            let [u, v] = turned(side, x);
            let rate = side.turn[k] / self.size;
            [sum[0] - rate * v, sum[1] + rate * u, sum[2]]
        })
    }

    /// Moves the passive variables to the nearest closed polygon by Gauss-Newton steps.
    fn close(&self, x: &mut Vec<f64>) {
        for _ in 0..MAX_SEARCH_STEPS {
            let gap = self.gap(x);
            if norm(&gap) < SEARCH_END_GAP {
                return;
            }
            let columns: Vec<[f64; 3]> = self.unknown.iter().map(|&k| self.column(x, k)).collect();
            let step = least_step(&columns, gap);
            let mut fraction = 1.0;
            loop {
                let mut next = x.clone();
                for (&k, s) in self.unknown.iter().zip(&step) {
                    next[k] -= fraction * s;
                }
                if norm(&self.gap(&next)) < norm(&gap) || fraction < SMALLEST_STEP_FRACTION {
                    *x = next;
                    break;
                }
                fraction *= 0.5;
            }
        }
    }
}

/// The solution x of J x = e with the smallest norm: J' (J J' + mu 1)^-1 e. If the loop is singular, the small mu keeps the
/// matrix regular. Otherwise mu has no visible effect.
fn least_step(columns: &[[f64; 3]], e: [f64; 3]) -> Vec<f64> {
    const MU: f64 = 1e-12;
    let mut a = [[0.0; 4]; 3];
    for i in 0..3 {
        for j in 0..3 {
            a[i][j] = columns.iter().map(|c| c[i] * c[j]).sum::<f64>() + if i == j { MU } else { 0.0 };
        }
        a[i][3] = e[i];
    }
    // The matrix is positive definite, so no pivoting is needed.
    for k in 0..3 {
        for i in k + 1..3 {
            let factor = a[i][k] / a[k][k];
            for j in k..4 {
                a[i][j] -= factor * a[k][j];
            }
        }
    }
    let mut y = [0.0; 3];
    for k in (0..3).rev() {
        y[k] = (a[k][3] - (k + 1..3).map(|j| a[k][j] * y[j]).sum::<f64>()) / a[k][k];
    }
    columns.iter().map(|c| dot(c, &y)).collect()
}

/// The vector of a side for the values x of the variables.
fn turned(side: &Side, x: &[f64]) -> [f64; 2] {
    let (s, c) = dot(&side.turn, x).sin_cos();
    let [u, v] = side.vector;
    [c * u - s * v, s * u + c * v]
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polygon with sides 0.2, 0.5, 0.2, 0.5 (crank, coupler, rocker, base) and the crank at the angle `crank` to the base.
    /// Variables: q, the angle from crank to coupler, the angle from base to rocker, and the angle of the cut.
    fn four_bar(crank: f64) -> Polygon {
        let (s, c) = crank.sin_cos();
        let side = |vector: [f64; 2], turn: [f64; 4]| Side { vector, turn: turn.to_vec() };
        Polygon {
            sides: vec![
                side([0.2 * c, 0.2 * s], [1.0, 0.0, 0.0, 0.0]),
                side([0.5 * c, 0.5 * s], [1.0, 1.0, 0.0, 0.0]),
                side([-0.2, 0.0], [0.0, 0.0, 1.0, 0.0]),
                side([-0.5, 0.0], [0.0, 0.0, 0.0, 0.0]),
            ],
            turn: vec![1.0, 1.0, -1.0, 1.0],
            angle: -crank,
        }
    }

    fn at(crank: f64, start: [f64; 3]) -> Linkage {
        linkage(&four_bar(crank), [&[0], &[1], &[2], &[3]], &[0.0, start[0], start[1], start[2]], 1)
    }

    #[test]
    fn the_linkage_next_to_the_start() {
        // If the crank is at 1 rad, the parallelogram has its coupler at -1 rad to the crank, and its rocker at 1 rad to the
        // base.
        assert_eq!(at(1.0, [-1.0, 1.0, -1.0]), Linkage::Parallelogram);
        assert_eq!(at(1.0, [-0.8, 0.9, -1.1]), Linkage::Parallelogram);
        // In the antiparallelogram, the angles of coupler and rocker are both -1.811163 rad.
        assert_eq!(at(1.0, [-1.811163, -1.811163, -1.0]), Linkage::Crossed);
        assert_eq!(at(1.0, [-1.6, -1.9, -0.9]), Linkage::Crossed);
    }

    #[test]
    fn without_a_start_or_along_one_line_nothing_is_chosen() {
        assert_eq!(at(1.0, [0.0; 3]), Linkage::NoStart);
        assert_eq!(at(0.0, [0.0; 3]), Linkage::Stretched);
    }
}
