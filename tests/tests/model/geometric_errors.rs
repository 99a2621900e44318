//! Tests of the Jacobian of a frame by errors of the geometry of the links. It is compared with finite differences of an
//! independent product of transforms, and with the kinematic chain of the wing (optional package) `calibration`.

use calibration::{Chain, Convention, Letter, Parameter};
use modeling::{Derivation, ReferenceFrame};
use robot::{JointKind, LinkId, Pose, Robot};
use tests::random::Random;
use tests::{agree, evaluated};

/// The pose after a rotation about a coordinate axis (number `axis`) and a translation along this axis.
fn elementary(axis: usize, angle: f64, length: f64) -> Pose {
    let (s, c) = angle.sin_cos();
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut m = [[0.0; 3]; 3];
    (m[axis][axis], m[i][i], m[j][j], m[i][j], m[j][i]) = (1.0, c, c, -s, s);
    let mut position = [0.0; 3];
    position[axis] = length;
    Pose { rotation: m, position }
}

/// The pose of the last link of a chain, with errors of gamma, b, beta, alpha, d, theta and r of each link.
fn pose(robot: &Robot, chain: &[LinkId], q: &[f64], errors: &[f64]) -> Pose {
    chain.iter().zip(errors.chunks(7)).fold(Pose::IDENTITY, |pose, (&k, e)| {
        let link = robot.link(k);
        let number = |value: &robot::Value| value.number(&robot.symbols);
        let variable = link.joint.variable.number(q, &robot.symbols);
        let of = |kind: JointKind| if link.joint.kind == kind { variable } else { 0.0 };
        let dh = &link.geometry;
        let steps = [
            elementary(2, number(&dh.gamma) + e[0], number(&dh.b) + e[1]),
            elementary(1, e[2], 0.0),
            elementary(0, number(&dh.alpha) + e[3], number(&dh.d) + e[4]),
            elementary(
                2,
                number(&dh.theta) + of(JointKind::Revolute) + e[5],
                number(&dh.r) + of(JointKind::Prismatic) + e[6],
            ),
        ];
        steps.iter().fold(pose, |pose, step| pose.compose(step))
    })
}

/// Velocity and angular velocity (six numbers) in the base frame, by the central difference of two poses at +h and -h. `at`:
/// the pose in between.
fn velocity(ahead: &Pose, behind: &Pose, at: &Pose, h: f64) -> [f64; 6] {
    let rate = |r: usize, c: usize| (ahead.rotation[r][c] - behind.rotation[r][c]) / (2.0 * h);
    let spin = |r: usize, c: usize| (0..3).map(|k| rate(r, k) * at.rotation[c][k]).sum::<f64>();
    let v = [0, 1, 2].map(|r| (ahead.position[r] - behind.position[r]) / (2.0 * h));
    [v[0], v[1], v[2], spin(2, 1), spin(0, 2), spin(1, 0)]
}

#[test]
fn errors_of_the_geometry_move_a_link_like_differences_and_the_calibration() {
    let mut random = Random(11);
    let mut compared = 0;
    for (file, robot) in tests::models() {
        let tip = robot.link_ids().last().unwrap();
        let mut chain: Vec<LinkId> = std::iter::successors(Some(tip), |&j| robot.link(j).antecedent).collect();
        chain.reverse();
        let mut derivation = Derivation::new(&robot).unwrap();
        let in_base = derivation.geometric_error_jacobian(tip, Some(&ReferenceFrame::Base));
        let in_frame = derivation.geometric_error_jacobian(tip, None);
        let q = random.vector(robot.n_coordinates(), 2.0);
        let (found, own) = (evaluated(&in_base, &[&q]), evaluated(&in_frame, &[&q]));
        let p = 7 * chain.len();
        let nominal = pose(&robot, &chain, &q, &vec![0.0; p]);
        let column = |j: &[f64], k: usize| -> Vec<f64> { (0..6).map(|r| j[r * p + k]).collect() };
        for k in 0..p {
            let h = 1e-5;
            let moved = |step: f64| {
                let mut errors = vec![0.0; p];
                errors[k] = step;
                pose(&robot, &chain, &q, &errors)
            };
            let wanted = velocity(&moved(h), &moved(-h), &nominal, h);
            // Errors of the central difference: h^2 times a third derivative, which is about the size of the robot; and
            // rounding divided by h.
            agree(&format!("{file} error {k}"), &robot, &column(&found, k), &wanted, 1e-9);
            let turned = |v: &[f64]| [0, 1, 2].map(|c| (0..3).map(|r| nominal.rotation[r][c] * v[r]).sum::<f64>());
            let in_axes = [turned(&wanted[..3]), turned(&wanted[3..])].concat();
            agree(&format!("{file} error {k} in the frame"), &robot, &column(&own, k), &in_axes, 1e-9);
        }
        let Ok(of_wing) = Chain::new(&robot, tip, Convention::Dh) else { continue };
        let own: Vec<f64> = of_wing.coordinates.iter().map(|&k| q[k]).collect();
        let derivatives = of_wing.derivatives(&own, &vec![0.0; own.len()], &vec![0.0; of_wing.parameters.len()]);
        for (parameter, twist) in of_wing.parameters.iter().zip(&derivatives.twists) {
            let Parameter::Dh { link, letter } = *parameter else { continue };
            let place = chain.iter().position(|j| j.0 == link).unwrap();
            let letters = [Letter::Gamma, Letter::B, Letter::Beta, Letter::Alpha, Letter::D, Letter::Theta, Letter::R];
            let k = 7 * place + letters.iter().position(|l| *l == letter).unwrap();
            let v = twist.at(&derivatives.pose.position);
            let wanted = [v.x, v.y, v.z, twist.w.x, twist.w.y, twist.w.z];
            // Rounding of a chain of some ten transforms.
            agree(&format!("{file} {letter:?}"), &robot, &column(&found, k), &wanted, 1e-12);
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared}");
}
