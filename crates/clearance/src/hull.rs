//! The convex hull of points, given by its support function: the point that is farthest along a direction.
//!
//! Directions (1, u, v) are divided into square cells on the faces of a cube. A cell stores the points that can be farthest in
//! its directions. The height of a point is its dot product with the direction, which is linear in u and v. So if another point
//! is higher in all four corner directions of a cell, it is higher in the whole cell, and the lower point is dropped from this
//! cell. So the support function evaluates only the few points of one cell, with the same result as a search over all points. A
//! point that is dropped from a square is also dropped from its quarters. So the cells are computed from the whole face by
//! repeated division into quarters.

use robot::vector::{Vector3, dot};

/// Number of cells along the edge of a cube face, a power of two.
const CELLS_PER_EDGE: usize = 16;
/// A hull with at most this number of points is not divided into cells.
const FEW_POINTS: usize = 16;
/// A point is farther than another along a direction if its height (dot product with the direction) is larger by this share of
/// the size of the hull. Rounding errors are far smaller.
const FARTHER_SHARE: f64 = 1e-9;

/// The convex hull of at least one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    points: Vec<Vector3>,
    /// The points that can be farthest along a direction of a cell (candidates), cell after cell of all cube faces. Empty if the
    /// hull has few points.
    candidates: Vec<Vector3>,
    /// Index of the first candidate (point that can be farthest) of each cell. The last entry is the end of the last cell.
    starts: Vec<usize>,
}

/// A square block of cells of directions on one face of the cube.
#[derive(Clone, Copy)]
struct Square {
    face: usize,
    i: usize,
    j: usize,
    width: usize,
}

impl Square {
    /// The direction at the position (u, v) in the square, u and v from 0 to 1. The vector is not normalised.
    fn direction(&self, u: f64, v: f64) -> Vector3 {
        let at =
            |from: usize, share: f64| 2.0 * (from as f64 + share * self.width as f64) / CELLS_PER_EDGE as f64 - 1.0;
        let (axis, sign) = (self.face / 2, if self.face.is_multiple_of(2) { 1.0 } else { -1.0 });
        let mut along = [0.0; 3];
        (along[axis], along[(axis + 1) % 3], along[(axis + 2) % 3]) = (sign, at(self.i, u), at(self.j, v));
        along
    }

    fn quarters(&self) -> [Square; 4] {
        let width = self.width / 2;
        [(0, 0), (0, width), (width, 0), (width, width)].map(|(i, j)| Square {
            i: self.i + i,
            j: self.j + j,
            width,
            ..*self
        })
    }

    /// The points that can be farthest along a direction of the square. `farther`: smaller differences of their heights (dot
    /// products with the direction) are ignored.
    fn candidates(&self, points: &[Vector3], farther: f64) -> Vec<Vector3> {
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| self.direction(u, v));
        let middle = self.direction(0.5, 0.5);
        let best = corners.iter().chain([&middle]).filter_map(|along| farthest(points, *along));
        let best: Vec<[f64; 4]> = best.map(|k| corners.map(|along| dot(points[k], along))).collect();
        let is_beaten = |p: &&Vector3| {
            let heights = corners.map(|along| dot(**p, along));
            best.iter().any(|best| best.iter().zip(heights).all(|(best, height)| best - height > farther))
        };
        points.iter().filter(|p| !is_beaten(p)).copied().collect()
    }

    /// Computes the points that can be farthest along a direction of the square, and stores them in its cells. `farther`: as in
    /// [`Self::candidates`].
    fn fill(&self, points: &[Vector3], farther: f64, cells: &mut [Vec<Vector3>]) {
        let candidates = self.candidates(points, farther);
        match self.width {
            1 => cells[cell(self.face, self.i, self.j)] = candidates,
            _ => self.quarters().iter().for_each(|quarter| quarter.fill(&candidates, farther, cells)),
        }
    }
}

fn cell(face: usize, i: usize, j: usize) -> usize {
    (face * CELLS_PER_EDGE + i) * CELLS_PER_EDGE + j
}

impl Hull {
    /// The convex hull of these points. For each cell of directions, it stores the points that can be farthest.
    pub fn new(points: Vec<Vector3>) -> Hull {
        let mut hull = Hull { points, candidates: Vec::new(), starts: Vec::new() };
        if hull.points.len() > FEW_POINTS {
            let size = hull.points.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
            let mut cells = vec![Vec::new(); 6 * CELLS_PER_EDGE * CELLS_PER_EDGE];
            let faces = (0..6).map(|face| Square { face, i: 0, j: 0, width: CELLS_PER_EDGE });
            faces.for_each(|square| square.fill(&hull.points, FARTHER_SHARE * size, &mut cells));
            hull.starts.push(0);
            for cell in cells {
                hull.candidates.extend(cell);
                hull.starts.push(hull.candidates.len());
            }
        }
        hull
    }

    /// The points that define the hull.
    pub fn points(&self) -> &[Vector3] {
        &self.points
    }

    /// The point of the hull that is farthest along a direction; if several points are equally far, the first of them.
    pub(crate) fn support(&self, along: Vector3) -> Vector3 {
        let size = along.map(f64::abs);
        let axis = if size[0] >= size[1] && size[0] >= size[2] { 0 } else { 1 + usize::from(size[2] > size[1]) };
        let most = size[axis];
        let has_cell = !self.candidates.is_empty() && most > 0.0;
        let candidates = if has_cell {
            let place = |x: f64| ((0.5 * (x / most + 1.0) * CELLS_PER_EDGE as f64) as usize).min(CELLS_PER_EDGE - 1);
            let face = 2 * axis + usize::from(along[axis] < 0.0);
            let cell = cell(face, place(along[(axis + 1) % 3]), place(along[(axis + 2) % 3]));
            &self.candidates[self.starts[cell]..self.starts[cell + 1]]
        } else {
            &self.points
        };
        farthest(candidates, along).map_or([0.0; 3], |k| candidates[k])
    }
}

/// Index of the point that is farthest along a direction; if several are equally far, the first. `None` if there are no points.
pub(crate) fn farthest(points: &[Vector3], along: Vector3) -> Option<usize> {
    let mut best = (f64::NEG_INFINITY, None);
    for (k, p) in points.iter().enumerate() {
        let height = dot(*p, along);
        if height > best.0 {
            best = (height, Some(k));
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_farthest_point() {
        let wave = |k: u32, m: f64| (m * f64::from(k)).sin();
        for (count, flat) in [(20_u32, 1.0), (400, 1.0), (400, 0.0), (300, 1e-6)] {
            let points: Vec<Vector3> =
                (0..count).map(|k| [wave(k, 1.3), 0.4 * wave(k, 2.7) + 0.2, flat * wave(k, 0.7)]).collect();
            let hull = Hull::new(points.clone());
            let cells = 6 * CELLS_PER_EDGE * CELLS_PER_EDGE;
            // Even for a flat hull, a cell contains less than half of the points on average.
            assert!(hull.starts.len() == cells + 1 && hull.candidates.len() < cells * points.len() / 2, "{count}");
            let grid = |k: u32| f64::from(k % 9) / 4.0 - 1.0;
            let even = (0..729).map(|k| [grid(k), grid(k / 9), grid(k / 81)]);
            let odd = (0..3000).map(|k| [wave(k, 0.9), wave(k, 1.7), wave(k, 3.1)]);
            for along in even.chain(odd) {
                let all = farthest(&points, along).map_or([0.0; 3], |k| points[k]);
                assert_eq!(hull.support(along), all, "{along:?}");
            }
        }
        assert_eq!(Hull::new(vec![[1.0, 2.0, 3.0]]).support([0.0, 1.0, 0.0]), [1.0, 2.0, 3.0]);
    }
}
