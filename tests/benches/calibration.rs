//! Tests the kinematic calibration on twelve simulated arms: intervals, prediction errors, and named mistakes. Command:
//! `cargo bench -p tests --bench calibration [DRAWS]`, 40 draws an arm.
//!
//! Each draw has errors of the geometry of 0.5 mm and 0.5 mrad, zeros up to 2 degrees, random frames, and 60 postures with
//! noise of 0.02 to 1 mm (mrad). Measured are full poses in one half of the draws, and positions of one point in the other
//! half.
//!
//! | column | meaning |
//! |---|---|
//! | rank | draws in which the number of base parameters equals the rank of a numerical Jacobian |
//! | covered | share of the 95 % intervals that contain the true value, %, and the standard deviation of this share between draws |
//! | error | root mean square error of 100 new postures over the bound by the Jacobian at the truth: root mean square over the draws, and the worst draw |
//! | left out | printed error on postures left out over the true error of new measurements, median |
//! | wrong | wrong tables that are named with the correction that cures them; all of them; those with a yes |
//!
//! `covered` should be 92 to 97 %. The intervals of a draw are correlated, so a draw counts as a cluster: with 40 draws, the
//! standard deviation of the share is 1 to 1.5 % instead of the 0.8 % of a binomial distribution of 720 intervals.

use std::fmt::Write;
use std::path::Path;

use calibration::{
    CalibrateRequest, Calibrated, Calibration, Chain, Convention, MeasurementKind, Parameter, ParameterGroup, Placed,
    Posture, Problem, TableCorrections, Unknowns, calibrate_table,
};
use nalgebra::{DMatrix, Matrix3, Rotation3, UnitQuaternion, Vector3};
use random::Random;
use robot::Robot;

/// The arms: name, and a list of links in the form that `robot` reads.
const ARMS: [(&str, &str); 12] = [
    ("6R wrist", "-,0,0,R,0|1,-pi/2,0.15,R,0|2,0,0.6,R,0|3,-pi/2,0.1,R,0.65|4,pi/2,0,R,0|5,-pi/2,0,R,0"),
    ("6R parallel", "-,0,0,R,0.13|1,pi/2,0,R,0|2,0,0.61,R,0|3,0,0.57,R,0.11|4,pi/2,0,R,0.12|5,-pi/2,0,R,0"),
    (
        "6R offset",
        "-,0,0,R,0.3|1,-pi/2,0.1,R,0.05|2,0.3,0.5,R,0.1|3,-pi/2,0.1,R,0.5|4,pi/2,0.02,R,0|5,-pi/2,0.03,R,0.1",
    ),
    (
        "7R",
        "-,0,0,R,0.33|1,-pi/2,0,R,0|2,pi/2,0,R,0.32|3,pi/2,0.08,R,0|4,-pi/2,-0.08,R,0.38|5,pi/2,0,R,0|6,pi/2,0.09,R,0",
    ),
    (
        "7R straight",
        "-,0,0,R,0.34|1,-pi/2,0,R,0|2,pi/2,0,R,0.4|3,pi/2,0,R,0|4,-pi/2,0,R,0.4|5,-pi/2,0,R,0|6,pi/2,0,R,0.1",
    ),
    ("SCARA", "-,0,0,R,0.3|1,0,0.3,R,0|2,0,0.25,P,0|3,0,0,R,0"),
    ("gantry", "-,0,0,P,0|1,pi/2,0,P,0|2,pi/2,0,P,0|3,0,0,R,0|4,pi/2,0.1,R,0.2|5,pi/2,0,R,0"),
    ("3R plane", "-,0,0,R,0|1,0,0.4,R,0|2,0,0.3,R,0"),
    ("parallelogram", "-,0,0,R,0.3|1,-pi/2,0.15,R,0|2,0,0.6,L,0|3,-pi/2,0.1,R,0.65|4,pi/2,0,R,0|5,-pi/2,0,R,0"),
    ("RPR", "-,0,0,R,0.2|1,pi/2,0.1,R,0|2,pi/2,0,P,0.4|3,0,0,R,0|4,pi/2,0,R,0.1|5,-pi/2,0,R,0"),
    (
        "rail and 6R",
        "-,pi/2,0,P,0|1,-pi/2,0,R,0.4|2,-pi/2,0.15,R,0|3,0,0.6,R,0|4,-pi/2,0.1,R,0.65|5,pi/2,0,R,0|6,-pi/2,0,R,0",
    ),
    ("6R tilted", "-,0,0,R,0.4|1,-pi/4,0.15,R,0|2,0,0.6,R,0|3,-pi/2,0.1,R,0.6|4,pi/2,0,R,0|5,-pi/2,0,R,0"),
];

/// Makes a robot from a list of links, each with: antecedent, alpha, d, type of the joint (R revolute, P prismatic, L revolute and
/// driven through a parallelogram), r. The motor of a parallelogram turns a bar beside the antecedent of the link.
fn robot(name: &str, links: &str) -> Robot {
    let all: Vec<Vec<&str>> = links.split('|').map(|link| link.split(',').collect()).collect();
    let names: Vec<String> = (1..=all.len()).map(|k| format!("q{k}")).collect();
    let mut text = format!("convention: khalil-kleinfinger\nname: {name}\ngravity: [0, 0, -9.81]\n");
    let _ = writeln!(text, "coordinates: [{}]\nlinks:", names.join(", "));
    for (k, link) in all.iter().enumerate() {
        let mut items = vec![format!("link: {}", k + 1)];
        items.push(format!("antecedent: {}", if link[0] == "-" { "base" } else { link[0] }));
        items.push(format!("alpha: {}, d: {}", link[1], link[2]));
        let q = &names[k];
        if link[3] == "L" {
            let before = &all[k - 1];
            let bar = format!("antecedent: {}, alpha: {}, d: {}, theta: {q}", before[0], before[1], before[2]);
            let _ = writeln!(text, "  - {{link: {}, {bar}}}", all.len() + 1);
        }
        items.push(match link[3] {
            "P" => format!("joint: prismatic, r: {q} + {}", link[4]),
            "L" => format!("drive: passive, theta: {q} - {}, r: {}", names[k - 1], link[4]),
            _ => format!("theta: {q}, r: {}", link[4]),
        });
        let _ = writeln!(text, "  - {{{}}}", items.join(", "));
    }
    rist::parse_robot(&text, Path::new("arm.yaml"), &rist::ModelOptions::default())
        .unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn turned(vector: Vector3<f64>) -> Matrix3<f64> {
    Rotation3::new(vector).into_inner()
}

/// A calibration problem with random postures, and the true values of all unknowns.
fn drawn(robot: &Robot, kind: MeasurementKind, count: usize, random: &mut Random) -> (Problem, Unknowns) {
    let tip = robot.link_ids().last().expect("a link");
    let chain = Chain::new(robot, tip, Convention::Dh).expect("an open chain");
    let n = chain.coordinates.len();
    let mut posture = |line| Posture {
        line,
        q: (0..n).map(|_| random.between(-2.0, 2.0)).collect(),
        torque: vec![0.0; n],
        points: vec![[0.0; 3]],
        rotation: (kind == MeasurementKind::Pose).then(Matrix3::identity),
        distance: None,
    };
    let postures = (0..count).map(|r| posture(r + 2)).collect();
    let problem = Problem::new(chain, kind, postures);
    let mut vector = |size: f64| Vector3::from_fn(|_, _| random.between(-size, size));
    let base = Placed { rotation: turned(vector(2.0)), position: vector(1.0) };
    let (tool, points) = (turned(vector(2.0)), vec![vector(0.2)]);
    let size = |parameter: &Parameter| match parameter.group() {
        ParameterGroup::Zeros => 2.0_f64.to_radians(),
        ParameterGroup::Geometry => 5e-4,
        _ => 0.0,
    };
    let sizes: Vec<f64> = problem.chain.parameters.iter().map(size).collect();
    let chain = sizes.into_iter().map(|size| random.between(-size, size)).collect();
    let truth = Unknowns { base, tool, points, chain, ..problem.nominal() };
    (problem, truth)
}

/// The problem with the measurements of the true robot, with noise.
fn measured(problem: &Problem, truth: &Unknowns, noise: f64, random: &mut Random) -> Problem {
    let mut of = |posture: &Posture| {
        let pose = truth.base.then(&problem.chain.pose(&posture.q, &posture.torque, &truth.chain));
        let mut normal = || Vector3::from_fn(|_, _| noise * random.normal());
        let points = vec![(pose.at(&truth.points[0]) + normal()).into()];
        let rotation = posture.rotation.map(|_| turned(normal()) * pose.rotation * truth.tool);
        Posture { points, rotation, ..posture.clone() }
    };
    problem.with(problem.postures.iter().map(&mut of).collect())
}

fn table(problem: &Problem, robot: &Robot) -> logs::Table {
    let names: Vec<&str> = robot.coordinates.iter().map(|c| c.name.as_str()).collect();
    let mut text = format!("{},x,y,z", names.join(","));
    text += if problem.kind == MeasurementKind::Pose { ",qx,qy,qz,qw\n" } else { "\n" };
    for posture in &problem.postures {
        let mut row: Vec<f64> = posture.q.iter().chain(&posture.points[0]).copied().collect();
        if let Some(rotation) = posture.rotation {
            let q = UnitQuaternion::from_matrix(&rotation);
            row.extend([q.i, q.j, q.k, q.w]);
        }
        text += &(row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n");
    }
    logs::Table::from_bytes("poses.csv", text.as_bytes()).expect("a table")
}

fn calibrated(robot: &Robot, problem: &Problem, what: Calibrated) -> Calibration {
    let request = CalibrateRequest { what, ..CalibrateRequest::default() };
    calibrate_table(robot, &table(problem, robot), &request, None).unwrap_or_else(|e| panic!("{}: {e}", robot.name))
}

/// Rank of the Jacobian of the residuals at the true values, by differences.
fn numerical_rank(problem: &Problem, at: &Unknowns) -> usize {
    let all: Vec<usize> = (0..problem.postures.len()).collect();
    let step = 1e-5;
    let moved = |k: usize, step: f64| {
        let mut full = vec![0.0; problem.parameters.len()];
        full[k] = step;
        problem.residuals_of(&problem.moved(at, &full), &all)
    };
    let rigid = (0..problem.parameters.len()).filter(|&k| is_rigid(problem.parameters[k]));
    let columns: Vec<_> = rigid.map(|k| (moved(k, step), moved(k, -step))).collect();
    let matrix = DMatrix::from_fn(columns[0].0.len(), columns.len(), |r, k| {
        (columns[k].1[r].0 - columns[k].0[r].0) / (2.0 * step)
    });
    let singular = matrix.singular_values();
    singular.iter().filter(|s| **s > 1e-7 * singular.max()).count()
}

fn is_rigid(parameter: Parameter) -> bool {
    matches!(parameter.group(), ParameterGroup::Frames | ParameterGroup::Zeros | ParameterGroup::Geometry)
}

#[derive(Default)]
struct Sums {
    ranks: usize,
    inside: usize,
    intervals: usize,
    shares: Vec<f64>,
    errors: Vec<f64>,
    left_out: Vec<f64>,
}

/// Evaluates one draw: rank, coverage of the intervals, and error on new postures.
fn draw(robot: &Robot, seed: u64, sums: &mut Sums) {
    let mut random = Random::new(seed);
    let kind = if seed.is_multiple_of(2) { MeasurementKind::Pose } else { MeasurementKind::Points(1) };
    let (problem, truth) = drawn(robot, kind, 60, &mut random);
    let noise = 2e-5 * 50.0_f64.powf(random.uniform());
    let given = measured(&problem, &truth, noise, &mut random);
    let found = calibrated(robot, &given, Calibrated::Geometry);
    let level = found.level();
    let nominal = Unknowns { chain: vec![0.0; truth.chain.len()], ..truth.clone() };
    // At poses of the nominal robot, all residuals are zero: the difference of two rotations by half a turn has no derivative.
    let at_nominal = measured(&problem, &nominal, 0.0, &mut random.clone());
    let [found_rank, rank] = [level.base.kept.len(), numerical_rank(&at_nominal, &nominal)];
    sums.ranks += usize::from(found_rank == rank);
    if found_rank != rank {
        println!("    {}, draw {seed}: {found_rank} base parameters, rank {rank}", robot.name);
    }
    let without_noise = calibrated(robot, &measured(&problem, &truth, 1e-9, &mut random), Calibrated::Geometry);
    let ideal = without_noise.parameters(without_noise.level());
    let (inside, intervals) = (sums.inside, sums.intervals);
    for p in found.parameters(level).iter().filter(|p| p.parameter.group() != ParameterGroup::Frames) {
        // The true base parameters are found by a calibration with the same measurements without noise.
        let expected = ideal.iter().find(|q| q.parameter == p.parameter).map_or(f64::NAN, |q| q.value);
        sums.inside += usize::from((p.value - expected).abs() < p.interval);
        sums.intervals += 1;
    }
    sums.shares.push((sums.inside - inside) as f64 / (sums.intervals - intervals).max(1) as f64);
    // On new postures, the error of the calibrated robot is compared with the bound and with the printed error.
    let (fresh, _) = drawn(robot, kind, 100, &mut random);
    let exact = measured(&fresh, &truth, 0.0, &mut random);
    let all: Vec<usize> = (0..100).collect();
    let rms = |rows: &[(f64, calibration::ResidualKind, usize)]| {
        (rows.iter().map(|(x, ..)| x * x).sum::<f64>() / rows.len() as f64).sqrt()
    };
    let error = rms(&exact.residuals_of(&level.fit.unknowns, &all));
    let columns = &level.base.kept;
    let jacobian = problem.linearised(&truth).jacobian.select_columns(columns);
    let covariance = jacobian.tr_mul(&jacobian).pseudo_inverse(1e-14).expect("an inverse") * (noise * noise);
    let new = exact.linearised(&truth).jacobian.select_columns(columns);
    let bound = ((&new * covariance * new.transpose()).trace() / new.nrows() as f64).sqrt();
    sums.errors.push(error / bound);
    let length = level.left_out.length.unwrap_or(0.0) / 3.0_f64.sqrt();
    sums.left_out.push(length / error.hypot(noise));
}

/// Makes wrong tables of an arm. Returns how many are named with the correction that cures them, how many there are, and how
/// many get the verdict "yes".
fn wrong(robot: &Robot, seed: u64) -> [usize; 3] {
    let mut random = Random::new(seed);
    let (problem, truth) = drawn(robot, MeasurementKind::Pose, 40, &mut random);
    let problem = measured(&problem, &truth, 1e-4, &mut random);
    let change = |each: &dyn Fn(&mut Posture)| {
        let mut postures = problem.postures.clone();
        postures.iter_mut().for_each(each);
        problem.with(postures)
    };
    let turns: Vec<bool> = robot.links.iter().map(|link| link.joint.kind == robot::JointKind::Revolute).collect();
    let (a, b) = (1, 2 + random.index(robot.n_coordinates() - 2));
    let name = |k: usize| robot.coordinates[k].name.clone();
    let none = TableCorrections::default;
    let invert = |p: &mut Posture| {
        let r = p.rotation.unwrap_or_default().transpose();
        p.points[0] = (-(r * Vector3::from(p.points[0]))).into();
        p.rotation = Some(r);
    };
    let cases = [
        (
            change(&|p| p.q.iter_mut().enumerate().filter(|(k, _)| turns[*k]).for_each(|(_, q)| *q = q.to_degrees())),
            TableCorrections { joint_degrees: true, ..none() },
        ),
        (change(&|p| p.points[0] = p.points[0].map(|x| 1e3 * x)), TableCorrections { millimetres: true, ..none() }),
        (change(&|p| p.q.swap(a, b)), TableCorrections { swapped: vec![[name(a), name(b)]], ..none() }),
        (change(&|p| p.q[b] = -p.q[b]), TableCorrections { reversed: vec![name(b)], ..none() }),
        (change(&invert), TableCorrections { inverted_poses: true, ..none() }),
        (
            change(&|p| {
                let q = UnitQuaternion::from_matrix(&p.rotation.unwrap_or_default());
                let w_first = nalgebra::Quaternion::new(q.k, q.w, q.i, q.j);
                p.rotation = Some(UnitQuaternion::from_quaternion(w_first).to_rotation_matrix().into_inner());
            }),
            TableCorrections { scalar_first: true, ..none() },
        ),
    ];
    let mut counts = [0; 3];
    for (table, cure) in cases {
        let found = calibrated(robot, &table, Calibrated::Zeros);
        counts[0] += usize::from(found.mistakes.iter().any(|m| m.corrections == cure));
        counts[1] += 1;
        counts[2] += usize::from(found.verdict.trust == claims::Trust::Yes);
        if !found.mistakes.iter().any(|m| m.corrections == cure) {
            let said: Vec<String> = found.mistakes.iter().map(|m| m.corrections.to_string()).collect();
            println!("    {}: {cure} is not named, but {}", robot.name, said.join("; "));
        }
    }
    counts
}

fn main() {
    let draws: u64 = std::env::args().filter_map(|word| word.parse().ok()).next().unwrap_or(40);
    println!("{:<14} {:>9} {:>13} {:>12} {:>9} {:>9}", "arm", "rank", "covered", "error", "left out", "wrong");
    for (a, (name, links)) in ARMS.into_iter().enumerate() {
        let robot = robot(name, links);
        let mut sums = Sums::default();
        (0..draws).for_each(|k| draw(&robot, 1000 * a as u64 + k, &mut sums));
        let mut wrongs = [0; 3];
        (0..draws.div_ceil(10)).for_each(|k| {
            let of = wrong(&robot, 1000 * a as u64 + 500 + k);
            wrongs.iter_mut().zip(of).for_each(|(sum, x)| *sum += x);
        });
        let median = |all: &mut Vec<f64>| {
            all.sort_by(f64::total_cmp);
            all[all.len() / 2]
        };
        // The bound is the root of an expected square, so single draws are above and below it.
        let error = (sums.errors.iter().map(|x| x * x).sum::<f64>() / draws as f64).sqrt();
        let left_out = median(&mut sums.left_out);
        let mean = sums.shares.iter().sum::<f64>() / draws as f64;
        let squares: f64 = sums.shares.iter().map(|x| (x - mean).powi(2)).sum();
        println!(
            "{name:<14} {:>9} {:>6.1} +- {:<3.1} {error:>6.2} {:>5.2} {left_out:>9.2} {:>9}",
            format!("{}/{draws}", sums.ranks),
            100.0 * sums.inside as f64 / sums.intervals.max(1) as f64,
            100.0 * squares.sqrt() / draws as f64,
            sums.errors.iter().copied().fold(0.0, f64::max),
            format!("{}/{}/{}", wrongs[0], wrongs[1], wrongs[2]),
        );
    }
}
