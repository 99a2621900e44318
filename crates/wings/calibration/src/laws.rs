//! Tests of properties that every calibration must have, on simulated robots and on public measurements.
//!
//! The truth is the set of unknowns with which measurements are simulated. Zeros are errors of joint positions. The public
//! measurements are outside the repository; without them, the test is skipped.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use claims::Trust;
use logs::Table;
use nalgebra::{DMatrix, UnitQuaternion};
use random::Random;
use robot::Robot;

use crate::base_geometry::geometric_base;
use crate::calibrate::{Calibration, calibrate, calibrate_table};
use crate::chain::{Convention, turned_by};
use crate::corrections::{CalibrationOptions, TableCorrections};
use crate::fit::{Fitter, Noise};
use crate::measurement::{MeasurementKind, Problem, Unknowns};
use crate::parameter::{Parameter, ParameterGroup};
use crate::pose_table::Touched;
use crate::request::{CalibrateRequest, Calibrated};
use crate::simulated::{arm, measured, problem, truth};
use crate::start::{ZERO_STARTS, start};

const NOISE: [f64; 2] = [1e-4, 1e-4];

fn is_rigid(parameter: Parameter) -> bool {
    matches!(parameter.group(), ParameterGroup::Frames | ParameterGroup::Zeros | ParameterGroup::Geometry)
}

/// The table of a problem as CSV: joints, then points, quaternions x y z w, distances.
fn csv(problem: &Problem, names: &[String]) -> String {
    let mut text = names.join(",");
    for k in 0..problem.kind.points() {
        let number = if problem.kind.points() > 1 { (k + 1).to_string() } else { String::new() };
        let _ = write!(text, ",x{number},y{number},z{number}");
    }
    text += if problem.kind == MeasurementKind::Pose { ",qx,qy,qz,qw\n" } else { "\n" };
    for posture in &problem.postures {
        let mut row: Vec<f64> = posture.q.iter().chain(posture.points.iter().flatten()).copied().collect();
        if let Some(rotation) = posture.rotation {
            let q = UnitQuaternion::from_matrix(&rotation);
            row.extend([q.i, q.j, q.k, q.w]);
        }
        text += &(row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

pub(crate) fn table(problem: &Problem, robot: &Robot) -> Table {
    let names: Vec<String> = robot.coordinates.iter().map(|c| c.name.clone()).collect();
    Table::from_bytes("poses.csv", csv(problem, &names).as_bytes()).unwrap()
}

pub(crate) fn simulated(kind: MeasurementKind, count: usize, zero: f64, seed: u64) -> (Robot, Problem, Unknowns) {
    let (robot, mut random) = (arm(), Random::new(seed));
    let problem = problem(&robot, Convention::Dh, kind, count, &mut random);
    let truth = truth(&problem, zero, 5e-4, &mut random);
    let problem = measured(&problem, &truth, NOISE, &mut random);
    (robot, problem, truth)
}

/// The Jacobian of the measurements with respect to all parameters, by central differences.
fn numerical(problem: &Problem, at: &Unknowns) -> DMatrix<f64> {
    let (p, step) = (problem.parameters.len(), 1e-6);
    let all: Vec<usize> = (0..problem.postures.len()).collect();
    let moved = |k: usize, step: f64| {
        let mut full = vec![0.0; p];
        full[k] = step;
        problem.residuals_of(&problem.moved(at, &full), &all)
    };
    let columns: Vec<_> = (0..p).map(|k| (moved(k, step), moved(k, -step))).collect();
    DMatrix::from_fn(columns[0].0.len(), p, |r, k| (columns[k].1[r].0 - columns[k].0[r].0) / (2.0 * step))
}

/// For every kind of measurement, the exact Jacobian of the residuals equals a numerical one (by central differences), and the
/// number of base parameters equals the rank of the numerical Jacobian.
#[test]
fn jacobian_and_rank_are_those_of_numbers() {
    for kind in
        [MeasurementKind::Pose, MeasurementKind::Points(1), MeasurementKind::Points(3), MeasurementKind::Distance]
    {
        let (robot, problem, truth) = simulated(kind, 60, 0.03, 7);
        let exact_residuals = measured(&problem, &truth, [0.0; 2], &mut Random::new(1));
        let found = exact_residuals.linearised(&truth);
        let other = numerical(&exact_residuals, &truth);
        // The error of a central difference and of rounding: 1e-16 / 1e-6.
        assert!((&found.jacobian - &other).amax() < 1e-8, "{kind:?}");
        let base = geometric_base(&robot, &problem, is_rigid).unwrap();
        let selected: Vec<usize> = (0..problem.parameters.len()).filter(|&k| is_rigid(problem.parameters[k])).collect();
        let singular = other.select_columns(&selected).singular_values();
        let rank = singular.iter().filter(|s| **s > 1e-6 * singular.max()).count();
        assert_eq!(base.kept.len(), rank, "{kind:?}");
        assert!(base.gap() > 1e6, "{kind:?}: {base:?}");
    }
    // A 6R arm has 4 x 6 + 6 base parameters if the six pose parameters of the base and of the tool are unknown
    // [Khalil, Dombre 2002].
    let (robot, problem, _) = simulated(MeasurementKind::Pose, 1, 0.0, 1);
    assert_eq!(geometric_base(&robot, &problem, is_rigid).unwrap().kept.len(), 30);
}

/// Without noise, the fit finds the true zeros up to rounding, although they differ from the description by up to 30 degrees
/// and no initial guess is given.
#[test]
fn far_zeros_are_found_without_a_start() {
    for kind in [MeasurementKind::Pose, MeasurementKind::Points(1)] {
        let (robot, problem, mut truth) = simulated(kind, 40, 0.5, 11);
        truth.chain.iter_mut().skip(6).for_each(|x| *x = 0.0);
        let problem = measured(&problem, &truth, [0.0; 2], &mut Random::new(2));
        let is_zero = |p: Parameter| is_rigid(p) && p.group() != ParameterGroup::Geometry;
        let active = geometric_base(&robot, &problem, is_zero).unwrap().kept;
        let at = start(&problem, &active, ZERO_STARTS);
        let rows: Vec<usize> = (0..40).collect();
        let fit = Fitter { problem: &problem, active: &active, prior: None, rows: &rows }
            .fit(&at, Noise { length: 5e-3, angle: 5e-3 });
        for k in 1..5 {
            assert!((fit.unknowns.chain[k] - truth.chain[k]).abs() < 1e-9, "{kind:?} {:?} {:?}", fit.unknowns, truth);
        }
    }
}

/// The 95 % intervals of the base parameters contain the true values in about 95 % of the cases.
#[test]
fn intervals_cover() {
    let (mut inside, mut all) = (0u32, 0u32);
    for seed in 0..12 {
        let (robot, problem, truth) = simulated(MeasurementKind::Pose, 30, 0.03, 100 + seed);
        let base = geometric_base(&robot, &problem, is_rigid).unwrap();
        let rows: Vec<usize> = (0..30).collect();
        let noise = Noise { length: 1e-4, angle: 1e-4 };
        let fit = Fitter { problem: &problem, active: &base.kept, prior: None, rows: &rows }.fit(&truth, noise);
        // The true base parameters are found by a fit to measurements without noise.
        let without_noise = measured(&problem, &truth, [0.0; 2], &mut Random::new(1));
        let exact = Fitter { problem: &without_noise, active: &base.kept, prior: None, rows: &rows }.fit(&truth, noise);
        let quantile = numerics::student::two_sided_quantile(0.05, fit.freedom);
        let frames = problem.frames();
        for (place, &k) in fit.active.iter().enumerate().filter(|(_, k)| **k >= frames) {
            let expected = exact.unknowns.chain[k - frames];
            let sigma = fit.covariance[(place, place)].sqrt();
            inside += u32::from((fit.unknowns.chain[k - frames] - expected).abs() < quantile * sigma);
            all += 1;
        }
    }
    // Expected are 95 % of 12 x 18 parameters; three standard deviations of this share are 4.4 %.
    let share = f64::from(inside) / f64::from(all);
    assert!((0.90..=0.995).contains(&share), "{share}");
}

/// If all axes of an arm are parallel, a component of the tool has the same effect as a component of the base, so its value is
/// arbitrary. This value multiplies the errors of angles. So the intervals contain the true values only if every fit chooses
/// the same value.
#[test]
fn intervals_of_parallel_axes_cover() {
    let text = "convention: khalil-kleinfinger\nname: plane\ncoordinates: [q1, q2, q3]\nlinks:\n  - {link: 1, antecedent: base, \
                theta: q1}\n  - {link: 2, antecedent: 1, d: 0.4, theta: q2}\n  - {link: 3, antecedent: 2, d: 0.3, theta: q3}\n";
    let robot = rist::parse_robot(text, Path::new("plane.yaml"), &rist::ModelOptions::default()).unwrap();
    let (mut inside, mut all) = (0u32, 0u32);
    for seed in 0..16 {
        let mut random = Random::new(300 + seed);
        let kind = if seed % 2 == 0 { MeasurementKind::Pose } else { MeasurementKind::Points(1) };
        let problem = problem(&robot, Convention::Dh, kind, 60, &mut random);
        let truth = truth(&problem, 0.03, 5e-4, &mut random);
        let of = |noise: f64| {
            let problem = measured(&problem, &truth, [noise; 2], &mut Random::new(900 + seed));
            calibrated(&robot, &problem, TableCorrections::default(), Calibrated::Geometry)
        };
        let (found, exact) = (of(3e-5), of(1e-9));
        assert_eq!(found.level().fit.unknowns.points[0][2], 0.0);
        let exact = exact.parameters(exact.level());
        for p in found.parameters(found.level()).iter().filter(|p| p.parameter.group() != ParameterGroup::Frames) {
            let expected = exact.iter().find(|q| q.parameter == p.parameter).unwrap().value;
            assert!(p.value.abs() < 0.1, "{found}");
            inside += u32::from((p.value - expected).abs() < p.interval);
            all += 1;
        }
    }
    // Expected are 95 % of 16 x 7 parameters. Three standard deviations of this share are 6 %, and slightly more because the
    // parameters of one draw are correlated.
    let share = f64::from(inside) / f64::from(all);
    assert!(share >= 0.88, "{share}");
}

/// The result of a simulated table that is changed before it is read.
pub(crate) fn calibrated(
    robot: &Robot,
    problem: &Problem,
    corrections: TableCorrections,
    what: Calibrated,
) -> Calibration {
    let options = Some(CalibrationOptions { corrections, ..CalibrationOptions::default() });
    let request = CalibrateRequest { what, options, ..CalibrateRequest::default() };
    calibrate_table(robot, &table(problem, robot), &request, None).unwrap()
}

/// For each mistake in a table, the verdict is "no", and the mistake is named with the correction that removes it.
#[test]
fn mistakes_are_named_with_their_cure() {
    let (robot, problem, _) = simulated(MeasurementKind::Pose, 30, 0.03, 21);
    let plain = calibrated(&robot, &problem, TableCorrections::default(), Calibrated::Zeros);
    assert!(plain.mistakes.is_empty() && plain.verdict.trust != Trust::No, "{plain}");
    let change = |each: &dyn Fn(&mut crate::measurement::Posture)| {
        let mut postures = problem.postures.clone();
        postures.iter_mut().for_each(each);
        problem.with(postures)
    };
    let none = TableCorrections::default;
    let inverted = change(&|p| {
        let r = p.rotation.unwrap().transpose();
        p.points[0] = (-(r * nalgebra::Vector3::from(p.points[0]))).into();
        p.rotation = Some(r);
    });
    let cases = [
        (
            change(&|p| p.q.iter_mut().for_each(|q| *q = q.to_degrees())),
            TableCorrections { joint_degrees: true, ..none() },
        ),
        (change(&|p| p.points[0] = p.points[0].map(|x| 1e3 * x)), TableCorrections { millimetres: true, ..none() }),
        (change(&|p| p.q.swap(1, 2)), TableCorrections { swapped: vec![["q2".into(), "q3".into()]], ..none() }),
        (change(&|p| p.q[3] = -p.q[3]), TableCorrections { reversed: vec!["q4".into()], ..none() }),
        (inverted, TableCorrections { inverted_poses: true, ..none() }),
    ];
    for (wrong, cure) in cases {
        let found = calibrated(&robot, &wrong, none(), Calibrated::Zeros);
        assert_eq!(found.verdict.trust, Trust::No, "{cure}");
        assert!(found.mistakes.iter().any(|m| m.corrections == cure), "{cure}: {:?}", found.mistakes);
        let cured = calibrated(&robot, &wrong, cure, Calibrated::Zeros);
        assert!(cured.mistakes.is_empty() && cured.verdict.trust != Trust::No, "{cured}");
    }
    // Wrong rows are named by their lines; a joint that stands still is named.
    let mut postures = problem.postures.clone();
    postures[4].points[0][1] += 0.2;
    let found = calibrated(&robot, &problem.with(postures), none(), Calibrated::Geometry);
    assert_eq!(found.outliers(found.level()), [6]);
    let still = change(&|p| p.q[2] = 0.4);
    let found = calibrated(&robot, &still, none(), Calibrated::Geometry);
    assert!(found.verdict.trust != Trust::Yes && found.to_string().contains("joint q3 never moves"), "{found}");
}

/// If the tool touches a point, a plane or a sphere at every posture, the zeros are determined.
#[test]
fn what_is_touched_determines_zeros() {
    let robot = arm();
    for touched in [Touched::Point, Touched::Plane, Touched::Sphere] {
        let kind = if touched == Touched::Sphere { MeasurementKind::Sphere } else { MeasurementKind::Points(1) };
        let mut random = Random::new(31);
        let problem = problem(&robot, Convention::Dh, kind, 60, &mut random);
        let mut truth = truth(&problem, 0.03, 0.0, &mut random);
        truth.points[0] = nalgebra::Vector3::new(0.05, 0.02, 0.2);
        // Newton steps move the last three joints until the tool touches the target; the other joints keep their random
        // positions.
        let target = nalgebra::Vector3::new(0.7, 0.2, 0.4);
        let reached: Vec<_> = problem
            .postures
            .iter()
            .filter_map(|posture| {
                let mut q = posture.q.clone();
                for _ in 0..60 {
                    let link = problem.chain.derivatives(&q, &posture.torque, &truth.chain);
                    let place = link.pose.at(&truth.points[0]);
                    let (error, rows) = match touched {
                        Touched::Point => (target - place, vec![0, 1, 2]),
                        Touched::Plane => (target - place, vec![2]),
                        Touched::Sphere => {
                            let offset = place - target;
                            (offset * (0.3 / offset.norm() - 1.0), vec![0, 1, 2])
                        }
                    };
                    let jacobian = DMatrix::from_fn(rows.len(), 6, |r, k| link.twists[k].at(&place)[rows[r]]);
                    let error = nalgebra::DVector::from_fn(rows.len(), |r, _| error[rows[r]]);
                    let step = jacobian.pseudo_inverse(1e-3).unwrap() * &error;
                    q.iter_mut().zip(step.iter()).for_each(|(q, s)| *q += s.clamp(-0.3, 0.3));
                }
                let place = problem.chain.pose(&q, &posture.torque, &truth.chain).at(&truth.points[0]);
                let left = match touched {
                    Touched::Point => (target - place).norm(),
                    Touched::Plane => (target - place)[2].abs(),
                    Touched::Sphere => ((place - target).norm() - 0.3).abs(),
                };
                (left < 1e-9 && q.iter().all(|q| q.abs() < 6.0)).then_some(q)
            })
            .collect();
        assert!(reached.len() > 30, "{touched:?}: {}", reached.len());
        let rows =
            reached.iter().map(|q| q.iter().map(f64::to_string).collect::<Vec<_>>().join(",")).collect::<Vec<_>>();
        let text = format!("q1,q2,q3,q4,q5,q6\n{}\n", rows.join("\n"));
        let table = Table::from_bytes("touched.csv", text.as_bytes()).unwrap();
        let request =
            CalibrateRequest { what: Calibrated::Zeros, touched: Some(touched), ..CalibrateRequest::default() };
        let found = calibrate_table(&robot, &table, &request, None).unwrap();
        let all = found.parameters(found.level());
        let zeros: Vec<_> = all.iter().filter(|p| p.parameter.group() == ParameterGroup::Zeros).collect();
        assert!(zeros.len() >= 3, "{found}");
        for zero in zeros {
            let Parameter::Zero { coordinate } = zero.parameter else { continue };
            // The postures are exact to 1e-9 m, and the arm is about 1 m long.
            assert!((zero.value - truth.chain[coordinate]).abs() < 1e-6, "{touched:?} {found}");
        }
    }
}

/// Compliances are found from the deflections under gravity, and including them reduces the error.
#[test]
fn compliances_are_found() {
    let (robot, mut random) = (arm(), Random::new(41));
    let mut problem = problem(&robot, Convention::Dh, MeasurementKind::Pose, 40, &mut random);
    let torque = |q: &[f64], load: f64| -> Vec<f64> {
        (0..6).map(|k| (20.0 + 9.81 * load) * (6 - k) as f64 * (q[1] + 0.3 * q[k]).cos()).collect()
    };
    for posture in &mut problem.postures {
        posture.torque = torque(&posture.q, 0.0);
    }
    let mut truth = truth(&problem, 0.02, 0.0, &mut random);
    let count = truth.chain.len();
    (1..5).for_each(|k| truth.chain[count - 6 + k] = 2e-5 * k as f64);
    let problem = measured(&problem, &truth, [5e-5; 2], &mut random);
    let request = CalibrateRequest { what: Calibrated::Stiffness, ..CalibrateRequest::default() };
    let found = calibrate_table(&robot, &table(&problem, &robot), &request, Some(&torque)).unwrap();
    let (zeros, stiff) = (&found.levels[1], found.level());
    assert!(stiff.left_out.length < zeros.left_out.length.map(|x| 0.25 * x), "{found}");
    for p in found.parameters(stiff) {
        let Parameter::Compliance { coordinate } = p.parameter else { continue };
        if (1..5).contains(&coordinate) {
            // The limit is two intervals, because one of four parameters may be outside of its interval.
            assert!((p.value - 2e-5 * coordinate as f64).abs() < 2.0 * p.interval, "{found}");
        }
    }
}

/// A calibrated URDF has the poses that the calibration predicts.
#[test]
fn a_written_urdf_is_the_calibrated_robot() {
    let (text, _) = robot::format::write_urdf(&arm());
    let as_given = rist::ModelOptions { angles: rist::AngleSnapping::AsGiven, ..rist::ModelOptions::default() };
    let read = |text: &str| rist::parse_robot(text, Path::new("arm.urdf"), &as_given).unwrap();
    let robot = read(&text);
    let mut random = Random::new(51);
    for convention in [Convention::Dh, Convention::Frames] {
        let problem = problem(&robot, convention, MeasurementKind::Pose, 60, &mut random);
        let truth = truth(&problem, 0.02, 1e-3, &mut random);
        let problem = measured(&problem, &truth, [1e-6; 2], &mut random);
        let found = calibrated(&robot, &problem, TableCorrections::default(), Calibrated::Geometry);
        let level = found.level();
        let written = crate::calibrated_urdf(&text, "arm.urdf", &robot, &found, level).unwrap();
        let again = read(&written);
        let chain = &found.problem.chain;
        let q = [0.3, -0.8, 1.1, 0.4, -0.9, 2.0];
        let own = |robot: &Robot| {
            let pose = robot.link_poses(&q)[5].compose(&robot.links[5].file_frame);
            crate::chain::Placed::of(&pose)
        };
        let predicted = chain.pose(&q, &[0.0; 6], &level.fit.unknowns.chain);
        let predicted = match chain.convention() {
            Convention::Dh => predicted.then(&crate::chain::Placed::of(&robot.links[5].file_frame)),
            Convention::Frames => predicted,
        };
        // Axes are normalised and reframed when a URDF is read, with an error of 1e-9 m.
        assert!((own(&again).position - predicted.position).norm() < 1e-9, "{:?} {predicted:?}", own(&again));
    }
    assert!((turned_by(nalgebra::Vector3::zeros()) - nalgebra::Matrix3::identity()).norm() < 1e-15);
}

/// For three public data sets, the error on postures left out is at most the error of the baseline, an independent program
/// whose results are stored next to the data. Each pair: error with fitted zeros, and with fitted geometry; m, then rad.
#[test]
fn public_sets_are_predicted_like_the_baseline() {
    let folder = PathBuf::from("/work/shared/data/calibration");
    if !folder.exists() {
        eprintln!("skipped: {} is not there", folder.display());
        return;
    }
    // The baseline has 12.1 mm and 10.8 mrad for the UR10 with fitted zeros. The last digit depends on the choice of the folds.
    // With 40 random choices for the 23 postures, this program has 12.2 +- 0.33 mm (the description alone: 12.3 mm). With folds
    // of neighbouring postures, it has the error of the baseline (test in `folds`).
    let sets = [
        ("ur10_camera/ur10.urdf", "ur10_camera/poses.csv", [12.6e-3, 4.29e-3], [10.8e-3, 8.1e-3]),
        ("talos_contact/talos_left_arm.urdf", "talos_contact/points.csv", [1.66e-3, 0.83e-3], [0.0; 2]),
        ("tiago_mocap/tiago_arm.urdf", "tiago_mocap/points.csv", [4.82e-3, 5.48e-3], [0.0; 2]),
    ];
    for (urdf, csv, lengths, angles) in sets {
        let robot = rist::read_robot(&folder.join(urdf), &rist::ModelOptions::default()).unwrap();
        let found = calibrate(&robot, &folder.join(csv), &CalibrateRequest::default(), None).unwrap();
        for (level, (length, angle)) in found.levels[1..].iter().zip(lengths.into_iter().zip(angles)) {
            assert!(level.left_out.length.unwrap() <= length, "{csv} {found}");
            assert!(level.left_out.angle.is_none_or(|found| found <= angle), "{csv} {found}");
        }
        assert!(found.mistakes.is_empty(), "{csv} {found}");
        // The verdict is not "yes", because there are few postures, or because some joints hardly move.
        assert_eq!(found.verdict.trust, Trust::WithCare, "{csv} {found}");
    }
}
