//! Tests of laws of mechanics. The derived torque equals the torque by Newton-Euler and by Lagrange. The inertia matrix is
//! symmetric and positive definite. The torque does not depend on the order of links in the file, on the unit of length or on the
//! orientation of the base.

use expr::{Tape, Workspace};
use modeling::{BaseParameters, Derivation};
use nalgebra::{DMatrix, DVector};
use robot::{
    Affine, Drive, Inertial, JointKind, LinkId, ModifiedDh, Robot, RotorInertia, StandardParameter, Symbol, SymbolId,
    Value,
};
use tests::random::{Random, State};
use tests::{base_parameters as base, dot, lagrangian, model_text, models, recursion, standard_names};

/// Tolerance between two summations of the same terms, relative to the sum of their magnitudes: some thousand
/// operations of 1e-16 each, which mostly cancel.
const ROUNDING: f64 = 1e-13;

fn derived(robot: &Robot) -> Derivation<'_> {
    Derivation::new(robot).unwrap_or_else(|open| panic!("{}: {open}", robot.name))
}

/// The standard regressor D, as a tape (list of operations) with its workspace; n rows and p columns.
struct Regressor {
    tape: Tape,
    work: Workspace,
    n: usize,
    p: usize,
}

impl Regressor {
    fn new(robot: &Robot) -> Regressor {
        let tape = Tape::new(&derived(robot).regressor());
        let work = tape.workspace();
        Regressor { tape, work, n: robot.n_coordinates(), p: StandardParameter::all(robot).len() }
    }

    /// The rows of the regressor D at a state, one per joint.
    fn rows(&mut self, state: &State) -> Vec<Vec<f64>> {
        let mut y = vec![f64::NAN; self.n * self.p];
        self.tape.evaluate(&state.inputs(), &mut self.work, &mut y);
        y.chunks(self.p).map(<[f64]>::to_vec).collect()
    }

    /// The torques D X; and, for each row, the sum of the magnitudes of its terms. D: regressor, X: parameters.
    fn times(&mut self, state: &State, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        self.rows(state).iter().map(|row| dot(row, x)).unzip()
    }

    fn inertia_matrix(&mut self, q: &[f64], x: &[f64]) -> DMatrix<f64> {
        let n = self.n;
        let still = |k: Option<usize>| {
            let ddq = (0..n).map(|i| if Some(i) == k { 1.0 } else { 0.0 }).collect();
            State { q: q.to_vec(), dq: vec![0.0; n], ddq }
        };
        let weight = self.times(&still(None), x).0;
        let columns: Vec<Vec<f64>> = (0..n).map(|k| self.times(&still(Some(k)), x).0).collect();
        DMatrix::from_fn(n, n, |i, k| columns[k][i] - weight[i])
    }
}

fn close(found: &[f64], expected: &[f64], size: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for i in 0..found.len() {
        let off = (found[i] - expected[i]).abs();
        assert!(off <= tolerance * (1.0 + size[i]), "{what}, row {i}: {} {}", found[i], expected[i]);
    }
}

#[test]
fn regressor_times_parameters_is_the_torque_of_newton_and_euler_and_of_lagrange() {
    // Tested are all models, and a robot with two loops whose cut frames are on the same link.
    let file = "two_loops_on_one_frame.par";
    let on_frames = robot::format::read(&tests::test_robot_path(file)).unwrap_or_else(|e| panic!("{e}"));
    for (file, robot) in models().into_iter().chain([(file.to_string(), on_frames)]) {
        let mut random = Random(1);
        let mut regressor = Regressor::new(&robot);
        let torque = Tape::new(&derived(&robot).torque());
        let mut work = torque.workspace();
        for _ in 0..8 {
            let (state, x) = (random.state(&robot), random.parameters(&robot));
            let (tau, size) = regressor.times(&state, &x);
            close(&tau, &recursion::torque(&robot, &state, &x), &size, ROUNDING, &format!("{file}: recursion"));
            close(&tau, &lagrangian::torque(&robot, &state, &x), &size, ROUNDING, &format!("{file}: Lagrangian"));
            let mut directly = vec![f64::NAN; tau.len()];
            torque.evaluate(&[state.inputs(), x].concat(), &mut work, &mut directly);
            close(&tau, &directly, &size, ROUNDING, &format!("{file}: Derivation::torque"));
        }
    }
}

#[test]
fn inertia_matrix_is_symmetric_and_positive_definite_for_physical_parameters() {
    for (file, robot) in models() {
        let mut random = Random(2);
        let mut regressor = Regressor::new(&robot);
        for _ in 0..8 {
            let (state, x) = (random.state(&robot), random.physical_parameters(&robot));
            let m = regressor.inertia_matrix(&state.q, &x);
            assert!((&m - m.transpose()).norm() <= ROUNDING * m.norm(), "{file}: {m}");
            assert!(m.clone().cholesky().is_some(), "{file}: {m}");
            // M must also be the inertia matrix in the kinetic energy T: dq . M dq = 2 T.
            let lift = |v: &[f64]| v.iter().map(|&x| tests::number::Number::constant(x)).collect::<Vec<_>>();
            let kinetic = lagrangian::energies(&robot, &lift(&state.q), &lift(&state.dq), &x).0.value;
            let dq = DVector::from_row_slice(&state.dq);
            assert!((dq.dot(&(&m * &dq)) - 2.0 * kinetic).abs() <= 1e-12 * kinetic, "{file}");
        }
    }
}

#[test]
fn power_of_the_torques_is_the_rate_of_the_energy() {
    for (file, robot) in models() {
        let mut random = Random(4);
        let mut regressor = Regressor::new(&robot);
        for _ in 0..8 {
            let (state, x) = (random.state(&robot), random.parameters(&robot));
            let (tau, size) = regressor.times(&state, &x);
            let power = dot(&tau, &state.dq).0;
            let scale = 1.0 + dot(&size, &state.dq).1;
            let expected = lagrangian::power(&robot, &state, &x);
            assert!((power - expected).abs() <= ROUNDING * scale, "{file}: {power} {expected}");
        }
    }
}

fn read(text: &str) -> Robot {
    robot::format::read_yaml(text, "edited.yaml").unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn order_of_the_links_in_the_file_changes_no_torque_and_no_rank() {
    // Random orders of the links in which each parent comes before its children.
    for file in ["race.yaml", "tree.yaml"] {
        let text = model_text(file);
        let robot = read(&text);
        let (before, rest) = text.split_once("links:\n").unwrap();
        let n_lines = robot.links.len();
        let lines: Vec<&str> = rest.split_inclusive('\n').take(n_lines).collect();
        let after: String = rest.split_inclusive('\n').skip(n_lines).collect();
        // The order of the coordinates is fixed here; by default it follows the order of the links.
        let coordinates: Vec<&str> = robot.coordinates.iter().map(|c| c.name.as_str()).collect();
        let stated = if before.contains("coordinates:") {
            before.to_string()
        } else {
            format!("{before}coordinates: [{}]\n", coordinates.join(", "))
        };
        let mut random = Random(5);
        let mut seen_another_order = false;
        for _ in 0..5 {
            let mut order: Vec<usize> = Vec::new();
            while order.len() < n_lines {
                let ready: Vec<usize> = (0..n_lines)
                    .filter(|j| !order.contains(j) && robot.links[*j].antecedent.is_none_or(|i| order.contains(&i.0)))
                    .collect();
                order.push(ready[random.below(ready.len())]);
            }
            seen_another_order |= !order.is_sorted();
            let shuffled: String = order.iter().map(|&j| lines[j]).collect();
            let other = read(&format!("{stated}links:\n{shuffled}{after}"));
            let (names, other_names) = (standard_names(&robot), standard_names(&other));
            let (mut d, mut other_d) = (Regressor::new(&robot), Regressor::new(&other));
            for _ in 0..4 {
                let (state, x) = (random.state(&robot), random.parameters(&robot));
                let place = |name: &String| names.iter().position(|n| n == name).unwrap();
                let other_x: Vec<f64> = other_names.iter().map(|name| x[place(name)]).collect();
                let (tau, size) = d.times(&state, &x);
                close(&other_d.times(&state, &other_x).0, &tau, &size, ROUNDING, file);
            }
            assert_eq!(base(&other).len(), base(&robot).len(), "{file} {order:?}");
        }
        assert!(seen_another_order, "{file}: no order but its own was tried");
    }
}

#[test]
fn unit_of_length_changes_no_torque_and_no_rank() {
    // The unit of length is changed from metres to decimetres: the numbers of all lengths and of gravity are multiplied by ten.
    let factor = 10.0;
    for (file, robot) in models() {
        let mut other = robot.clone();
        let scaled = |v: &Value| match v {
            v if v.number(&robot.symbols) == 0.0 => v.clone(),
            v => Value::Mul(Box::new(Value::Number(factor)), Box::new(v.clone())),
        };
        let lengths = |g: &mut ModifiedDh| (g.b, g.d, g.r) = (scaled(&g.b), scaled(&g.d), scaled(&g.r));
        for link in &mut other.links {
            lengths(&mut link.geometry);
            assert!(link.joint.kind != JointKind::Prismatic || link.joint.variable.offset == Value::ZERO);
        }
        for one in &mut other.loops {
            lengths(&mut one.cut.geometry);
            lengths(&mut one.twin.geometry);
        }
        other.gravity = [0, 1, 2].map(|i| scaled(&other.gravity[i]));

        let prismatic: Vec<bool> = (0..robot.n_coordinates())
            .map(|k| {
                let moved = |l: &robot::Link| l.joint.variable.terms.iter().any(|t| t.0.0 == k);
                robot.links.iter().any(|l| moved(l) && l.joint.kind == JointKind::Prismatic)
            })
            .collect();
        let unit = |k: usize| if prismatic[k] { factor } else { 1.0 };
        let mut random = Random(6);
        let (mut d, mut other_d) = (Regressor::new(&robot), Regressor::new(&other));
        for _ in 0..4 {
            let (state, x) = (random.state(&robot), random.parameters(&robot));
            let each = |v: &[f64]| (0..v.len()).map(|k| v[k] * unit(k)).collect();
            let other_state = State { q: each(&state.q), dq: each(&state.dq), ddq: each(&state.ddq) };
            let other_x: Vec<f64> = StandardParameter::all(&robot)
                .iter()
                .zip(&x)
                .map(|(parameter, x)| match parameter.inertial {
                    Inertial::M => *x,
                    inertial if inertial.is_first_moment() => x * factor,
                    Inertial::Ia if robot.link(parameter.link).joint.kind == JointKind::Prismatic => *x,
                    _ => x * factor * factor,
                })
                .collect();
            let (tau, size) = d.times(&state, &x);
            // A torque has the unit mass times length squared per time squared, a force mass times length per time squared. So
            // they are converted with different factors.
            let found = other_d.times(&other_state, &other_x).0;
            let found: Vec<f64> = (0..found.len()).map(|k| found[k] * unit(k) / (factor * factor)).collect();
            close(&found, &tau, &size, ROUNDING, &file);
        }
        let (one, two) = (base(&robot), base(&other));
        let kept = |b: &BaseParameters| b.base.iter().map(|b| b.column).collect::<Vec<_>>();
        assert_eq!(kept(&one), kept(&two), "{file}");
        assert_eq!(one.no_effect, two.no_effect, "{file}");
    }
}

fn product(a: &Value, b: Value) -> Value {
    Value::Mul(Box::new(a.clone()), Box::new(b))
}

/// The pair (x, y) rotated by the angle: (c x - s y, s x + c y). s, c: sine and cosine of the angle.
fn turned_pair(x: &Value, y: &Value, angle: &Value) -> [Value; 2] {
    let (sin, cos) = (Value::Sin(Box::new(angle.clone())), Value::Cos(Box::new(angle.clone())));
    let [cx, sy, sx, cy] =
        [product(x, cos.clone()), product(y, sin.clone()), product(x, sin), product(y, cos)].map(Box::new);
    [Value::Sub(cx, sy), Value::Add(sx, cy)]
}

/// The vector v rotated about z: Rz(angle) v.
fn turned_about_z([x, y, z]: [Value; 3], angle: &Value) -> [Value; 3] {
    let [x, y] = turned_pair(&x, &y, angle);
    [x, y, z]
}

/// The vector v rotated about x: Rx(angle) v.
fn turned_about_x([x, y, z]: [Value; 3], angle: &Value) -> [Value; 3] {
    let [y, z] = turned_pair(&y, &z, angle);
    [x, y, z]
}

#[test]
fn turning_the_robot_and_gravity_together_changes_no_torque_and_no_rank() {
    for (file, robot) in models() {
        let mut random = Random(7);
        let mut turned = robot.clone();
        let [phi, theta, psi] = [0.4, 1.1, -2.3].map(|a: f64| a + 0.1 * random.unit());
        // The pedestal is a fixed link with a general orientation in the base, Rz(phi) Rx(theta) Rz(psi). Its angles are symbols,
        // and gravity is written with them. So gravity keeps its direction relative to the robot for all values of the symbols.
        // The exact rank must not treat this as a coincidence of numbers.
        let mut pedestal = robot.links[0].clone();
        let angles = [("phi_", phi), ("theta_", theta), ("psi_", psi)].map(|(name, x)| {
            turned.symbols.push(Symbol { name: name.into(), value: Value::Number(x), generic: false });
            Value::Symbol(SymbolId(turned.symbols.len() - 1))
        });
        let gravity = turned_about_x(turned_about_z(robot.gravity.clone(), &angles[2]), &angles[1]);
        turned.gravity = turned_about_z(gravity, &angles[0]);
        let [gamma, alpha, theta_value] = angles;
        pedestal.antecedent = None;
        pedestal.name = "pedestal".into();
        pedestal.label = "0".into();
        pedestal.geometry = ModifiedDh { gamma, alpha, theta: theta_value, ..ModifiedDh::ZERO };
        pedestal.joint.kind = JointKind::Fixed;
        pedestal.joint.drive = Drive::Locked;
        pedestal.joint.variable = Affine::constant(Value::ZERO);
        pedestal.joint.rotor_inertia = RotorInertia::Absent;
        pedestal.inertial = None;
        pedestal.parts.clear();
        for link in &mut turned.links {
            link.antecedent = Some(link.antecedent.map_or(LinkId(0), |i| LinkId(i.0 + 1)));
        }
        for one in &mut turned.loops {
            for frame in [&mut one.cut, &mut one.twin] {
                frame.antecedent = Some(frame.antecedent.map_or(LinkId(0), |i| LinkId(i.0 + 1)));
            }
        }
        turned.links.insert(0, pedestal);
        let (mut d, mut turned_d) = (Regressor::new(&robot), Regressor::new(&turned));
        for _ in 0..4 {
            let (state, x) = (random.state(&robot), random.parameters(&robot));
            let (tau, size) = d.times(&state, &x);
            let of_pedestal = random.vector(10, 1.0);
            let found = turned_d.times(&state, &[of_pedestal, x].concat()).0;
            close(&found, &tau, &size, ROUNDING, &file);
        }
        let (one, two) = (base(&robot), base(&turned));
        let kept = |b: &BaseParameters, shift: usize| b.base.iter().map(|b| b.column - shift).collect::<Vec<_>>();
        assert_eq!(kept(&one, 0), kept(&two, 10), "{file}");
        assert_eq!(two.no_effect.len(), one.no_effect.len() + 10, "{file}");
    }
}
