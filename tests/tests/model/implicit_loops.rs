//! Tests of loops that are solved numerically. They are compared with the same loops described by affine functions, and by
//! conservation of energy.

use modeling::{Derivation, NotClosed};
use robot::{
    Affine, CoordinateId, JointKind, LinkId, Loop, LoopFrame, ModifiedDh, PassiveCoordinate, Robot, SymbolId, Value,
};
use tests::loops::with_loops;
use tests::{base_parameters, derived, dot, evaluated};

/// A planar four-bar with crank l1, coupler l2, rocker l3 and base length l4. The cut is between coupler and rocker.
fn four_bar([l1, l2, l3, l4]: [f64; 4]) -> Robot {
    let text = format!(
        "convention: khalil-kleinfinger
name: four_bar
gravity: [0, -9.81, 0]
symbols: {{L1: {l1}, L2: {l2}, L3: {l3}, L4: {l4}}}
coordinates: [q1]
links:
  - {{link: 1, antecedent: base, theta: q1}}
  - {{link: 2, antecedent: 1, drive: passive, d: L1, theta: -q1}}
  - {{link: 3, antecedent: base, drive: passive, d: L4, theta: q1}}
"
    );
    let mut robot = robot::format::read_yaml(&text, "four_bar.yaml").unwrap();
    let passive = |k: usize| Affine { terms: vec![(CoordinateId(1 + k), 1.0)], offset: Value::ZERO };
    let start = [-0.7, 0.7, 0.1];
    robot.passive = (0..3).map(|k| PassiveCoordinate { name: format!("p{k}"), start: start[k] }).collect();
    robot.links[1].joint.variable = passive(0);
    robot.links[2].joint.variable = passive(1);
    let frame = |antecedent, d, kind, variable| {
        let geometry = ModifiedDh { d, ..ModifiedDh::ZERO };
        LoopFrame { antecedent: Some(LinkId(antecedent)), geometry, kind, variable }
    };
    let cut = frame(1, Value::Number(l2), JointKind::Revolute, passive(2));
    let twin = frame(2, Value::Number(l3), JointKind::Fixed, Affine::constant(Value::ZERO));
    robot.loops.push(Loop { cut, twin });
    robot
}

/// Inertial parameters, ten per link. If n is 31, the last parameter is a rotor inertia.
fn parameters(n: usize) -> Vec<f64> {
    let body = [0.03, 0.001, -0.002, 0.05, 0.003, 0.04, 0.2, 0.05, -0.03, 2.0];
    (0..n).map(|i| body[i % 10] * (1.0 + 0.1 * (i / 10) as f64)).collect()
}

#[test]
fn a_parallelogram_solved_numerically_is_the_affine_one() {
    // If opposite sides are equal (parallelogram), the coupler stays parallel to the base, and the rocker parallel to the crank.
    let implicit = four_bar([0.3, 0.6, 0.3, 0.6]);
    let mut affine = implicit.clone();
    affine.passive.clear();
    affine.loops.clear();
    let follows = |c: f64| Affine { terms: vec![(CoordinateId(0), c)], offset: Value::ZERO };
    affine.links[1].joint.variable = follows(-1.0);
    affine.links[2].joint.variable = follows(1.0);

    let (mut solved, mut known) = (Derivation::new(&implicit).unwrap(), Derivation::new(&affine).unwrap());
    let (torque, reference) = (solved.torque(), known.torque());
    let mut closure = solved.closure().unwrap();
    let x = parameters(31);
    for q in [0.4, 0.8, 1.3, 2.0] {
        let passive = closure.solve(&[q], Some(&[-q, q, 0.0])).unwrap();
        assert!((passive[0] + q).abs() < 1e-10 && (passive[1] - q).abs() < 1e-10, "{passive:?}");
        let a = evaluated(&torque, &[&[q], &passive, &[1.7], &[-2.3], &x])[0];
        let b = evaluated(&reference, &[&[q], &[1.7], &[-2.3], &x])[0];
        // The passive angles are accurate to 1e-11; the torque is a few N m.
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn the_parallelogram_four_bar_has_three_base_parameters_either_way() {
    // Opposite sides share a symbol, so they are equal for all values of the symbols. So the exact rank is the rank of a
    // parallelogram.
    let mut implicit = four_bar([0.3, 0.6, 0.3, 0.6]);
    let symbol = |name: &str| Value::Symbol(SymbolId(implicit.symbols.iter().position(|s| s.name == name).unwrap()));
    let (crank, base) = (symbol("L1"), symbol("L4"));
    implicit.loops[0].twin.geometry.d = crank;
    implicit.loops[0].cut.geometry.d = base;
    let base = base_parameters(&implicit);
    assert_eq!(base.len(), 3, "{:?}", base.base.iter().map(|b| &b.name).collect::<Vec<_>>());
    assert_eq!(base.rank.exact, modeling::ExactRank::Closed { rank: 3, other_assemblies: true });
}

#[test]
fn power_is_the_change_of_energy_and_base_parameters_lose_nothing() {
    for robot in [four_bar([0.2, 0.55, 0.4, 0.5]), with_loops("slider_crank")] {
        let (mut derivation, regressor, base) = derived(&robot);
        let mut closure = derivation.closure().unwrap();
        let (torque, energy) = (derivation.torque(), derivation.energy());
        let base_regressor = base.regressor(&regressor);
        let p = base.standard.len();
        let x = parameters(p);
        let x_base = base.values(&x);
        for q in [0.3, 0.9, 1.6] {
            let (dq, ddq) = (1.3, -0.8);
            let passive = closure.solve(&[q], None).unwrap();
            let tau = evaluated(&torque, &[&[q], &passive, &[dq], &[ddq], &x])[0];

            let d = evaluated(&regressor, &[&[q], &passive, &[dq], &[ddq]]);
            let d_base = evaluated(&base_regressor, &[&[q], &passive, &[dq], &[ddq]]);
            assert!((dot(&d, &x).0 - tau).abs() < 1e-11 * (1.0 + tau.abs()), "{}", robot.name);
            // The coefficients of the base parameters are numbers, with the rounding error of the rank computation.
            assert!((dot(&d_base, &x_base).0 - tau).abs() < 1e-9 * (1.0 + tau.abs()), "{}", robot.name);

            let mut at = |t: f64| {
                let (q, dq) = (q + t * dq + 0.5 * t * t * ddq, dq + t * ddq);
                let passive = closure.solve(&[q], Some(&passive)).unwrap();
                let e = evaluated(&energy, &[&[q], &passive, &[dq]]);
                dot(&e[..p], &x).0 + dot(&e[p..], &x).0
            };
            let h = 1e-3;
            let slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            // The tolerance allows for the truncation error h^4, and for 1e-11 / h, the error of the loop solution.
            assert!((slope - tau * dq).abs() < 1e-6 * (1.0 + slope.abs()), "{}: {slope} {}", robot.name, tau * dq);
        }

        // A ddq + h = tau must hold (h: bias torque), and forward dynamics must give back ddq.
        let q = 0.7;
        let passive = closure.solve(&[q], None).unwrap();
        let inverse = evaluated(&derivation.inverse_dynamics(&base), &[&[q], &passive, &[1.1], &[0.6], &x_base])[0];
        let a = evaluated(&derivation.inertia_matrix(&base), &[&[q], &passive, &x_base])[0];
        let bias = evaluated(&derivation.bias(&base), &[&[q], &passive, &[1.1], &x_base])[0];
        assert!((a * 0.6 + bias - inverse).abs() < 1e-9 * (1.0 + inverse.abs()), "{}", robot.name);
        let back = evaluated(&derivation.forward_dynamics(&base), &[&[q], &passive, &[1.1], &[inverse], &x_base])[0];
        assert!((back - 0.6).abs() < 1e-9, "{}: {back}", robot.name);
    }
}

#[test]
fn what_does_not_close_is_said() {
    let robot = four_bar([0.2, 0.55, 0.4, 0.5]);
    let derivation = Derivation::new(&robot).unwrap();
    let mut closure = derivation.closure().unwrap();
    assert!(closure.solve(&[0.5], None).is_ok());

    let torn = four_bar([0.2, 0.3, 0.4, 5.0]);
    let refused = Derivation::new(&torn).err().map(|e| e.to_string());
    assert!(refused.is_some_and(|text| text.contains("no configuration was found")));

    // At q1 = 0 all links are collinear, so the angle of the rocker is not determined.
    let flat = four_bar([0.3, 0.6, 0.3, 0.6]);
    let derivation = Derivation::new(&flat).unwrap();
    let outcome = derivation.closure().unwrap().solve(&[0.0], Some(&[0.0, 0.0, 0.0]));
    assert!(matches!(outcome, Err(NotClosed::Singular { .. })), "{outcome:?}");
}
