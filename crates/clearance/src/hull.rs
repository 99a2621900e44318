//! The hull of points, by its support: the point that is farthest along a direction.
//!
//! Directions are divided into cells on the faces of a cube, each a square of (1, u, v). A point is kept in a cell unless another is
//! farther at all four corners: then it is farther in the whole cell, since heights are linear in u and v. So a support looks at
//! the few points of one cell, and finds what a look at all of them finds.

use robot::vector::{Vector3, dot};

/// Cells along the edge of a face.
const EDGE: usize = 8;
/// Hulls of so few points have no cells.
const FEW_POINTS: usize = 16;
/// A point is left out of a cell where another is farther by this share of the size of the hull: far more than rounding.
const FARTHER_SHARE: f64 = 1e-9;

/// The hull of one point at least.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    points: Vec<Vector3>,
    /// By face and cell: the points that may be farthest, in their order. Empty where there are few points.
    cells: Vec<Vec<u32>>,
}

/// A direction of a face, in the square from -1 to 1.
fn on_face(face: usize, u: f64, v: f64) -> Vector3 {
    let (axis, sign) = (face / 2, if face.is_multiple_of(2) { 1.0 } else { -1.0 });
    let mut along = [0.0; 3];
    (along[axis], along[(axis + 1) % 3], along[(axis + 2) % 3]) = (sign, u, v);
    along
}

impl Hull {
    /// The hull of these points.
    pub fn new(points: Vec<Vector3>) -> Hull {
        let size = points.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        let at = |i: usize| 2.0 * i as f64 / EDGE as f64 - 1.0;
        let cell = |(face, i, j): (usize, usize, usize)| -> Vec<u32> {
            let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| on_face(face, at(i), at(j)));
            let middle = on_face(face, 0.5 * (at(i) + at(i + 1)), 0.5 * (at(j) + at(j + 1)));
            let best: Vec<usize> =
                corners.iter().chain([&middle]).filter_map(|along| farthest(&points, *along)).collect();
            let is_beaten = |p: &Vector3| {
                best.iter().any(|&q| {
                    let beats = |along: &Vector3| dot(points[q], *along) - dot(*p, *along) > FARTHER_SHARE * size;
                    corners.iter().all(beats)
                })
            };
            (0_u32..).zip(&points).filter(|(_, p)| !is_beaten(p)).map(|(k, _)| k).collect()
        };
        let places = (0..6).flat_map(|face| (0..EDGE).flat_map(move |i| (0..EDGE).map(move |j| (face, i, j))));
        let cells = if points.len() <= FEW_POINTS { vec![] } else { places.map(cell).collect() };
        Hull { points, cells }
    }

    /// The points.
    pub fn points(&self) -> &[Vector3] {
        &self.points
    }

    /// The point that is farthest along a direction, the first of equals.
    pub(crate) fn support(&self, along: Vector3) -> Vector3 {
        let size = along.map(f64::abs);
        let axis = if size[0] >= size[1] && size[0] >= size[2] { 0 } else { 1 + usize::from(size[2] > size[1]) };
        let most = size[axis];
        if self.cells.is_empty() || most.is_nan() || most <= 0.0 {
            return farthest(&self.points, along).map_or([0.0; 3], |k| self.points[k]);
        }
        let face = 2 * axis + usize::from(along[axis] < 0.0);
        let place = |x: f64| ((0.5 * (x / most + 1.0) * EDGE as f64) as usize).min(EDGE - 1);
        let cell = (face * EDGE + place(along[(axis + 1) % 3])) * EDGE + place(along[(axis + 2) % 3]);
        let mut best = (f64::NEG_INFINITY, [0.0; 3]);
        for &k in &self.cells[cell] {
            let point = self.points[k as usize];
            let height = dot(point, along);
            if height > best.0 {
                best = (height, point);
            }
        }
        best.1
    }
}

/// The point farthest along a direction, the first of equals.
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

    /// A support by cells is that of all points, along directions of every face, edge and corner.
    #[test]
    fn a_cell_has_the_farthest_point() {
        let wave = |k: u32, m: f64| (m * f64::from(k)).sin();
        for (count, flat) in [(20_u32, 1.0), (400, 1.0), (400, 0.0), (300, 1e-6)] {
            let points: Vec<Vector3> =
                (0..count).map(|k| [wave(k, 1.3), 0.4 * wave(k, 2.7) + 0.2, flat * wave(k, 0.7)]).collect();
            let hull = Hull::new(points.clone());
            assert!(hull.cells.iter().any(|cell| cell.len() < points.len()) && hull.cells.len() == 6 * EDGE * EDGE);
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
