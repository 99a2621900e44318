//! Cuts a bent or hollow mesh into pieces. Each piece is then replaced by its convex hull.
//!
//! A plane divides the triangles of the mesh into two halves. The hull of a half contains all of the solid on this side,
//! including the cut face, because the half contains the edges of this face. So the hulls of all pieces contain the solid for any
//! choice of cuts. A cut minimises the sum of the hull volumes of its halves. The piece with the largest saving of volume is cut
//! first, as long as the saving is large.
//!
//! Not here: the choice of the meshes to cut ([`crate::crowded`]).

use robot::vector::{Vector3, dot};

use crate::hull::farthest;
use crate::solid::directions;

/// The three corners of a triangle of a mesh, m.
pub(crate) type Triangle = [Vector3; 3];

/// Maximum number of pieces into which a mesh is cut.
const MAX_PIECES: usize = 4;
/// A cut must reduce the sum of the hull volumes by at least this share of the hull volume of the whole mesh.
const LEAST_SAVED_SHARE: f64 = 0.08;
/// If the vertices have more than this number of distinct coordinates along an axis, cuts are tried only at [`CUT_AT`].
const MAX_TRIED_PLACES: usize = 16;
/// Positions of the tried cuts for a mesh with many vertices, as shares of the extent along the axis.
const CUT_AT: [f64; 7] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875];
/// Maximum number of triangles with which cuts are compared, because a mesh may have millions of triangles.
const MAX_RANKING_TRIANGLES: usize = 4000;
/// The two halves of a cut: 1 for the half below the cutting plane, -1 for the half above it.
const SIDES: [f64; 2] = [1.0, -1.0];
/// Number of directions for the bounding planes of a hull when its volume is measured.
const DIRECTIONS_FOR_VOLUME: usize = 100;
/// Number of cells along each axis of the grid that measures a volume.
const GRID_CELLS: usize = 16;

/// The best cut of a piece. `saved`: reduction of the hull volume, m^3, estimated from some of the triangles.
struct Cut {
    saved: f64,
    halves: [Vec<Triangle>; 2],
}

/// Cuts a mesh into pieces. The result is the whole mesh as one piece if no cut reduces the volume of the hulls much.
pub(crate) fn pieces(mesh: Vec<Triangle>) -> Vec<Vec<Triangle>> {
    let whole = volume(&some_of(&mesh));
    let with_cut = |piece: Vec<Triangle>| {
        let cut = best_cut(&piece);
        (piece, cut)
    };
    let mut found = vec![with_cut(mesh)];
    while found.len() < MAX_PIECES {
        let saved = |k: usize| found[k].1.as_ref().map_or(0.0, |cut| cut.saved);
        let best = (0..found.len()).reduce(|a, b| if saved(b) > saved(a) { b } else { a });
        let Some(best) = best.filter(|&k| saved(k) > LEAST_SAVED_SHARE * whole) else { break };
        let (_, cut) = found.remove(best);
        found.extend(cut.into_iter().flat_map(|cut| cut.halves).map(with_cut));
    }
    found.into_iter().map(|(piece, _)| piece).collect()
}

/// The triangles with which cuts are compared: all triangles, or every n-th triangle of a large mesh.
fn some_of(piece: &[Triangle]) -> Vec<Triangle> {
    piece.iter().step_by(piece.len().div_ceil(MAX_RANKING_TRIANGLES).max(1)).copied().collect()
}

fn best_cut(piece: &[Triangle]) -> Option<Cut> {
    let some = some_of(piece);
    let volume_of_piece = volume(&some);
    let half = |of: &[Triangle], (axis, at): (usize, f64), side: f64| -> Vec<Triangle> {
        of.iter().flat_map(|t| clipped(t, axis, at, side)).collect()
    };
    let planes = (0..3).flat_map(|axis| places(&some, axis).into_iter().map(move |at| (axis, at)));
    let saved = |plane| volume_of_piece - SIDES.map(|side| volume(&half(&some, plane, side))).iter().sum::<f64>();
    let (saved, plane) = planes.map(|plane| (saved(plane), plane)).reduce(|a, b| if b.0 > a.0 { b } else { a })?;
    let halves = SIDES.map(|side| half(piece, plane, side));
    halves.iter().all(|half| !half.is_empty()).then_some(Cut { saved, halves })
}

/// Coordinates along an axis at which cuts are tried: the coordinates of all vertices, or a few evenly spaced positions if there
/// are many.
fn places(piece: &[Triangle], axis: usize) -> Vec<f64> {
    let mut along: Vec<f64> = piece.iter().flatten().map(|p| p[axis]).collect();
    along.sort_by(f64::total_cmp);
    along.dedup();
    match along[..] {
        [low, .., high] if along.len() > MAX_TRIED_PLACES => CUT_AT.map(|share| low + share * (high - low)).to_vec(),
        [_, ref inside @ .., _] => inside.to_vec(),
        _ => vec![],
    }
}

/// The region of a triangle on one side of a cutting plane: `side` times the coordinate is at most `side` times `at`. The region
/// is divided into triangles.
fn clipped(triangle: &Triangle, axis: usize, at: f64, side: f64) -> Vec<Triangle> {
    let beyond = |p: &Vector3| side * (p[axis] - at);
    // A face in the cutting plane is given to one half only. The other half gets the edges of this face from neighbouring faces.
    if side < 0.0 && triangle.iter().all(|p| beyond(p) == 0.0) {
        return vec![];
    }
    let mut corners = Vec::with_capacity(4);
    for k in 0..3 {
        let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
        let (a, b) = (beyond(&from), beyond(&to));
        if a <= 0.0 {
            corners.push(from);
        }
        if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
            // The rounding error is far below the allowance for rounding of positions.
            let share = a / (a - b);
            let mut on_plane = [0, 1, 2].map(|i| from[i] + share * (to[i] - from[i]));
            on_plane[axis] = at;
            corners.push(on_plane);
        }
    }
    corners.get(1..).map_or(vec![], |rest| rest.windows(2).map(|pair| [corners[0], pair[0], pair[1]]).collect())
}

/// Approximate volume of the convex hull of the triangles, m^3. It counts the grid cells whose centres are inside the bounding
/// planes of the hull in some directions.
fn volume(triangles: &[Triangle]) -> f64 {
    if triangles.is_empty() {
        return 0.0;
    }
    let points: Vec<Vector3> = triangles.iter().flatten().copied().collect();
    let end = |k: usize, pick: fn(f64, f64) -> f64, from: f64| points.iter().map(|p| p[k]).fold(from, pick);
    let low = [0, 1, 2].map(|k| end(k, f64::min, f64::INFINITY));
    let size = [0, 1, 2].map(|k| end(k, f64::max, f64::NEG_INFINITY) - low[k]);
    let outermost = |along: Vector3| Some((along, dot(points[farthest(&points, along)?], along)));
    let planes: Vec<(Vector3, f64)> = directions(DIRECTIONS_FOR_VOLUME).filter_map(outermost).collect();
    let centre = |cell: usize| {
        let place = [cell % GRID_CELLS, cell / GRID_CELLS % GRID_CELLS, cell / GRID_CELLS / GRID_CELLS];
        [0, 1, 2].map(|k| low[k] + size[k] * (place[k] as f64 + 0.5) / GRID_CELLS as f64)
    };
    let is_inside = |cell: &usize| planes.iter().all(|(along, height)| dot(centre(*cell), *along) <= *height);
    let cells = GRID_CELLS * GRID_CELLS * GRID_CELLS;
    size.iter().product::<f64>() * ((0..cells).filter(is_inside).count() as f64 / cells as f64)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::solid::Solid;
    use robot::vector::{cross, minus};

    /// The triangles of a cuboid with opposite corners `low` and `high`.
    fn cuboid(low: Vector3, high: Vector3) -> Vec<Triangle> {
        let corner = |k: usize| [0, 1, 2].map(|i| if k >> i & 1 == 1 { high[i] } else { low[i] });
        let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).map(|face| face.map(corner)).collect()
    }

    /// A U-shaped body: a plate with a post at each end.
    pub(crate) fn fork() -> Vec<Triangle> {
        let parts = [
            ([0.0, 0.0, 0.0], [0.5, 0.1, 0.06]),
            ([0.0, 0.0, 0.06], [0.06, 0.1, 0.3]),
            ([0.44, 0.0, 0.06], [0.5, 0.1, 0.3]),
        ];
        parts.into_iter().flat_map(|(low, high)| cuboid(low, high)).collect()
    }

    /// Whether a solid contains a point, with a tolerance of a micrometre.
    fn holds(solid: &Solid, point: Vector3) -> bool {
        directions(400).all(|along| dot(minus(point, solid.core.support(along)), along) <= solid.radius + 1e-6)
    }

    fn solids(pieces: &[Vec<Triangle>]) -> Vec<Solid> {
        pieces.iter().map(|piece| Solid::around(piece.as_flattened()).unwrap()).collect()
    }

    #[test]
    fn a_fork_is_cut_and_held_whole() {
        let found = solids(&pieces(fork()));
        assert_eq!(found.len(), 3);
        // Every point of the fork is inside a piece, also near the cuts.
        let grid = |k: usize, low: f64, high: f64| low + (high - low) * (k as f64 / 12.0);
        for (low, high) in [([0.0, 0.0, 0.0], [0.5, 0.1, 0.06]), ([0.44, 0.0, 0.06], [0.5, 0.1, 0.3])] {
            for k in 0..13 * 13 * 13 {
                let at = [k % 13, k / 13 % 13, k / 169];
                let point = [0, 1, 2].map(|i| grid(at[i], low[i], high[i]));
                assert!(found.iter().any(|solid| holds(solid, point)), "{point:?}");
            }
        }
        // The space between the posts is free after the cuts.
        assert!(!found.iter().any(|solid| holds(solid, [0.25, 0.05, 0.2])));
        assert!(holds(&Solid::around(fork().as_flattened()).unwrap(), [0.25, 0.05, 0.2]));
    }

    #[test]
    fn a_fine_mesh_is_ranked_by_some_of_its_triangles() {
        let quarters = |t: Triangle| {
            let middle = |a: usize, b: usize| [0, 1, 2].map(|i| 0.5 * (t[a][i] + t[b][i]));
            let (ab, bc, ca) = (middle(0, 1), middle(1, 2), middle(2, 0));
            [[t[0], ab, ca], [ab, t[1], bc], [ca, bc, t[2]], [ab, bc, ca]]
        };
        let fine = (0..6).fold(fork(), |mesh, _| mesh.into_iter().flat_map(quarters).collect());
        assert!(fine.len() > 10 * MAX_RANKING_TRIANGLES && some_of(&fine).len() <= MAX_RANKING_TRIANGLES);
        let found = solids(&pieces(fine.clone()));
        assert!(found.len() > 1 && !found.iter().any(|solid| holds(solid, [0.25, 0.05, 0.2])), "{}", found.len());
        let middles = fine.iter().step_by(97).map(|t| [0, 1, 2].map(|i| (t[0][i] + t[1][i] + t[2][i]) / 3.0));
        for point in middles {
            assert!(found.iter().any(|solid| holds(solid, point)), "{point:?}");
        }
    }

    #[test]
    fn what_is_convex_or_flat_stays_whole() {
        assert_eq!(pieces(cuboid([0.0; 3], [1.0, 0.2, 0.3])).len(), 1);
        assert_eq!(pieces(vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]).len(), 1);
        assert_eq!(pieces(vec![[[0.0; 3]; 3]]).len(), 1);
        assert_eq!(pieces(vec![]).len(), 1);
    }

    /// The volumes of a cuboid, and of the same cuboid without one corner. The corner has a sixth of the volume.
    #[test]
    fn volumes_are_known_roughly() {
        let whole = cuboid([1.0, 2.0, 3.0], [2.0, 4.0, 3.5]);
        assert!((volume(&whole) - 1.0).abs() < 1e-12);
        let is_corner = |p: &Vector3| *p == [2.0, 4.0, 3.5];
        let without: Vec<Triangle> = whole.into_iter().filter(|t| !t.iter().any(is_corner)).collect();
        // Allowed error: cells of width 1/16 count fully or not at all, and planes in a hundred directions do not bound the hull
        // exactly.
        assert!((volume(&without) - 5.0 / 6.0).abs() < 0.06, "{}", volume(&without));
        assert_eq!(volume(&[]), 0.0);
    }

    #[test]
    fn a_cut_loses_nothing() {
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.3, 0.0], [0.2, 0.9, 0.4]];
        let area = |t: &Triangle| {
            let n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
            0.5 * dot(n, n).sqrt()
        };
        for (axis, at) in [(0, 0.4), (1, 0.3), (2, 0.2), (0, 0.0), (0, 2.0), (0, 0.2)] {
            let halves = [1.0, -1.0].map(|side| clipped(&triangle, axis, at, side));
            let sum: f64 = halves.iter().flatten().map(area).sum();
            // Allowed error: a few roundings of lengths below 2 m.
            assert!((sum - area(&triangle)).abs() < 1e-15, "{axis} {at}");
            let [below, above] = halves.map(|half| half.as_flattened().to_vec());
            assert!(below.iter().all(|p| p[axis] <= at) && above.iter().all(|p| p[axis] >= at));
        }
    }
}
