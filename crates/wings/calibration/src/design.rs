//! Chooses the postures that determine the geometric base parameters best (a design D).
//!
//! J_r: Jacobian of the measurements at posture r by the base parameters, divided by the noise of the measurements. The
//! postures of D are chosen among random postures that are within the joint limits and free of contact. An exchange algorithm
//! [Fedorov 1972, chapter 3] makes the determinant of the information matrix as large as possible. If M is the information
//! matrix of the other postures of D, the posture r adds
//! ```text
//! ln det(I + J_r M^-1 J_r')   to   ln det(sum over D of J_r' J_r)
//! ```
//! The covariance of a predicted position is R (sum of J_r' J_r)^-1 R'. R: Jacobian of this position by the base parameters.
//! The largest standard deviation of a position is the square root of the largest eigenvalue of this matrix, over random
//! postures. With the singular values s_1 >= .. >= s_L of the stacked Jacobian of m postures, the observability indices are
//! [Sun, Hollerbach 2008]
//! ```text
//! O1 = (s_1 .. s_L)^(1/L) / sqrt(m)   O2 = s_L / s_1   O3 = s_L   O4 = s_L^2 / s_1   O5 = 1 / (1/s_1 + .. + 1/s_L)
//! ```
//! Not checked: the way from one posture to the next, on which a robot may touch something.
//!
//! Random postures are used for three purposes: candidates for the design, postures for comparison, and postures at which the
//! accuracy of positions is predicted (elsewhere).

use std::fmt::{self, Write};
use std::path::Path;

use claims::significant;
use clearance::clearance::Clearance;
use clearance::gaps::{ClearanceRules, Situation};
use nalgebra::DMatrix;
use rist::Error;
use robot::Robot;
use serde_json::{Value, json};

use crate::base_geometry::{GeometricBase, geometric_base, random_postures, random_unknowns};
use crate::calibrate::{chain_of, names_of};
use crate::fit::inverse;
use crate::measurement::{MeasurementKind, Posture, Problem, ResidualKind};
use crate::parameter::ParameterGroup;
use crate::request::{CalibrateRequest, Calibrated, Measured};

/// Noise of a measured length, m, and of a measured angle, rad, in the predictions.
pub const DESIGN_NOISE: f64 = 1e-4;
/// Numbers of postures for which designs are compared with random postures (the curve).
const SIZES: [usize; 4] = [10, 20, 50, 100];
/// Three numbers of random postures. `CANDIDATES`: the design is chosen from these. `ELSEWHERE`: the accuracy of predicted
/// positions is computed at these. `AT_RANDOM`: the design is compared with these.
const CANDIDATES: usize = 300;
const ELSEWHERE: usize = 100;
const AT_RANDOM: usize = 100;
/// Largest number of random postures that are tested for contact.
const TRIED: usize = 4000;
/// Number of random poses that decide which pairs of links always touch (such pairs are not tested for contact).
const SAMPLED: usize = 300;
/// Largest number of passes over the chosen postures, and the least gain of an exchange.
const PASSES: usize = 5;
const LEAST_GAIN: f64 = 1e-6;
/// Information that every parameter has before the first posture, as a share of the mean information of a posture.
const FIRST_INFORMATION: f64 = 1e-8;

/// How well a number of postures determines the parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Determined {
    /// Number of postures.
    pub count: usize,
    /// Logarithm of the determinant of the information.
    pub ln_det: f64,
    /// Largest standard deviation of a predicted position, m.
    pub largest_sigma: f64,
}

/// Chosen postures, and how well they determine the parameters.
#[derive(Clone, Debug)]
pub struct Design {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Positions of the joints, rad (m), one row per posture.
    pub postures: Vec<Vec<f64>>,
    /// Number of base parameters.
    pub parameters: usize,
    /// The observability indices O1 to O5.
    pub indices: [f64; 5],
    /// For each number of postures: the result for designed postures, and for the same number of random postures. `None`: the
    /// postures do not determine all parameters.
    pub curve: Vec<[Option<Determined>; 2]>,
    /// Notes on which contacts were checked and which were not.
    pub notes: Vec<String>,
}

/// Designs `count` postures of a robot. `directory`: the folder of its description, for meshes.
///
/// Fails if the request asks for stiffness, if too few postures are free of contact, or if `count` postures do not determine the
/// base parameters.
pub fn design(robot: &Robot, directory: &Path, request: &CalibrateRequest, count: usize) -> Result<Design, Error> {
    if request.what == Calibrated::Stiffness {
        return Err(Error::new("[design] is for [what=zeros] and [what=geometry]: stiffness also needs loads"));
    }
    let chain = chain_of(robot, request)?;
    let n = chain.coordinates.len();
    let kind = if request.measured == Measured::Pose { MeasurementKind::Pose } else { MeasurementKind::Points(1) };
    let rotation = (kind == MeasurementKind::Pose).then(nalgebra::Matrix3::identity);
    // A design does not use measured values, only their kind. So all postures are copies of `like`, with random q.
    let (q, torque) = (vec![0.0; n], vec![0.0; n]);
    let like = Posture { line: 0, q, torque, points: vec![[0.0; 3]], rotation, distance: None };
    let problem = Problem::new(chain, kind, vec![like.clone()]);
    let with_geometry = request.what == Calibrated::Geometry;
    let base = geometric_base(robot, &problem, |p| match p.group() {
        ParameterGroup::Frames | ParameterGroup::Zeros => true,
        ParameterGroup::Geometry => with_geometry,
        _ => false,
    })?;
    let (free, notes) = free_postures(robot, directory, &problem, &like)?;
    let pool = Pool::new(&problem.with(free), &base);
    let chosen = pool.designed(count);
    // The smallest number of designed postures that determines all base parameters, for the message of the error.
    let smallest = || (1..=CANDIDATES).find(|&n| pool.determined(&pool.designed(n)).is_some());
    if pool.determined(&chosen).is_none() {
        let enough = smallest().map_or(String::new(), |n| format!(": {n} do"));
        let message =
            format!("[design]: {count} postures do not determine {} base parameters{enough}", base.kept.len());
        return Err(Error::new(message));
    }
    // The curve: designs of several sizes, each beside the same number of random postures (at most AT_RANDOM postures).
    let mut sizes = SIZES.to_vec();
    sizes.push(count);
    sizes.sort_unstable();
    sizes.dedup();
    let random = |n: usize| (n <= AT_RANDOM).then(|| (CANDIDATES..CANDIDATES + n).collect::<Vec<usize>>());
    let pair = |n: usize| [Some(pool.designed(n)), random(n)].map(|of| pool.determined(&of?));
    let names = names_of(robot, 1);
    Ok(Design {
        joints: problem.chain.coordinates.iter().map(|&k| names.coordinates[k].clone()).collect(),
        postures: chosen.iter().map(|&r| pool.postures[r].q.clone()).collect(),
        parameters: base.kept.len(),
        indices: pool.indices(&chosen),
        curve: sizes.into_iter().map(pair).collect(),
        notes,
    })
}

/// Random postures within the limits of the joints that are free of contact, with notes on what was checked.
fn free_postures(
    robot: &Robot,
    directory: &Path,
    problem: &Problem,
    like: &Posture,
) -> Result<(Vec<Posture>, Vec<String>), Error> {
    let limits = robot.coordinates.iter().map(|c| c.limits.position);
    // Joints that are not in the chain stand at zero, or at the limit that is nearest to zero.
    let zero: Vec<f64> = limits.map(|limits| limits.map_or(0.0, |(low, high)| 0.0f64.max(low).min(high))).collect();
    let all = |posture: &Posture| {
        let mut q = zero.clone();
        problem.chain.coordinates.iter().zip(&posture.q).for_each(|(&k, x)| q[k] = *x);
        q
    };
    let mut moves = vec![false; zero.len()];
    problem.chain.coordinates.iter().for_each(|&k| moves[k] = true);
    let tried = random_postures(robot, problem, like, TRIED);
    let poses = tried.iter().take(SAMPLED).map(&all).collect();
    let situation = Situation { rest: zero.clone(), zero: zero.clone(), moves, poses };
    let clearance = Clearance::new(robot, directory, &ClearanceRules::default(), &situation).map_err(Error::new)?;
    let which: Vec<usize> = (0..clearance.gaps().len()).collect();
    // A posture is free of contact if every distance is at least the distance that the rules require.
    let is_free = |posture: &Posture| {
        let rooms = clearance.rooms(&all(posture), &vec![0.0; zero.len()], &which);
        rooms.iter().zip(clearance.gaps()).all(|(room, gap)| room.reached >= gap.bound)
    };
    // The three groups of `Pool`, in this order.
    let wanted = CANDIDATES + AT_RANDOM + ELSEWHERE;
    let free: Vec<Posture> = tried.into_iter().filter(is_free).take(wanted).collect();
    if free.len() < wanted {
        let message = format!(
            "of {TRIED} random postures within the limits of the joints, {} are free of contact, and {wanted} are needed: \
             narrow the limits in the description",
            free.len()
        );
        return Err(Error::new(message));
    }
    let mut notes = vec![match which.len() {
        0 => "contact is not checked: no body has a shape".into(),
        n => format!(
            "free of contact, by {n} distances between bodies and to the floor; the way from posture to posture is not checked"
        ),
    }];
    let unlimited = |k: &&usize| robot.coordinates[**k].limits.position.is_none();
    let names: Vec<&str> =
        problem.chain.coordinates.iter().filter(unlimited).map(|&k| robot.coordinates[k].name.as_str()).collect();
    if !names.is_empty() {
        notes.push(format!("no limits of position: {}; half a turn (m) to each side is taken", names.join(", ")));
    }
    Ok((free, notes))
}

/// All random postures, in this order: `CANDIDATES` postures from which designs are chosen, `AT_RANDOM` postures with which
/// designs are compared, and `ELSEWHERE` postures at which positions are predicted.
struct Pool {
    postures: Vec<Posture>,
    /// For each posture, the Jacobian of its measurements, divided by their noise.
    blocks: Vec<DMatrix<f64>>,
    /// For each posture, the Jacobian of the measured position, m.
    positions: Vec<DMatrix<f64>>,
    first: DMatrix<f64>,
}

impl Pool {
    fn new(problem: &Problem, base: &GeometricBase) -> Pool {
        let at = random_unknowns(problem);
        let one = |r: usize| {
            let rows = problem.linearised_of(&at, &[r]);
            let jacobian = rows.jacobian.select_columns(&base.kept);
            let is_length = |k: &usize| rows.kinds[*k] == ResidualKind::Length;
            let lengths: Vec<usize> = (0..rows.kinds.len()).filter(is_length).collect();
            (&jacobian / DESIGN_NOISE, jacobian.select_rows(&lengths))
        };
        let (blocks, positions): (Vec<_>, Vec<_>) = (0..problem.postures.len()).map(one).unzip();
        let mean: DMatrix<f64> = blocks.iter().take(CANDIDATES).map(|j| j.tr_mul(j)).sum();
        let first = DMatrix::from_diagonal(&(mean.diagonal() * (FIRST_INFORMATION / CANDIDATES as f64)));
        Pool { postures: problem.postures.clone(), blocks, positions, first }
    }

    fn information(&self, of: &[usize]) -> DMatrix<f64> {
        let none = DMatrix::zeros(self.first.nrows(), self.first.nrows());
        of.iter().fold(none, |sum, &r| sum + self.blocks[r].tr_mul(&self.blocks[r]))
    }

    /// The candidate that adds most to the information of the postures `of`, with its gain.
    fn best(&self, of: &[usize]) -> (usize, f64) {
        let inverse = inverse(&(&self.first + self.information(of)));
        let gain = |r: usize| {
            let block = &self.blocks[r];
            let inner = DMatrix::identity(block.nrows(), block.nrows()) + block * &inverse * block.transpose();
            inner.cholesky().map_or(0.0, |c| 2.0 * c.l().diagonal().iter().map(|x| x.ln()).sum::<f64>())
        };
        let all = (0..CANDIDATES).filter(|r| !of.contains(r)).map(|r| (r, gain(r)));
        all.fold((0, f64::NEG_INFINITY), |best, next| if next.1 > best.1 + LEAST_GAIN { next } else { best })
    }

    /// The best `count` candidates. They are first chosen one after the other. Then each is exchanged with a better candidate,
    /// until no exchange increases the information.
    fn designed(&self, count: usize) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        for _ in 0..count.min(CANDIDATES) {
            chosen.push(self.best(&chosen).0);
        }
        for _ in 0..PASSES {
            let before = chosen.clone();
            for k in 0..chosen.len() {
                let others: Vec<usize> = chosen.iter().copied().filter(|&r| r != chosen[k]).collect();
                chosen[k] = self.best(&others).0;
            }
            if chosen == before {
                break;
            }
        }
        chosen
    }

    fn stacked(&self, of: &[usize]) -> DMatrix<f64> {
        let rows: Vec<_> = of.iter().flat_map(|&r| self.blocks[r].row_iter()).collect();
        DMatrix::from_rows(&rows)
    }

    /// How well postures determine the parameters. `None` if their Jacobian does not have full rank.
    fn determined(&self, of: &[usize]) -> Option<Determined> {
        let all: Vec<usize> = (0..self.first.nrows()).collect();
        if GeometricBase::of(&self.stacked(of), &all).ok()?.kept.len() < all.len() {
            return None;
        }
        let information = self.information(of);
        let scale = information.diagonal().map(f64::sqrt);
        let scaled = DMatrix::from_fn(all.len(), all.len(), |i, k| information[(i, k)] / (scale[i] * scale[k]));
        let ln_det = 2.0 * scaled.cholesky()?.l().diagonal().iter().zip(&scale).map(|(x, s)| (x * s).ln()).sum::<f64>();
        let covariance = inverse(&information);
        let variance = |rows: &DMatrix<f64>| (rows * &covariance * rows.transpose()).symmetric_eigenvalues().max();
        let largest = self.positions[CANDIDATES + AT_RANDOM..].iter().map(variance).fold(0.0, f64::max);
        Some(Determined { count: of.len(), ln_det, largest_sigma: largest.sqrt() })
    }

    fn indices(&self, of: &[usize]) -> [f64; 5] {
        let values = (self.stacked(of) * DESIGN_NOISE).singular_values();
        let (largest, least, count) = (values.max(), values.min(), values.len() as f64);
        let mean = (values.iter().map(|s| s.ln()).sum::<f64>() / count).exp();
        let inverses: f64 = values.iter().map(|s| 1.0 / s).sum();
        [mean / (of.len() as f64).sqrt(), least / largest, least, least * least / largest, 1.0 / inverses]
    }
}

impl Design {
    /// The postures as CSV: one column a joint, rad (m).
    pub fn to_csv(&self) -> String {
        let mut text = self.joints.join(",") + "\n";
        for q in &self.postures {
            text += &(q.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n");
        }
        text
    }

    /// The design as JSON.
    pub fn to_json(&self) -> Value {
        let one = |of: &Option<Determined>| {
            of.as_ref().map(|d| json!({"postures": d.count, "ln_det": d.ln_det, "largest_sigma": d.largest_sigma}))
        };
        let curve: Vec<Value> = self.curve.iter().map(|[a, b]| json!({"designed": one(a), "random": one(b)})).collect();
        let indices = ["O1", "O2", "O3", "O4", "O5"].into_iter().zip(self.indices).map(|(k, x)| (k.into(), json!(x)));
        json!({"joints": self.joints, "postures": self.postures, "parameters": self.parameters, "noise": DESIGN_NOISE,
            "observability": Value::Object(indices.collect()), "curve": curve, "notes": self.notes})
    }
}

impl fmt::Display for Design {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} postures for {} base parameters", self.postures.len(), self.parameters)?;
        self.notes.iter().try_for_each(|note| writeln!(f, "note: {note}"))?;
        let noise = significant(1e3 * DESIGN_NOISE, 2);
        writeln!(f, "\nlargest sigma of a predicted position, mm, with noise of {noise} mm and {noise} mrad")?;
        writeln!(f, "{:<10} {:<12} at random", "postures", "designed")?;
        for pair in &self.curve {
            let Some(count) = pair.iter().flatten().map(|d| d.count).next() else { continue };
            let shown = |of: &Option<Determined>| {
                of.as_ref().map_or("not all".into(), |d| significant(1e3 * d.largest_sigma, 3).to_string())
            };
            writeln!(f, "{count:<10} {:<12} {}", shown(&pair[0]), shown(&pair[1]))?;
        }
        let mut indices = String::new();
        for (k, x) in self.indices.iter().enumerate() {
            let _ = write!(indices, "  O{} {}", k + 1, significant(*x, 3));
        }
        writeln!(f, "\nobservability:{indices}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose_table::PoseTable;
    use crate::simulated::ARM;

    fn request() -> CalibrateRequest {
        CalibrateRequest::default()
    }

    fn arm(text: &str) -> Robot {
        rist::parse_robot(text, Path::new("arm.yaml"), &rist::ModelOptions::default()).unwrap()
    }

    /// Designed postures are within the limits, and determine the parameters better than the same number of random postures.
    /// The file of the design has the columns of the joints.
    #[test]
    fn designed_postures_tell_more() {
        let robot = arm(&ARM.replace("theta: q3", "theta: q3, limits: {position: [-1, 0.5]}"));
        let found = design(&robot, Path::new("."), &request(), 20).unwrap();
        assert!(found.postures.len() == 20 && found.postures.iter().all(|q| (-1.0..=0.5).contains(&q[2])), "{found}");
        let of = |count: usize, which: usize| {
            let pair = found.curve.iter().find(|p| p[0].as_ref().is_some_and(|d| d.count == count)).unwrap();
            pair[which].clone().unwrap()
        };
        // With the same number of random postures, the largest sigma is at least 1.2 times as large as with the design (1.4
        // times here), and the information is smaller.
        for count in [10, 20] {
            let (designed, random) = (of(count, 0), of(count, 1));
            assert!(1.2 * designed.largest_sigma < random.largest_sigma && designed.ln_det > random.ln_det, "{found}");
        }
        let sigma = |k: usize| of([10, 20, 50, 100][k], 0).largest_sigma;
        assert!((0..3).all(|k| sigma(k) > sigma(k + 1)), "{found}");
        let table = logs::Table::from_bytes("p.csv", found.to_csv().as_bytes()).unwrap();
        assert!(
            PoseTable::of_table(&table, &robot, &[0, 1, 2, 3, 4, 5], &Default::default(), Some(crate::Touched::Point))
                .is_ok()
        );
        let refused = design(&robot, Path::new("."), &request(), 3).unwrap_err().to_string();
        assert!(refused.contains("3 postures do not determine"), "{refused}");
    }
}
