//! Tests of functions for control (inverse inertia, momentum, ..). They are checked by the equations that relate them, and by
//! finite differences or dual numbers.

use expr::{Algebra, Expr, Function, Symbol, Tape};
use modeling::{Derivation, ReferenceFrame};
use robot::{LinkId, StandardParameter};
use tests::random::Random;
use tests::{Case, agree, base_parameters, evaluated, loops};

/// Tolerance for rounding of some thousand operations.
const ROUNDING: f64 = 1e-11;
/// Tolerance for derivatives by fourth-order central differences with step h = 1e-3: truncation error h^4, rounding error 1e-13,
/// times the sensitivity of an arm of seven joints.
const DIFFERENCES: f64 = 1e-8;

/// Derivative of each entry of f by each x_k with central differences: one column per k.
fn columns_by_differences(x: &[f64], f: impl Fn(&[f64]) -> Vec<f64>) -> Vec<Vec<f64>> {
    let h = 1e-3;
    let column = |k: usize| {
        let at = |step: f64| {
            let mut moved = x.to_vec();
            moved[k] += step;
            f(&moved)
        };
        let [a, b, c, d] = [h, -h, 2.0 * h, -2.0 * h].map(at);
        (0..a.len()).map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h)).collect()
    };
    (0..x.len()).map(column).collect()
}

fn row_by_row(columns: &[Vec<f64>]) -> Vec<f64> {
    (0..columns[0].len()).flat_map(|r| columns.iter().map(move |column| column[r])).collect()
}

fn cases() -> Vec<Case> {
    tests::cases(4, &["ur5", "scara"])
}

fn times(a: &[f64], x: &[f64]) -> Vec<f64> {
    a.chunks(x.len()).map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
}

/// A dual number: value and derivative along one direction.
#[derive(Clone, Copy)]
struct Dual([f64; 2]);

struct Duals<'a> {
    function: &'a Function,
    symbols: Vec<(Expr, Dual)>,
}

impl Duals<'_> {
    fn at(&self, argument: Expr) -> Dual {
        let found = self.symbols.iter().find(|(e, _)| *e == argument);
        found.unwrap_or_else(|| panic!("a sine of {:?}", self.function.graph().node(argument))).1
    }
}

impl Algebra for Duals<'_> {
    type Value = Dual;
    fn constant(&mut self, x: f64) -> Dual {
        Dual([x, 0.0])
    }
    fn symbol(&mut self, symbol: Symbol) -> Dual {
        let is = |e: &Expr| matches!(self.function.graph().node(*e), expr::Node::Symbol(s) if s == symbol);
        self.symbols.iter().find(|(e, _)| is(e)).map_or(Dual([f64::NAN; 2]), |(_, x)| *x)
    }
    fn sin(&mut self, argument: Expr) -> Dual {
        let Dual([x, d]) = self.at(argument);
        Dual([x.sin(), d * x.cos()])
    }
    fn cos(&mut self, argument: Expr) -> Dual {
        let Dual([x, d]) = self.at(argument);
        Dual([x.cos(), -d * x.sin()])
    }
    fn neg(&mut self, a: &Dual) -> Dual {
        Dual(a.0.map(|x| -x))
    }
    fn add(&mut self, a: &Dual, b: &Dual) -> Dual {
        Dual([a.0[0] + b.0[0], a.0[1] + b.0[1]])
    }
    fn sub(&mut self, a: &Dual, b: &Dual) -> Dual {
        Dual([a.0[0] - b.0[0], a.0[1] - b.0[1]])
    }
    fn mul(&mut self, a: &Dual, b: &Dual) -> Dual {
        Dual([a.0[0] * b.0[0], a.0[1] * b.0[0] + a.0[0] * b.0[1]])
    }
    fn div(&mut self, a: &Dual, b: &Dual) -> Dual {
        let x = a.0[0] / b.0[0];
        Dual([x, (a.0[1] - x * b.0[1]) / b.0[0]])
    }
    fn sqrt(&mut self, a: &Dual) -> Dual {
        let x = a.0[0].sqrt();
        Dual([x, a.0[1] / (2.0 * x)])
    }
}

/// Derivative of the first output of a function by each entry of input number `by`, row by row, computed with dual numbers.
fn by_duals(function: &Function, inputs: &[&[f64]], by: usize) -> Vec<f64> {
    let function = function.bound();
    let entries: Vec<(usize, usize)> =
        (0..function.inputs.len()).flat_map(|i| (0..function.inputs[i].entries.len()).map(move |k| (i, k))).collect();
    let column = |k: usize| {
        let value = |&(i, e): &(usize, usize)| {
            (function.inputs[i].entries[e], Dual([inputs[i][e], f64::from(u8::from((i, e) == (by, k)))]))
        };
        let mut duals = Duals { function: &function, symbols: entries.iter().map(value).collect() };
        function.evaluate_in(&mut duals)[0].iter().map(|x| x.0[1]).collect::<Vec<f64>>()
    };
    row_by_row(&(0..inputs[by].len()).map(column).collect::<Vec<_>>())
}

#[test]
fn derivatives_of_inverse_dynamics_are_those_of_dual_numbers_and_of_differences() {
    let mut random = Random(5);
    for Case { robot, base, x_base, .. } in &cases() {
        let mut derivation = Derivation::new(robot).unwrap();
        let torque = derivation.inverse_dynamics(base);
        let derivatives = derivation.inverse_dynamics_derivatives(base);
        let n = robot.n_coordinates();
        let (q, dq, ddq) = (random.vector(n, 2.0), random.vector(n, 2.0), random.vector(n, 3.0));
        let found = evaluated(&derivatives, &[&q, &dq, &ddq, x_base]);
        let (by_q, by_dq) = found.split_at(n * n);
        let inputs: [&[f64]; 4] = [&q, &dq, &ddq, x_base];
        agree("by q", robot, by_q, &by_duals(&torque, &inputs, 0), ROUNDING);
        agree("by dq", robot, by_dq, &by_duals(&torque, &inputs, 1), ROUNDING);
        let columns = columns_by_differences(&q, |q| evaluated(&torque, &[q, &dq, &ddq, x_base]));
        agree("by differences of q", robot, by_q, &row_by_row(&columns), DIFFERENCES);
    }
}

#[test]
fn coriolis_matrix_makes_the_bias_and_a_skew_symmetric_matrix() {
    let mut random = Random(6);
    for Case { robot, base, x_base, .. } in &cases() {
        let mut derivation = Derivation::new(robot).unwrap();
        let n = robot.n_coordinates();
        let (q, dq) = (random.vector(n, 2.0), random.vector(n, 2.0));
        let c = evaluated(&derivation.coriolis_matrix(base), &[&q, &dq, x_base]);
        let bias = evaluated(&derivation.bias(base), &[&q, &dq, x_base]);
        let gravity = evaluated(&derivation.gravity(base), &[&q, x_base]);
        let rest: Vec<f64> = bias.iter().zip(&gravity).map(|(h, g)| h - g).collect();
        agree("C dq", robot, &times(&c, &dq), &rest, ROUNDING);

        // The time derivative of the inertia matrix A along dq. It must equal C + C^T, C: Coriolis matrix.
        let rate = times(&by_duals(&derivation.inertia_matrix(base), &[&q, x_base], 0), &dq);
        let sum: Vec<f64> = (0..n * n).map(|k| c[k] + c[k % n * n + k / n]).collect();
        agree("C + C^T", robot, &sum, &rate, ROUNDING);
    }
}

#[test]
fn inverse_of_the_inertia_matrix_and_derivatives_of_forward_dynamics() {
    let mut random = Random(7);
    for Case { robot, base, x_base, .. } in &cases() {
        let mut derivation = Derivation::new(robot).unwrap();
        let n = robot.n_coordinates();
        let (q, dq) = (random.vector(n, 2.0), random.vector(n, 1.0));
        let a = evaluated(&derivation.inertia_matrix(base), &[&q, x_base]);
        let inverse = evaluated(&derivation.inverse_inertia_matrix(base), &[&q, x_base]);
        let transposed: Vec<f64> = (0..n * n).map(|k| inverse[k % n * n + k / n]).collect();
        agree("inverse symmetric", robot, &inverse, &transposed, 0.0);
        let product: Vec<f64> = (0..n).flat_map(|r| times(&transposed, &a[r * n..][..n])).collect();
        let one: Vec<f64> = (0..n * n).map(|k| f64::from(u8::from(k / n == k % n))).collect();
        // The tolerance allows for the condition number of the inertia matrix A, up to 1e4 here.
        agree("A times its inverse", robot, &product, &one, 1e-9);

        let forward = derivation.forward_dynamics(base);
        let bias = evaluated(&derivation.bias(base), &[&q, &dq, x_base]);
        let tau: Vec<f64> = bias.iter().zip(times(&a, &random.vector(n, 2.0))).map(|(h, m)| h + m).collect();
        let found = evaluated(&derivation.forward_dynamics_derivatives(base), &[&q, &dq, &tau, x_base]);
        let inputs: [&[f64]; 4] = [&q, &dq, &tau, x_base];
        for (k, by) in [0, 1, 2].into_iter().enumerate() {
            let expected = by_duals(&forward, &inputs, by);
            agree(&format!("ddq by input {by}"), robot, &found[k * n * n..][..n * n], &expected, 1e-9);
        }
    }
}

#[test]
fn slotine_li_regressor_is_the_regressor_at_its_own_rates_and_makes_a_c_and_g() {
    let mut random = Random(8);
    for Case { robot, base, x_base, .. } in &cases() {
        let mut derivation = Derivation::new(robot).unwrap();
        let n = robot.n_coordinates();
        let (q, dq) = (random.vector(n, 2.0), random.vector(n, 2.0));
        let (dq_r, ddq_r) = (random.vector(n, 2.0), random.vector(n, 2.0));
        let standard = derivation.regressor();
        let y = derivation.slotine_li_regressor(base);
        let regressor = evaluated(&base.regressor(&standard), &[&q, &dq, &ddq_r]);
        agree("Y at dq_r = dq", robot, &evaluated(&y, &[&q, &dq, &dq, &ddq_r]), &regressor, ROUNDING);

        let tau = times(&evaluated(&y, &[&q, &dq, &dq_r, &ddq_r]), x_base);
        let a = evaluated(&derivation.inertia_matrix(base), &[&q, x_base]);
        let c = evaluated(&derivation.coriolis_matrix(base), &[&q, &dq, x_base]);
        let g = evaluated(&derivation.gravity(base), &[&q, x_base]);
        let (a, c) = (times(&a, &ddq_r), times(&c, &dq_r));
        let expected: Vec<f64> = (0..n).map(|k| a[k] + c[k] + g[k]).collect();
        agree("Y X", robot, &tau, &expected, ROUNDING);
    }
}

#[test]
fn momentum_is_a_dq_and_its_rate_is_the_torque_with_c_transposed() {
    let mut random = Random(9);
    for Case { robot, base, x_base, .. } in &cases() {
        let mut derivation = Derivation::new(robot).unwrap();
        let n = robot.n_coordinates();
        let (q, dq, ddq) = (random.vector(n, 2.0), random.vector(n, 2.0), random.vector(n, 2.0));
        let momentum = derivation.momentum(base);
        let p = evaluated(&momentum, &[&q, &dq, x_base]);
        let a = evaluated(&derivation.inertia_matrix(base), &[&q, x_base]);
        agree("A dq", robot, &p, &times(&a, &dq), ROUNDING);
        let y = evaluated(&derivation.momentum_regressor(base), &[&q, &dq]);
        agree("y X", robot, &times(&y, x_base), &p, ROUNDING);

        // The time derivative of the generalised momentum p = A dq along the motion. A: inertia matrix.
        let by_q = times(&by_duals(&momentum, &[&q, &dq, x_base], 0), &dq);
        let by_dq = times(&by_duals(&momentum, &[&q, &dq, x_base], 1), &ddq);
        let rate: Vec<f64> = by_q.iter().zip(by_dq).map(|(a, b)| a + b).collect();
        let tau = evaluated(&derivation.inverse_dynamics(base), &[&q, &dq, &ddq, x_base]);
        let c = evaluated(&derivation.coriolis_matrix(base), &[&q, &dq, x_base]);
        let transposed: Vec<f64> = (0..n * n).map(|k| c[k % n * n + k / n]).collect();
        let (c, g) = (times(&transposed, &dq), evaluated(&derivation.gravity(base), &[&q, x_base]));
        let expected: Vec<f64> = (0..n).map(|k| tau[k] + c[k] - g[k]).collect();
        agree("dp/dt", robot, &rate, &expected, ROUNDING);
        let both = evaluated(&derivation.momentum_and_rate(base), &[&q, &dq, x_base]);
        agree("p", robot, &both[..n], &p, ROUNDING);
        let b: Vec<f64> = (0..n).map(|k| c[k] - g[k]).collect();
        agree("b = C^T dq - g", robot, &both[n..], &b, ROUNDING);
    }
}

/// A load on a link changes the standard parameters of this link, so the momentum and b change by the load's columns times its
/// parameters. For the frame of a URDF, the parameters are first transformed to the frame of the link.
#[test]
fn the_momentum_of_a_load_is_that_of_its_link_with_the_load() {
    let mut random = Random(15);
    for Case { robot, base, .. } in &cases() {
        let mut derivation = Derivation::new(robot).unwrap();
        let (n, last) = (robot.n_coordinates(), LinkId(robot.links.len() - 1));
        let (q, dq) = (random.vector(n, 2.0), random.vector(n, 2.0));
        let own = random.physical_parameters(robot);
        let frames = robot.link(last).frames.iter().map(|(name, _)| modeling::LinkFrame::named(robot, name).unwrap());
        for frame in std::iter::once(last.into()).chain(frames) {
            let load: [f64; 10] = std::array::from_fn(|_| random.vector(1, 1.0)[0]);
            let at_link = robot::transform_inertial(&load, &frame.pose);
            let first = StandardParameter::all(robot).iter().position(|s| s.link == last).unwrap();
            let mut loaded = own.clone();
            loaded[first..first + 10].iter_mut().zip(at_link).for_each(|(x, load)| *x += load);
            let function = derivation.momentum_and_rate(base);
            let of = |x: &[f64]| evaluated(&function, &[&q, &dq, &base.values(x)]);
            let expected: Vec<f64> = of(&loaded).iter().zip(of(&own)).map(|(with, without)| with - without).collect();
            let found = times(&evaluated(&derivation.load_momentum(frame), &[&q, &dq]), &load);
            agree("load", robot, &found, &expected, ROUNDING);
        }
    }
}

#[test]
fn centre_of_mass_and_momentum_about_it() {
    let mut random = Random(10);
    for Case { robot, x, .. } in &cases() {
        let mut derivation = Derivation::new(robot).unwrap();
        let n = robot.n_coordinates();
        let (q, dq) = (random.vector(n, 2.0), random.vector(n, 2.0));
        let centre = derivation.centre_of_mass();
        let found = evaluated(&centre, &[&q, x]);
        let j = by_duals(&centre, &[&q, x], 0);
        agree("Jacobian of the centre", robot, &found[3..], &j, ROUNDING);

        let momentum = evaluated(&derivation.centroidal_momentum(), &[&q, &dq, x]);
        agree("h = map dq", robot, &momentum[..6], &times(&momentum[6..], &dq), ROUNDING);
        // Mass, first moment, linear and angular momentum about the origin of the base, summed over the links.
        let (mut mass, mut first, mut linear, mut angular) = (0.0, [0.0; 3], [0.0; 3], [0.0; 3]);
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [0, 1, 2].map(|i: usize| {
                let (k, l) = ((i + 1) % 3, (i + 2) % 3);
                a[k] * b[l] - a[l] * b[k]
            })
        };
        let poses = robot.link_poses(&q);
        let mut rest = &x[..];
        for (k, link) in robot.links.iter().enumerate().skip(robot.massless) {
            let [xx, xy, xz, yy, yz, zz, mx, my, mz, m] = std::array::from_fn(|i| rest[i]);
            rest = &rest[10 + usize::from(link.joint.rotor_inertia.is_modelled())..];
            let t = evaluated(&derivation.velocity(LinkId(k), None), &[&q, &dq]);
            let (v, w): ([f64; 3], [f64; 3]) = ([t[0], t[1], t[2]], [t[3], t[4], t[5]]);
            let s = [mx, my, mz];
            let turn =
                |v: [f64; 3]| [0, 1, 2].map(|r: usize| (0..3).map(|c| poses[k].rotation[r][c] * v[c]).sum::<f64>());
            let (wxs, sxv) = (cross(w, s), cross(s, v));
            let h = turn([0, 1, 2].map(|i| m * v[i] + wxs[i]));
            let jw = [
                xx * w[0] + xy * w[1] + xz * w[2],
                xy * w[0] + yy * w[1] + yz * w[2],
                xz * w[0] + yz * w[1] + zz * w[2],
            ];
            let l = turn([0, 1, 2].map(|i| jw[i] + sxv[i]));
            let (p, s) = (poses[k].position, turn(s));
            let lever = cross(p, h);
            mass += m;
            for i in 0..3 {
                first[i] += m * p[i] + s[i];
                linear[i] += h[i];
                angular[i] += l[i] + lever[i];
            }
        }
        let c = first.map(|s| s / mass);
        agree("centre", robot, &found[..3], &c, ROUNDING);
        let lever = cross(c, linear);
        let about = [0, 1, 2].map(|i| angular[i] - lever[i]);
        agree("momentum", robot, &momentum[..6], &[linear, about].concat(), ROUNDING);
    }
}

#[test]
fn frames_move_as_their_jacobians_say() {
    let mut random = Random(11);
    for Case { robot, .. } in &cases() {
        let mut derivation = Derivation::new(robot).unwrap();
        let n = robot.n_coordinates();
        let (q, dq, ddq) = (random.vector(n, 2.0), random.vector(n, 2.0), random.vector(n, 2.0));
        let last = LinkId(robot.links.len() - 1);
        let other = LinkId(robot.links.len() / 2);
        let point = random.vector(3, 0.5);
        for reference in [ReferenceFrame::Base, ReferenceFrame::Link(other.into())] {
            let jacobian = derivation.jacobian_in(last, &reference);
            let j = evaluated(&jacobian, &[&q]);
            let v = evaluated(&derivation.velocity(last, Some(&reference)), &[&q, &dq]);
            agree("J dq", robot, &times(&j, &dq), &v, ROUNDING);
            let a = evaluated(&derivation.acceleration(last, Some(&reference)), &[&q, &dq, &ddq]);
            let rest = evaluated(&derivation.jacobian_rate(last, Some(&reference)), &[&q, &dq]);
            let expected: Vec<f64> = times(&j, &ddq).iter().zip(&rest).map(|(a, b)| a + b).collect();
            agree("J ddq + dJ/dt dq", robot, &a, &expected, ROUNDING);
            if reference == ReferenceFrame::Base {
                let rate = times(&by_duals(&jacobian, &[&q], 0), &dq);
                agree("dJ/dt dq", robot, &times(&rate, &dq), &rest, ROUNDING);
                // The derivative of the position along dq equals the linear velocity.
                let pose = derivation.pose(last);
                let moved = times(&by_duals(&pose, &[&q], 0), &dq);
                agree("velocity of the pose", robot, &[moved[3], moved[7], moved[11]], &v[..3], ROUNDING);
            }
            // A point p that is fixed in the frame has the velocity v + w x p. v, w: velocity and angular velocity of the frame.
            let of_point = evaluated(&derivation.point_jacobian(last, Some(&reference)), &[&q, &point]);
            let t = evaluated(&derivation.pose_in(last, &reference), &[&q]);
            let p = [0, 1, 2].map(|r| (0..3).map(|c| t[4 * r + c] * point[c]).sum::<f64>());
            let lever = [v[4] * p[2] - v[5] * p[1], v[5] * p[0] - v[3] * p[2], v[3] * p[1] - v[4] * p[0]];
            let expected: Vec<f64> = (0..3).map(|i| v[i] + lever[i]).chain(v[3..].iter().copied()).collect();
            agree("a point's velocity", robot, &times(&of_point, &dq), &expected, ROUNDING);
        }
        // Pose of the last frame relative to link `other`. Expected: the combination of the poses of both in the base frame.
        let reference = ReferenceFrame::Link(other.into());
        let t = evaluated(&derivation.pose_in(last, &reference), &[&q]);
        let poses = robot.link_poses(&q);
        let expected = poses[other.0].inverse().compose(&poses[last.0]);
        let rows: Vec<f64> =
            (0..3).flat_map(|r| expected.rotation[r].into_iter().chain([expected.position[r]])).collect();
        agree("pose in another frame", robot, &t, &rows, ROUNDING);
    }
}

#[test]
fn determinant_of_the_jacobian_at_ten_thousand_poses() {
    for Case { robot, .. } in cases().iter().filter(|c| c.robot.n_coordinates() == 6) {
        let mut random = Random(12);
        let mut derivation = Derivation::new(robot).unwrap();
        let last = LinkId(robot.links.len() - 1);
        let tapes = [formulas::jacobian_determinant(&mut derivation, last), derivation.jacobian(last)]
            .map(|f| Tape::new(&f.bound()));
        let mut works = tapes.each_ref().map(Tape::workspace);
        for _ in 0..10_000 {
            let q = random.vector(6, 3.0);
            let (mut det, mut j) = ([0.0], [0.0; 36]);
            tapes[0].evaluate(&q, &mut works[0], &mut det);
            tapes[1].evaluate(&q, &mut works[1], &mut j);
            let expected = nalgebra::DMatrix::from_row_slice(6, 6, &j).determinant();
            agree("det J", robot, &det, &[expected], ROUNDING);
        }
    }
}

#[test]
fn loops_that_are_solved_numerically_keep_the_laws() {
    let mut random = Random(13);
    for robot in ["slider_crank", "watt", "three_rpr"].map(loops::with_loops) {
        let mut derivation = Derivation::new(&robot).unwrap();
        let n = robot.n_coordinates();
        let base = base_parameters(&robot);
        let x_base = base.values(&random.physical_parameters(&robot));
        let mut closure = derivation.closure().unwrap();
        let (q, passive) = closure.find_origin(n).unwrap();
        let (dq, dq_r, ddq) = (random.vector(n, 1.0), random.vector(n, 1.0), random.vector(n, 1.0));
        let c = evaluated(&derivation.coriolis_matrix(&base), &[&q, &passive, &dq, &x_base]);
        let bias = evaluated(&derivation.bias(&base), &[&q, &passive, &dq, &x_base]);
        let g = evaluated(&derivation.gravity(&base), &[&q, &passive, &x_base]);
        let rest: Vec<f64> = bias.iter().zip(&g).map(|(h, g)| h - g).collect();
        agree("C dq", &robot, &times(&c, &dq), &rest, 1e-9);
        let a = evaluated(&derivation.inertia_matrix(&base), &[&q, &passive, &x_base]);
        let y = evaluated(&derivation.slotine_li_regressor(&base), &[&q, &passive, &dq, &dq_r, &ddq]);
        let (at, ct) = (times(&a, &ddq), times(&c, &dq_r));
        let expected: Vec<f64> = (0..n).map(|k| at[k] + ct[k] + g[k]).collect();
        agree("Y X", &robot, &times(&y, &x_base), &expected, 1e-9);
        let p = evaluated(&derivation.momentum(&base), &[&q, &passive, &dq, &x_base]);
        agree("A dq", &robot, &p, &times(&a, &dq), 1e-9);
        // The Coriolis matrix of the reduced coordinates is also Christoffel's. So b = C^T dq - g holds as for a robot without
        // loops.
        let both = evaluated(&derivation.momentum_and_rate(&base), &[&q, &passive, &dq, &x_base]);
        let transposed: Vec<f64> = (0..n * n).map(|k| c[k % n * n + k / n]).collect();
        let b: Vec<f64> = times(&transposed, &dq).iter().zip(&g).map(|(c, g)| c - g).collect();
        agree("p", &robot, &both[..n], &p, 1e-9);
        agree("b", &robot, &both[n..], &b, 1e-9);
    }
}

/// In forward dynamics of a tree, the branches are independent in the factorisation of the inertia matrix. So each further branch
/// costs about the same number of operations.
#[test]
fn each_branch_of_a_tree_adds_the_same_to_its_forward_dynamics() {
    let cost = |branches: usize| {
        let mut text = String::from(
            "convention: khalil-kleinfinger\nname: star\nlinks:\n  - {link: 1, antecedent: base, theta: q1}\n",
        );
        for k in (0..branches).map(|b| 2 + 3 * b) {
            let hung = [(k, 1, 0.1 + 0.01 * k as f64), (k + 1, k, 0.3), (k + 2, k + 1, 0.2)];
            for (j, before, d) in hung {
                text += &format!("  - {{link: {j}, antecedent: {before}, alpha: pi/2, d: {d}, theta: q{j}}}\n");
            }
        }
        let robot = robot::format::read_yaml(&text, "star.yaml").unwrap();
        let mut derivation = Derivation::new(&robot).unwrap();
        let base = base_parameters(&robot);
        let count = derivation.forward_dynamics(&base).bound().count();
        count.mul + count.add
    };
    let [one, two, three, four] = [1, 2, 3, 4].map(cost);
    // Each further branch costs a few more operations, because the base parameters of the trunk include terms of all branches.
    assert!(10 * (four - three) < 11 * (two - one), "{one} {two} {three} {four}");
}

/// Compares with the number of operations of casadi's Jacobian of the torques by q and dq, after elimination of common
/// subexpressions: UR5 4340, Panda 6811.
#[test]
fn derivatives_cost_less_than_half_of_automatic_differentiation() {
    for (file, casadi) in [("ur5.urdf", 4340), ("panda.yaml", 6811)] {
        let mut robot = tests::model(file);
        robot.links.iter_mut().for_each(|link| link.joint.rotor_inertia = robot::RotorInertia::Absent);
        let mut derivation = Derivation::new(&robot).unwrap();
        let base = base_parameters(&robot);
        let count = derivation.inverse_dynamics_derivatives(&base).bound().count();
        println!("{file}: {count:?}");
        assert!(2 * (count.mul + count.add) < casadi, "{file}: {count:?}");
    }
}
