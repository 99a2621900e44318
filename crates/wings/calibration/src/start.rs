//! Finds the frames and the zeros from which the fit starts, without a guess by the user.
//!
//! The unknown frames are the frame of the base and the frame of the tool. If the zeros are given, linear equations give both
//! frames.
//!
//! - Orientations: A = R_B C R_T for each posture. A: measured orientation; R_B, R_T: rotations of base and tool; C: rotation
//!   of the last link, from the joint positions. R_B and R_T are the null vector of A R_T' - R_B C = 0 [Shah 2013].
//! - Points: m = B C p for each posture. m: measured point; B, C: poses of the base and of the last link; p: the point in the
//!   last link. With R_C, p_C the rotation and position of C, the equation N m + u - R_C p = p_C is linear in N = R_B', u and
//!   p.
//!
//! If only some components of a point are measured, several orientations of the base are tried. If zeros are far off, several
//! random starts find the zeros; each start ends with damped Gauss-Newton steps.
//!
//! Zeros are the errors of joint positions. A residual is compared with the noise that the search assumes (`COARSE`).

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use random::Random;

use crate::chain::{Placed, turned_by};
use crate::fit::{Fitter, Noise};
use crate::measurement::{MeasurementKind, Posture, Problem, Unknowns};
use crate::parameter::{Parameter, ParameterGroup};

/// Largest number of postures of the search for a start.
const MAX_POSTURES: usize = 60;
/// Noise that the search assumes, m and rad. Errors of a description have this size.
const COARSE: Noise = Noise { length: 5e-3, angle: 5e-3 };
/// Number of steps of a search from one start.
const STEPS: usize = 25;
/// Number of random starts of the zeros, and of random orientations of the base.
pub(crate) const ZERO_STARTS: usize = 40;
const BASE_STARTS: usize = 40;
/// Random zeros are drawn from minus this value to plus this value, rad. Gauss-Newton steps from such a start also reach larger
/// zeros.
const ZERO_RANGE: f64 = 1.2;
/// If the residual per posture is below this multiple of [`COARSE`], no other zeros are tried.
const GOOD: f64 = 4.0;
/// Another start replaces the best start if its sum of squares is at most this fraction of the best sum.
const BETTER: f64 = 0.9;
/// Eigenvalues below this fraction of the largest one belong to the null space. Errors of some degrees in the description cause
/// eigenvalues of this size.
const NULL: f64 = 1e-3;
/// Number of vectors of a null space that are tried.
const NULL_STARTS: usize = 12;
/// Relative size of singular values that count as zero in a linear equation.
const SINGULAR: f64 = 1e-9;

/// The start with the smallest residual. `active`: the frames and zeros that are fitted; `starts`: largest number of random zeros
/// that are tried.
pub(crate) fn start(problem: &Problem, active: &[usize], starts: usize) -> Unknowns {
    // At most MAX_POSTURES postures, spread evenly over the table, are enough for a start and save time.
    let stride = problem.postures.len().div_ceil(MAX_POSTURES).max(1);
    let some = problem.with(problem.postures.iter().step_by(stride).cloned().collect());
    let rows: Vec<usize> = (0..some.postures.len()).collect();
    let of = |groups: &[ParameterGroup]| -> Vec<usize> {
        active.iter().copied().filter(|&k| groups.contains(&problem.parameters[k].group())).collect()
    };
    let (frames, zeros) = (of(&[ParameterGroup::Frames]), of(&[ParameterGroup::Frames, ParameterGroup::Zeros]));
    let fitter = |active| Fitter { problem: &some, active, prior: None, rows: &rows };
    // From given zeros: the frames first, then frames and zeros together. If there is no closed form of the frames, several
    // candidates are refined without zeros, and the best result counts.
    let from = |chain: Vec<f64>| {
        let each = candidates(&some, &chain);
        let several = each.len() > 1;
        let held = each.into_iter().map(|at| without_dropped(&some, &frames, at));
        let refined = held.map(|at| if several { fitter(&frames).search(&at, COARSE, STEPS).0 } else { at });
        let ended = refined.map(|at| fitter(&zeros).search(&at, COARSE, STEPS));
        ended.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let nothing = vec![0.0; problem.chain.parameters.len()];
    let Some(mut best) = from(nothing.clone()) else { return problem.nominal() };
    // The cost of a search is the sum over the postures of ln(1 + (e/2.5)^2), with e = residual / noise. The limit is this cost
    // for e = GOOD at every posture.
    let limit = rows.len() as f64 * (GOOD / 2.5_f64).powi(2).ln_1p();
    let mut random = Random::new(0x7a65_726f);
    for _ in 0..starts {
        if best.1 < limit {
            break;
        }
        let mut chain = nothing.clone();
        for k in 0..problem.chain.coordinates.len() {
            chain[k] = random.between(-ZERO_RANGE, ZERO_RANGE);
        }
        if let Some(found) = from(chain).filter(|found| found.1 < BETTER * best.1) {
            best = found;
        }
    }
    problem.chain.within_half_a_turn(&mut best.0.chain);
    best.0
}

/// Sets those coordinates of points to zero that are not fitted. Such a coordinate has the same effect as the position of the
/// base, so its value is arbitrary. But errors of angles are multiplied by this value, so every table must use the same value.
/// `frames`: the fitted unknowns of the measurement.
fn without_dropped(problem: &Problem, frames: &[usize], mut at: Unknowns) -> Unknowns {
    for (k, parameter) in problem.parameters.iter().enumerate() {
        if let (Parameter::Point { point, axis }, false) = (*parameter, frames.contains(&k)) {
            at.points[point][axis] = 0.0;
        }
    }
    at
}

/// Frames of base and tool for given parameters of the chain: one if there is a closed form, otherwise several that are tried.
fn candidates(problem: &Problem, chain: &[f64]) -> Vec<Unknowns> {
    let at = Unknowns { chain: chain.to_vec(), ..problem.nominal() };
    let links: Vec<Placed> = poses(problem, chain);
    match problem.kind {
        MeasurementKind::Pose => {
            let each = orientations(&problem.postures, &links).into_iter();
            each.map(|(base, tool)| with_base(problem, &links, Unknowns { tool, ..at.clone() }, base)).collect()
        }
        MeasurementKind::Points(_) => {
            let measured = |p: &Posture| p.points.iter().flatten().any(|x| *x != 0.0);
            if problem.postures.iter().any(measured)
                && let Some(base) = base_of_points(&problem.postures, &links)
            {
                return vec![with_base(problem, &links, at, base)];
            }
            // The orientation of the frame is determined if the tool touches a plane, but not if it touches a point.
            let is_whole = problem.postures.iter().all(|p| p.points.iter().flatten().all(|x| x.is_finite()));
            let count = if is_whole { 1 } else { BASE_STARTS };
            let mut random = Random::new(0x6261_7365);
            let mut turn = |k: usize| {
                let vector = Vector3::from_fn(|_, _| random.between(-1.0, 1.0) * std::f64::consts::PI);
                if k == 0 { Matrix3::identity() } else { turned_by(vector) }
            };
            (0..count).map(|k| with_base(problem, &links, at.clone(), turn(k))).collect()
        }
        MeasurementKind::Distance | MeasurementKind::Sphere => around(problem, &links, &at),
    }
}

fn poses(problem: &Problem, chain: &[f64]) -> Vec<Placed> {
    problem.postures.iter().map(|p| problem.chain.derivatives(&p.q, &p.torque, chain).pose).collect()
}

/// The rotation matrix nearest to a matrix.
pub(crate) fn nearest_rotation(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = matrix.svd(true, true);
    let (Some(u), Some(mut v)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    if (u * v).determinant() < 0.0 {
        let smallest = svd.singular_values.imin();
        v.row_mut(smallest).neg_mut();
    }
    u * v
}

/// Orientations of the base and of the tool from measured orientations. If all joints turn about parallel axes, the null space has
/// several dimensions, of which some vectors are rotations: then several are returned, to be tried.
fn orientations(postures: &[Posture], links: &[Placed]) -> Vec<(Matrix3<f64>, Matrix3<f64>)> {
    let mut normal = DMatrix::<f64>::zeros(18, 18);
    for (posture, link) in postures.iter().zip(links) {
        let Some(measured) = posture.rotation else { continue };
        // Entry (i, k) of A X - Y C with X = R_T' and Y = R_B; X_mk is unknown 3 m + k, Y_im is unknown 9 + 3 i + m.
        for (i, k) in (0..9).map(|e| (e / 3, e % 3)) {
            let mut row = DVector::<f64>::zeros(18);
            for m in 0..3 {
                row[3 * m + k] += measured[(i, m)];
                row[9 + 3 * i + m] -= link.rotation[(m, k)];
            }
            normal.ger(1.0, &row, &row, 1.0);
        }
    }
    let eigen = normal.symmetric_eigen();
    let mut order: Vec<usize> = (0..18).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let limit = NULL * eigen.eigenvalues.max();
    let null: Vec<usize> = order.iter().copied().filter(|&k| k == order[0] || eigen.eigenvalues[k] < limit).collect();
    let mut random = Random::new(0x6e75_6c6c);
    let count = if null.len() > 1 { NULL_STARTS } else { 1 };
    let vector = |k: usize| {
        let mut factor = || if k == 0 { 0.0 } else { random.normal() };
        let others: Vec<f64> = null[1..].iter().map(|_| factor()).collect();
        let first = eigen.eigenvectors.column(null[0]).into_owned();
        null[1..].iter().zip(others).fold(first, |sum, (c, x)| sum + x * eigen.eigenvectors.column(*c))
    };
    let rotations = |null: DVector<f64>| {
        let part = |first: usize| Matrix3::from_fn(|i, k| null[first + 3 * i + k]);
        let sign = part(9).determinant().signum();
        (nearest_rotation(&(sign * part(9))), nearest_rotation(&(sign * part(0))).transpose())
    };
    (0..count).map(vector).map(rotations).collect()
}

/// Orientation of the base from measured points; `None` if too few points are whole.
fn base_of_points(postures: &[Posture], links: &[Placed]) -> Option<Matrix3<f64>> {
    let count = postures.first()?.points.len();
    let unknowns = 12 + 3 * count;
    let (mut rows, mut right) = (Vec::new(), Vec::new());
    for (posture, link) in postures.iter().zip(links) {
        for (k, m) in posture.points.iter().enumerate().filter(|(_, m)| m.iter().all(|x| x.is_finite())) {
            for i in 0..3 {
                let mut row = vec![0.0; unknowns];
                (0..3).for_each(|c| row[3 * i + c] = m[c]);
                row[9 + i] = 1.0;
                (0..3).for_each(|c| row[12 + 3 * k + c] = -link.rotation[(i, c)]);
                rows.extend(row);
                right.push(link.position[i]);
            }
        }
    }
    if right.len() < unknowns {
        return None;
    }
    let found = least(DMatrix::from_row_slice(right.len(), unknowns, &rows), DVector::from_vec(right))?;
    let n = Matrix3::from_fn(|i, k| found[3 * i + k]);
    Some(nearest_rotation(&n).transpose())
}

/// The solution of smallest norm of a least squares problem.
fn least(matrix: DMatrix<f64>, right: DVector<f64>) -> Option<DVector<f64>> {
    let svd = matrix.svd(true, true);
    let tolerance = SINGULAR * svd.singular_values.max();
    svd.solve(&right, tolerance).ok()
}

/// The position of the base and the points, for a given orientation of the base. They follow from linear equations.
fn with_base(problem: &Problem, links: &[Placed], at: Unknowns, base: Matrix3<f64>) -> Unknowns {
    let unknowns = 3 + 3 * at.points.len();
    let (mut rows, mut right) = (Vec::new(), Vec::new());
    for (posture, link) in problem.postures.iter().zip(links) {
        let (rotation, position) = (base * link.rotation, base * link.position);
        for (k, m) in posture.points.iter().enumerate() {
            for i in (0..3).filter(|&i| m[i].is_finite()) {
                let mut row = vec![0.0; unknowns];
                row[i] = 1.0;
                (0..3).for_each(|c| row[3 + 3 * k + c] = rotation[(i, c)]);
                rows.extend(row);
                right.push(m[i] - position[i]);
            }
        }
    }
    let mut next = Unknowns { base: Placed { rotation: base, position: Vector3::zeros() }, ..at };
    if let Some(x) = least(DMatrix::from_row_slice(right.len(), unknowns, &rows), DVector::from_vec(right)) {
        next.base.position = Vector3::new(x[0], x[1], x[2]);
        next.points
            .iter_mut()
            .enumerate()
            .for_each(|(k, p)| *p = Vector3::new(x[3 + 3 * k], x[4 + 3 * k], x[5 + 3 * k]));
    }
    next
}

/// Starting values if distances are measured: random positions of the fixed point around the robot. For a sphere, the first
/// starting value is the point from which the tool has the most constant position (least squares); the sphere differs from it
/// by its radius.
fn around(problem: &Problem, links: &[Placed], at: &Unknowns) -> Vec<Unknowns> {
    let places: Vec<Vector3<f64>> = links.iter().map(|link| link.position).collect();
    let centre: Vector3<f64> = places.iter().sum::<Vector3<f64>>() / places.len().max(1) as f64;
    let spread = places.iter().map(|p| (p - centre).norm()).fold(0.1, f64::max);
    let mut random = Random::new(0x616e_6368);
    let mut vector = |size: f64| size * Vector3::from_fn(|_, _| random.between(-1.0, 1.0));
    let mut starts = Vec::new();
    if problem.kind == MeasurementKind::Sphere {
        // C p = a: the touched point, from which the sphere differs by its radius.
        let matrix = DMatrix::from_fn(3 * links.len(), 6, |r, c| match c {
            0..3 => links[r / 3].rotation[(r % 3, c)],
            _ => -f64::from(u8::from(r % 3 == c - 3)),
        });
        let right = DVector::from_fn(3 * links.len(), |r, _| -links[r / 3].position[r % 3]);
        if let Some(x) = least(matrix, right) {
            let (point, anchor) = (Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5]));
            let radius = links.iter().map(|link| (link.at(&point) - anchor).norm()).sum::<f64>() / links.len() as f64;
            starts.push(Unknowns { points: vec![point], anchor, radius, ..at.clone() });
        }
    }
    for _ in 0..BASE_STARTS {
        let (point, anchor) = (vector(0.2), centre + vector(1.5 * spread));
        let mean = links.iter().map(|link| (link.at(&point) - anchor).norm()).sum::<f64>() / links.len().max(1) as f64;
        let radius = if problem.kind == MeasurementKind::Sphere { mean } else { 0.0 };
        starts.push(Unknowns { points: vec![point], anchor, radius, ..at.clone() });
    }
    starts
}
