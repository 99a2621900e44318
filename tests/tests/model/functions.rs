//! Tests of the functions other than the regressor against the equations that relate them.

use modeling::Derivation;
use robot::LinkId;
use tests::random::Random;
use tests::{Case, agree, evaluated};

/// Tolerance for rounding of some hundred operations and a condition number of a thousand.
const ROUNDING: f64 = 1e-12;

fn cases() -> Vec<Case> {
    tests::cases(42, &["ur5", "scara", "race"])
}

#[test]
fn inverse_dynamics_in_base_parameters_is_the_torque() {
    let mut random = Random(1);
    for Case { robot, base, x, x_base } in &cases() {
        let n = robot.n_coordinates();
        let mut derivation = Derivation::new(robot).unwrap();
        let (q, dq, ddq) = (random.vector(n, 1.0), random.vector(n, 1.0), random.vector(n, 1.0));
        let torque = evaluated(&derivation.torque(), &[&q, &dq, &ddq, x]);
        let inverse = evaluated(&derivation.inverse_dynamics(base), &[&q, &dq, &ddq, x_base]);
        agree("torque", robot, &torque, &inverse, ROUNDING);
    }
}

#[test]
fn inertia_matrix_and_bias_make_the_torque() {
    let mut random = Random(2);
    for Case { robot, base, x_base, .. } in &cases() {
        let n = robot.n_coordinates();
        let mut derivation = Derivation::new(robot).unwrap();
        let (q, dq, ddq) = (random.vector(n, 1.0), random.vector(n, 1.0), random.vector(n, 1.0));
        let a = evaluated(&derivation.inertia_matrix(base), &[&q, x_base]);
        let bias = evaluated(&derivation.bias(base), &[&q, &dq, x_base]);
        let torque = evaluated(&derivation.inverse_dynamics(base), &[&q, &dq, &ddq, x_base]);
        let row = |r: usize| bias[r] + (0..n).map(|c| a[r * n + c] * ddq[c]).sum::<f64>();
        agree("A ddq + h", robot, &(0..n).map(row).collect::<Vec<_>>(), &torque, ROUNDING);
        let transposed: Vec<f64> = (0..n * n).map(|i| a[i % n * n + i / n]).collect();
        agree("A symmetric", robot, &a, &transposed, 0.0);

        let gravity = evaluated(&derivation.gravity(base), &[&q, x_base]);
        let still = evaluated(&derivation.bias(base), &[&q, &vec![0.0; n], x_base]);
        agree("gravity", robot, &gravity, &still, ROUNDING);
    }
}

#[test]
fn forward_dynamics_undoes_inverse_dynamics() {
    let mut random = Random(3);
    for Case { robot, base, x_base, .. } in &cases() {
        let n = robot.n_coordinates();
        let mut derivation = Derivation::new(robot).unwrap();
        let (q, dq, ddq) = (random.vector(n, 1.0), random.vector(n, 1.0), random.vector(n, 1.0));
        let tau = evaluated(&derivation.inverse_dynamics(base), &[&q, &dq, &ddq, x_base]);
        let back = evaluated(&derivation.forward_dynamics(base), &[&q, &dq, &tau, x_base]);
        // The condition number of the inertia matrix A, up to 1e4 here, amplifies rounding errors.
        agree("ddq", robot, &ddq, &back, 1e-9);
    }
}

#[test]
fn energies_give_inertia_matrix_gravity_and_power() {
    let mut random = Random(4);
    for Case { robot, base, x, x_base } in &cases() {
        let n = robot.n_coordinates();
        let mut derivation = Derivation::new(robot).unwrap();
        let energy = derivation.energy();
        let p = x.len();
        let energies = |q: &[f64], dq: &[f64]| -> (f64, f64) {
            let e = evaluated(&energy, &[q, dq]);
            let of = |e: &[f64]| e.iter().zip(x).map(|(e, x)| e * x).sum();
            (of(&e[..p]), of(&e[p..]))
        };
        let (q, dq) = (random.vector(n, 1.0), random.vector(n, 1.0));
        let a = evaluated(&derivation.inertia_matrix(base), &[&q, x_base]);

        // The Hessian of the kinetic energy K by dq, from differences of K. These are exact, because K is quadratic in dq.
        let unit = |i: usize, j: usize| (0..n).map(|k| f64::from(k == i) + f64::from(k == j)).collect::<Vec<f64>>();
        let single = |i: usize| (0..n).map(|k| f64::from(k == i)).collect::<Vec<f64>>();
        let kinetic = |dq: Vec<f64>| energies(&q, &dq).0;
        let hessian = |i: usize, j: usize| kinetic(unit(i, j)) - kinetic(single(i)) - kinetic(single(j));
        let of_energy: Vec<f64> = (0..n * n).map(|k| hessian(k / n, k % n)).collect();
        agree("Hessian of K", robot, &a, &of_energy, ROUNDING);

        // The power dE/dt = tau . dq, by fourth-order central differences of the energy E along q + t dq, dq + t ddq.
        let ddq = random.vector(n, 1.0);
        let torque = evaluated(&derivation.inverse_dynamics(base), &[&q, &dq, &ddq, x_base]);
        let power: f64 = torque.iter().zip(&dq).map(|(t, v)| t * v).sum();
        let at = |t: f64| {
            let q: Vec<f64> = (0..n).map(|k| q[k] + t * dq[k] + 0.5 * t * t * ddq[k]).collect();
            let dq: Vec<f64> = (0..n).map(|k| dq[k] + t * ddq[k]).collect();
            let (kinetic, potential) = energies(&q, &dq);
            kinetic + potential
        };
        let h = 1e-3;
        let slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
        // The tolerance allows for the truncation error h^4 and the rounding error epsilon / h, for energies of some hundred
        // joules.
        agree("power", robot, &[power], &[slope], 1e-8);
    }
}

#[test]
fn poses_and_jacobians_are_those_of_the_frames() {
    let mut random = Random(5);
    for Case { robot, .. } in &cases() {
        let n = robot.n_coordinates();
        let mut derivation = Derivation::new(robot).unwrap();
        let (q, dq) = (random.vector(n, 1.0), random.vector(n, 1.0));
        let frames = robot.link_poses(&q);
        for j in (0..robot.links.len()).map(LinkId) {
            let t = evaluated(&derivation.pose(j), &[&q]);
            let frame = &frames[j.0];
            for r in 0..3 {
                let row: Vec<f64> = frame.rotation[r].iter().copied().chain([frame.position[r]]).collect();
                agree("pose", robot, &t[4 * r..4 * r + 4], &row, ROUNDING);
            }
            // Velocity of the origin O_j of frame j, in the axes of frame j, by central differences of its position.
            let jacobian = evaluated(&derivation.jacobian(j), &[&q]);
            let h = 1e-5;
            let moved = |t: f64| robot.link_poses(&(0..n).map(|k| q[k] + t * dq[k]).collect::<Vec<_>>())[j.0];
            let (after, before) = (moved(h), moved(-h));
            let world: Vec<f64> = (0..3).map(|i| (after.position[i] - before.position[i]) / (2.0 * h)).collect();
            let local: Vec<f64> = (0..3).map(|c| (0..3).map(|r| frame.rotation[r][c] * world[r]).sum()).collect();
            let linear: Vec<f64> = (0..3).map(|r| (0..n).map(|k| jacobian[r * n + k] * dq[k]).sum()).collect();
            // The tolerance allows for the truncation error h^2.
            agree("velocity", robot, &local, &linear, 1e-9);

            let wrench = random.vector(6, 1.0);
            let tau = evaluated(&derivation.external_torque(j), &[&q, &wrench]);
            let expected: Vec<f64> = (0..n).map(|k| (0..6).map(|r| jacobian[r * n + k] * wrench[r]).sum()).collect();
            agree("external torque", robot, &tau, &expected, ROUNDING);
        }
    }
}

/// Energies computed from base parameters: the kinetic energy equals the sum over the bodies, and differences of potential
/// energy are equal too.
#[test]
fn energies_of_base_parameters_are_those_of_the_bodies() {
    let mut random = Random(14);
    for Case { robot, base, x, x_base } in &cases() {
        let n = robot.n_coordinates();
        let mut derivation = Derivation::new(robot).unwrap();
        let (energy, energies) = (derivation.energy(), derivation.energies(base));
        let mut at = || {
            let (q, dq) = (random.vector(n, 1.0), random.vector(n, 1.0));
            let per_unit = evaluated(&energy, &[&q, &dq]);
            let of = |e: &[f64]| e.iter().zip(x).map(|(e, x)| e * x).sum::<f64>();
            let found = evaluated(&energies, &[&q, &dq, x_base]);
            (found, [of(&per_unit[..x.len()]), of(&per_unit[x.len()..])])
        };
        let ((a, expected_a), (b, expected_b)) = (at(), at());
        agree("kinetic energy", robot, &[a[0]], &[expected_a[0]], ROUNDING);
        let (found, expected) = (a[1] - b[1], expected_a[1] - expected_b[1]);
        agree("difference of potential energy", robot, &[found], &[expected], ROUNDING);
    }
}

/// The sum of the wrenches at the joints of the first links is compared with the momentum of all links. Its force is the rate of
/// the momentum minus the weight. Its moment about the centre of mass is the rate of the angular momentum. The component of a
/// joint reaction along the joint axis equals the joint torque.
#[test]
fn reactions_move_all_that_the_base_carries() {
    let (mut random, mut seen) = (Random(15), 0);
    for Case { robot, x, .. } in cases().iter().filter(|case| case.robot.loops.is_empty()) {
        let n = robot.n_coordinates();
        let mut derivation = Derivation::new(robot).unwrap();
        let (q, dq, ddq) = (random.vector(n, 1.0), random.vector(n, 1.0), random.vector(n, 1.0));
        let reactions = evaluated(&derivation.joint_reactions(), &[&q, &dq, &ddq, x]);
        let links = robot.links.len();
        let column = |k: usize| -> [f64; 6] { std::array::from_fn(|row| reactions[row * links + k]) };
        let (centre, momentum) = (derivation.centre_of_mass(), derivation.centroidal_momentum());
        let at = |t: f64| {
            let q: Vec<f64> = (0..n).map(|k| q[k] + t * dq[k] + 0.5 * t * t * ddq[k]).collect();
            let dq: Vec<f64> = (0..n).map(|k| dq[k] + t * ddq[k]).collect();
            evaluated(&momentum, &[&q, &dq, x])[..6].to_vec()
        };
        let h = 1e-3;
        let [a, b, c, d] = [h, -h, 2.0 * h, -2.0 * h].map(at);
        let rate: Vec<f64> = (0..6).map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h)).collect();
        let c = evaluated(&centre, &[&q, x]);
        let poses = robot.link_poses(&q);
        let mut total = [0.0; 6];
        for k in robot.link_ids().filter(|j| robot.link(*j).antecedent.is_none()) {
            let wrench = column(k.0);
            let turned = |v: &[f64]| [0, 1, 2].map(|r: usize| (0..3).map(|i| poses[k.0].rotation[r][i] * v[i]).sum());
            let (f, n): ([f64; 3], [f64; 3]) = (turned(&wrench[..3]), turned(&wrench[3..]));
            let lever = [0, 1, 2].map(|i| poses[k.0].position[i] - c[i]);
            for i in 0..3 {
                let (j, l) = ((i + 1) % 3, (i + 2) % 3);
                total[i] += f[i];
                total[3 + i] += n[i] + lever[j] * f[l] - lever[l] * f[j];
            }
        }
        // Gravity has no moment about the centre of mass, so only the force is corrected.
        let masses = robot::StandardParameter::all(robot).into_iter().zip(x);
        let mass: f64 = masses.filter(|(p, _)| p.inertial == robot::Inertial::M).map(|(_, x)| x).sum();
        for i in 0..3 {
            total[i] += mass * robot.gravity_number()[i];
        }
        agree("rate of momentum", robot, &total, &rate, 1e-8);

        let torque = evaluated(&derivation.torque(), &[&q, &dq, &ddq, x]);
        for j in robot.link_ids() {
            let joint = &robot.link(j).joint;
            if let [(k, 1.0)] = joint.variable.terms[..] {
                let ia = robot::StandardParameter { link: j, inertial: robot::Inertial::Ia };
                let place = robot::StandardParameter::all(robot).iter().position(|p| *p == ia);
                let along = column(j.0)[if joint.kind == robot::JointKind::Revolute { 5 } else { 2 }];
                let is_alone =
                    robot.links.iter().filter(|l| l.joint.variable.terms.iter().any(|t| t.0 == k)).count() == 1;
                if is_alone {
                    let rotor = place.map_or(0.0, |c| x[c] * ddq[k.0]);
                    agree("along the axis", robot, &[along + rotor], &[torque[k.0]], ROUNDING);
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 50, "{seen} joints");

    // In a closed loop the torques do not determine all reaction forces: a planar loop can have internal forces out of its plane.
    let reactions = modeling::RobotFunction::of_robot("joint-reactions").unwrap();
    for Case { robot, .. } in cases().iter().filter(|case| !case.robot.loops.is_empty()) {
        let refused = reactions.check(robot).unwrap_err().to_string();
        assert!(refused.contains("cut joint"), "{}: {refused}", robot.name);
    }
}

#[test]
fn constraint_equations_are_those_of_the_closed_loops() {
    let mut random = Random(16);
    for name in ["four_bar", "watt", "three_rpr", "gough_stewart"] {
        let robot = tests::loops::with_loops(name);
        let derivation = Derivation::new(&robot).unwrap();
        let function = derivation.constraint_equations().unwrap();
        let (n, m) = (robot.n_coordinates(), robot.passive.len());
        let mut closure = derivation.closure().unwrap();
        let (origin, _) = closure.find_origin(n).unwrap();
        let q: Vec<f64> = origin.iter().map(|q| q + 0.01 * random.unit()).collect();
        let passive = closure.passive(&q).unwrap().to_vec();
        let found = evaluated(&function, &[&q, &passive]);
        let rows = function.outputs[0].rows;
        let (e, rest) = found.split_at(rows);
        let (ja, rest) = rest.split_at(rows * n);
        let (jp, g) = rest.split_at(rows * m);
        assert!(e.iter().all(|e| e.abs() < 1e-9), "{name}: the loops are open: {e:?}");
        assert!(ja.iter().chain(jp).any(|x| x.abs() > 0.1), "{name}: no equation");
        let rates: Vec<f64> =
            (0..rows * n).map(|k| ja[k] + (0..m).map(|p| jp[k / n * m + p] * g[p * n + k % n]).sum::<f64>()).collect();
        agree("ja + jp g", &robot, &rates, &vec![0.0; rows * n], 1e-8);
        // The Jacobian g of the passive coordinates by q must equal their derivative along configurations in which the loops are
        // closed.
        let h = 1e-4;
        let moved = |k: usize, h: f64, closure: &mut modeling::Closure| {
            let mut q = q.clone();
            q[k] += h;
            closure.passive(&q).unwrap().to_vec()
        };
        for k in 0..n {
            let (ahead, behind) = (moved(k, h, &mut closure), moved(k, -h, &mut closure));
            let by_differences: Vec<f64> = (0..m).map(|p| (ahead[p] - behind[p]) / (2.0 * h)).collect();
            let column: Vec<f64> = (0..m).map(|p| g[p * n + k]).collect();
            agree("dq_p per dq", &robot, &column, &by_differences, 1e-5);
        }
    }
}
