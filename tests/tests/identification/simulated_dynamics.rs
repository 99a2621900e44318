//! Compares the dynamics that simulations use with an independent Newton-Euler recursion, and the base parameters of R3G (three
//! revolute axes, with gravity) with a table.

use experiments::simulate::dynamics::{Dynamics, RegressorDynamics};
use tests::benchmark::robots::{puma, r3, race};
use tests::random::{Random, State};
use tests::recursion::torque;

#[test]
fn inertia_and_bias_are_those_of_the_recursion() {
    let mut random = Random(17);
    for robot in [r3(true), r3(false), race(), puma()] {
        let n = robot.robot.n_coordinates();
        let (q, dq) = (random.vector(n, 3.1), random.vector(n, 2.0));
        let recursion = |ddq: Vec<f64>| {
            let state = State { q: q.clone(), dq: dq.clone(), ddq };
            torque(&robot.robot, &state, &robot.standard)
        };
        let bias = recursion(vec![0.0; n]);
        let by_regressor = RegressorDynamics::new(&robot, robot.truth.clone());
        for dynamics in [&by_regressor as &dyn Dynamics, &robot] {
            let (mut a, mut h) = (vec![0.0; n * n], vec![0.0; n]);
            dynamics.fill(&q, &dq, &mut a, &mut h);
            for i in 0..n {
                // The torques are at most some 100 N m: sums of fewer than a thousand terms of that size.
                assert!((h[i] - bias[i]).abs() < 1e-11, "{} h_{i}: {} {}", robot.robot.name, h[i], bias[i]);
            }
            for k in 0..n {
                let tau = recursion((0..n).map(|i| f64::from(u8::from(i == k))).collect());
                for i in 0..n {
                    let expected = tau[i] - bias[i];
                    let name = &robot.robot.name;
                    assert!((a[i * n + k] - expected).abs() < 1e-11, "{name} a_{i}{k}: {} {expected}", a[i * n + k]);
                }
            }
        }
    }
}

/// The base parameters in this table were computed by hand, by the grouping rules for trees, to five decimals:
/// ZZR1 = ZZ1 + YY2 + YY3 + D3^2 M3 = 0.29288 etc.
#[test]
fn base_parameters_of_the_benchmark() {
    let robot = r3(true);
    let table = [
        ("ZZ1", 0.29288),
        ("XX2", -0.09336),
        ("XY2", -0.00070),
        ("XZ2", 0.00200),
        ("YZ2", 0.00004),
        ("ZZ2", 0.09814),
        ("MX2", 0.40000),
        ("MY2", 0.01200),
        ("XX3", -0.05673),
        ("XY3", 0.00260),
        ("XZ3", 0.00630),
        ("YZ3", 0.00084),
        ("ZZ3", 0.06277),
        ("MX3", 0.24000),
        ("MY3", -0.01800),
    ];
    assert_eq!(robot.truth.len(), table.len());
    for (k, (name, value)) in table.into_iter().enumerate() {
        assert_eq!(robot.column(name), Some(k), "{name}");
        assert!((robot.truth[k] - value).abs() < 6e-6, "{name}: {} {value}", robot.truth[k]);
    }
    assert_eq!(r3(false).truth.len(), 13);
}
