//! Finds mistakes in a table of postures: wrong units, orders and signs. For each possible mistake, the table is corrected and
//! fitted again.
//!
//! The share of a fit is the median error over the postures, relative to the spread of the measured points (for angles:
//! relative to 1 rad). A mistake is named if its correction divides the share by at least [`CURED`]. If other mistakes explain
//! the table equally well, they are named too.
//!
//! Cured means that the share is small after the correction. The tip is the measured link; a wrong tip is one of the possible
//! mistakes.

use nalgebra::Vector3;
use rist::Error;

use crate::base_geometry::geometric_base;
use crate::corrections::TableCorrections;
use crate::measurement::{Problem, ResidualKind, Unknowns};
use crate::parameter::ParameterGroup;
use crate::pose_table::PoseTable;
use crate::start::start;
use robot::Robot;

/// A correction is named only if it divides the share (see above) by at least this value.
const CURED: f64 = 3.0;
/// A correction explains the table as well as the best correction does if its share is at most this multiple of the best
/// share.
const AS_WELL: f64 = 1.5;
/// If the share is below this value, no mistake is searched, because errors of a description have this size.
const SMALL_SHARE: f64 = 0.004;
/// An angle of this size, rad, counts as much as a length that is equal to the spread of the points.
pub(crate) const ANGLE_SPREAD: f64 = 1.0;

/// A mistake in the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// What is wrong.
    pub fault: String,
    /// The corrections that cure the mistake, together with the corrections that the user gave.
    pub corrections: TableCorrections,
    /// The link that was really measured, if it is another link than the assumed one.
    pub tip: Option<String>,
    /// Shares of the error: before and after.
    pub shares: [f64; 2],
}

/// The median error of the postures, relative to the spread of the measurements (`spread`).
pub(crate) fn share(problem: &Problem, at: &Unknowns) -> f64 {
    let rows = problem.linearised(at);
    let spread = spread(problem);
    let mut squares = vec![0.0; problem.postures.len()];
    for ((x, kind), r) in rows.residual.iter().zip(&rows.kinds).zip(&rows.posture) {
        squares[*r] += (x / if *kind == ResidualKind::Length { spread } else { ANGLE_SPREAD }).powi(2);
    }
    let middle = squares.len() / 2;
    if squares.is_empty() { 0.0 } else { squares.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt() }
}

/// Spread of the measurements, m: the root mean square distance of the measured points from their mean. For measured
/// distances: from the mean distance. If the tool touches something, so that nothing is measured, the positions of the last
/// link are used.
pub(crate) fn spread(problem: &Problem) -> f64 {
    let measured = |p: &crate::measurement::Posture| match (p.distance, p.points.first()) {
        (Some(distance), _) => Vector3::new(distance, 0.0, 0.0),
        (None, Some(point)) => Vector3::from(point.map(|x| if x.is_finite() { x } else { 0.0 })),
        (None, None) => Vector3::zeros(),
    };
    let own = spread_of(problem.postures.iter().map(measured).collect());
    if own > 0.0 { own } else { spread_of_links(problem) }
}

fn spread_of(all: Vec<Vector3<f64>>) -> f64 {
    let mean: Vector3<f64> = all.iter().sum::<Vector3<f64>>() / all.len().max(1) as f64;
    (all.iter().map(|x| (x - mean).norm_squared()).sum::<f64>() / all.len().max(1) as f64).sqrt()
}

/// Root mean square distance of the positions of the last link from their mean, m. The positions follow from the description.
pub(crate) fn spread_of_links(problem: &Problem) -> f64 {
    let nothing = vec![0.0; problem.chain.parameters.len()];
    let of_link = |p: &crate::measurement::Posture| problem.chain.pose(&p.q, &p.torque, &nothing).position;
    spread_of(problem.postures.iter().map(of_link).collect()).max(f64::MIN_POSITIVE)
}

/// The possible mistakes of a table, each with its correction.
fn candidates(table: &PoseTable, given: &TableCorrections) -> Vec<(String, TableCorrections)> {
    let mut all: Vec<(String, TableCorrections)> = Vec::new();
    // Each candidate changes the corrections of the user by one more. If the user already gave this correction, it is taken
    // back (`^=`), because the correction may be the mistake.
    let mut add = |fault: &str, change: &dyn Fn(&mut TableCorrections)| {
        let mut corrections = given.clone();
        change(&mut corrections);
        all.push((fault.into(), corrections));
    };
    // Only mistakes that this table can have are tried, for example degrees only if a joint is revolute.
    if table.slides.iter().any(|slides| !slides) {
        add("the positions of the joints are in degrees", &|c| c.joint_degrees ^= true);
    }
    if table.has_lengths() {
        add("the measured lengths are in mm", &|c| c.millimetres ^= true);
    }
    if let Some(quaternions) = table.has_quaternions() {
        add("the poses are those of the base in the tool, as of a tag that a camera on the hand sees", &|c| {
            c.inverted_poses ^= true
        });
        if quaternions {
            add("the first number of the quaternions is w", &|c| c.scalar_first ^= true);
            add("the first number of the quaternions is w, and the poses are inverted", &|c| {
                c.scalar_first ^= true;
                c.inverted_poses ^= true;
            });
        } else {
            add("the angles of the orientation are in degrees", &|c| c.degrees ^= true);
            add("the three angles are of the other kind (roll, pitch, yaw or a rotation vector)", &|c| {
                c.other_angles ^= true
            });
        }
    }
    for (k, a) in table.coordinates.iter().enumerate() {
        add(&format!("the sign of joint {a} is reversed"), &|c| match c.reversed.iter().position(|name| name == a) {
            Some(place) => drop(c.reversed.remove(place)),
            None => c.reversed.push(a.clone()),
        });
        for b in &table.coordinates[k + 1..] {
            add(&format!("the columns of {a} and {b} are exchanged"), &|c| c.swapped.push([a.clone(), b.clone()]));
        }
    }
    all
}

/// The share (median error relative to the spread) after a fit of frames and zeros. The fit needs no initial guess.
fn share_under(robot: &Robot, problem: &Problem) -> Result<f64, Error> {
    let is_rigid = |group| matches!(group, ParameterGroup::Frames | ParameterGroup::Zeros);
    let active = geometric_base(robot, problem, |p| is_rigid(p.group()))?.kept;
    Ok(share(problem, &start(problem, &active, 0)))
}

/// The mistakes that explain the table. `as_given`: the share without any correction; if it is small, there are no mistakes.
/// `tips`: the same table for other measured links, each with the name of the link.
pub(crate) fn mistakes<'a>(
    robot: &Robot,
    problem: &Problem,
    table: &PoseTable,
    tips: impl Fn() -> Vec<(&'a str, Problem)>,
    given: &TableCorrections,
    as_given: f64,
) -> Result<Vec<Mistake>, Error> {
    if as_given <= SMALL_SHARE {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    // A correction that this table does not allow explains nothing and is skipped.
    for (fault, corrections) in candidates(table, given) {
        let Ok(postures) = table.postures(&corrections) else { continue };
        let after = share_under(robot, &problem.with(postures))?;
        if CURED * after < as_given {
            found.push(Mistake { fault, corrections, tip: None, shares: [as_given, after] });
        }
    }
    // A wrong measured link needs another chain instead of other numbers. The criterion is the same.
    for (name, other) in tips() {
        let after = share_under(robot, &other)?;
        if CURED * after < as_given {
            let fault = format!("the measured link is {name}");
            let (corrections, tip) = (given.clone(), Some(name.to_string()));
            found.push(Mistake { fault, corrections, tip, shares: [as_given, after] });
        }
    }
    // The table cannot decide between mistakes that explain it about equally well, so all of them are kept.
    found.sort_by(|a, b| a.shares[1].total_cmp(&b.shares[1]));
    let best = found.first().map_or(0.0, |m| m.shares[1]);
    found.retain(|m| m.shares[1] <= AS_WELL * best);
    Ok(found)
}

#[cfg(test)]
mod tests {
    use claims::Trust;
    use nalgebra::{Quaternion, UnitQuaternion};
    use random::Random;

    use super::*;
    use crate::calibrate::{Calibration, calibrate_table};
    use crate::chain::{Chain, Convention};
    use crate::laws::{calibrated, simulated, table};
    use crate::measurement::{MeasurementKind, Posture};
    use crate::request::{CalibrateRequest, Calibrated};
    use crate::simulated::{arm, measured, truth};

    fn found(problem: &Problem) -> Calibration {
        calibrated(&arm(), problem, TableCorrections::default(), Calibrated::Geometry)
    }

    fn good() -> Problem {
        simulated(MeasurementKind::Pose, 60, 0.03, 21).1
    }

    /// Quaternions with w first are named as the mistake, and the named correction removes it.
    #[test]
    fn quaternions_with_w_first_are_named() {
        let mut wrong = good();
        for posture in &mut wrong.postures {
            let q = UnitQuaternion::from_matrix(&posture.rotation.unwrap());
            // The columns qx, qy, qz, qw hold w, x, y, z.
            let read = UnitQuaternion::from_quaternion(Quaternion::new(q.k, q.w, q.i, q.j));
            posture.rotation = Some(read.to_rotation_matrix().into_inner());
        }
        let named = found(&wrong);
        let cure = TableCorrections { scalar_first: true, ..TableCorrections::default() };
        assert!(named.verdict.trust == Trust::No && named.mistakes.iter().any(|m| m.corrections == cure), "{named}");
        let cured = calibrated(&arm(), &wrong, cure, Calibrated::Geometry);
        assert!(cured.mistakes.is_empty() && cured.verdict.trust == Trust::Yes, "{cured}");
    }

    /// A marker is on link 4, but is assumed to be on the last link, or the reverse. The program names the link that was really
    /// measured; with this link, the verdict is "yes".
    #[test]
    fn another_measured_link_is_named() {
        let (robot, whole) = (arm(), good());
        let names: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
        for (on, taken) in [(3, 5), (5, 3)] {
            let tip = robot.link_ids().nth(on).unwrap();
            let chain = Chain::new(&robot, tip, Convention::Dh).unwrap();
            let cut = |p: &Posture| Posture { q: p.q[..=on].to_vec(), torque: vec![0.0; on + 1], ..p.clone() };
            let postures = whole.postures.iter().map(cut).collect();
            let problem = Problem::new(chain, MeasurementKind::Pose, postures);
            let mut random = Random::new(4);
            let truth = truth(&problem, 0.03, 5e-4, &mut random);
            let problem = measured(&problem, &truth, [1e-4; 2], &mut random);
            let all = whole.postures.iter().zip(problem.postures).map(|(p, own)| Posture { q: p.q.clone(), ..own });
            let table = table(&whole.with(all.collect()), &robot);
            let of = |tip: usize| {
                let tip = Some(names[tip].clone());
                let request = CalibrateRequest { what: Calibrated::Zeros, tip, ..CalibrateRequest::default() };
                calibrate_table(&robot, &table, &request, None).unwrap()
            };
            let named = of(taken);
            assert!(named.verdict.trust == Trust::No, "{named}");
            assert_eq!(named.mistakes[0].tip.as_ref(), Some(&names[on]), "{named}");
            let text = format!("[tip={}]", names[on]);
            assert!(named.to_string().contains(&text), "{named}");
            let cured = of(on);
            assert!(cured.mistakes.is_empty() && cured.verdict.trust == Trust::Yes, "{cured}");
        }
    }

    /// A marker on the base does not move with the robot.
    #[test]
    fn what_is_at_rest_is_named() {
        let mut wrong = good();
        let (first, mut random) = (wrong.postures[0].clone(), Random::new(3));
        for posture in &mut wrong.postures {
            posture.points[0] = first.points[0].map(|x| x + 1e-4 * random.normal());
            posture.rotation = first.rotation;
        }
        let named = found(&wrong);
        assert!(named.verdict.trust == Trust::No, "{named}");
        assert!(named.to_string().contains("it is not on the robot that moves"), "{named}");
        assert!(!found(&good()).to_string().contains("not on the robot"));
    }

    /// Three wrong rows (5 % of the table) are named by their lines and left out of the fit. Without these rows, the verdict is
    /// "yes".
    #[test]
    fn wrong_rows_are_named() {
        let mut wrong = good();
        wrong.postures[8].points[0][1] += 0.05;
        wrong.postures[30].points[0] = wrong.postures[31].points[0];
        wrong.postures[50].q[3] += 0.1;
        let named = found(&wrong);
        assert_eq!(named.outliers(named.level()), [10, 32, 52]);
        assert!(named.verdict.trust == Trust::WithCare, "{named}");
        assert!(named.to_string().contains("the postures of the lines 10, 32, 52 are wrong"), "{named}");
        [50, 30, 8].into_iter().for_each(|k| drop(wrong.postures.remove(k)));
        let cured = found(&wrong);
        assert!(cured.outliers(cured.level()).is_empty() && cured.verdict.trust == Trust::Yes, "{cured}");
    }

    /// If a joint never moves, the verdict is not "yes", and the program names the joint. With additional postures in which the
    /// joint moves, the verdict is "yes".
    #[test]
    fn a_joint_at_rest_is_named() {
        let (robot, mut random) = (arm(), Random::new(9));
        let whole = good();
        let truth = truth(&whole, 0.03, 5e-4, &mut random);
        let mut still = whole.clone();
        still.postures.iter_mut().for_each(|p| p.q[4] = 0.7);
        let of = |problem: &Problem| found(&measured(problem, &truth, [1e-4; 2], &mut Random::new(2)));
        let named = of(&still);
        let text = named.to_string();
        assert!(named.verdict.trust == Trust::WithCare && text.contains("joint q5 never moves"), "{named}");
        assert!(text.contains("these postures do not determine"), "{named}");
        let moving = whole.postures.iter().take(30).chain(&still.postures).cloned().collect();
        let cured = of(&whole.with(moving));
        assert_eq!(cured.verdict.trust, Trust::Yes, "{cured}");
        assert_eq!(robot.n_coordinates(), 6);
    }
}
