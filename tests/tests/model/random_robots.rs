//! Tests on random robots: regressor, torque, base parameters and rank agree with an independent recursion.
//!
//! The robots are chains and trees of up to six links. Joints are revolute or prismatic; some follow other coordinates (mimic) or
//! are locked. Angles and lengths are of four kinds (`Numbers`). The seeds are fixed, so a failing robot can be reproduced.

use expr::Function;
use modeling::{BaseParameters, Derivation};
use nalgebra::DMatrix;
use robot::{Robot, format};
use tests::random::{Random, State};
use tests::random_structures::rank_of;
use tests::{dot, evaluated, recursion};

/// Tolerance between two summations of the same terms, relative to their magnitudes: some ten thousand operations of 1e-16
/// each, most of which cancel.
const ROUNDING: f64 = 1e-12;

/// Upper bound for the number of operations of a base regressor, divided by the square of the number of links. These robots need
/// at most 37.
const OPERATIONS: usize = 60;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Numbers {
    Right,
    /// Angles that are multiples of pi/6, and a single length. These are other special geometries than right angles.
    Special,
    General,
    /// Nearly right angles and nearly coinciding axes.
    Nearly,
}

impl Numbers {
    fn angle(self, random: &mut Random) -> String {
        let right = ["0", "pi/2", "-pi/2", "pi"][random.below(4)];
        match self {
            Numbers::Right => right.into(),
            Numbers::Special => format!("{}*pi/6", random.below(12)),
            Numbers::General => format!("{:.3}", 3.0 * random.unit()),
            Numbers::Nearly => format!("{right} + {:e}", random.unit() * 10f64.powi(-3 - random.below(10) as i32)),
        }
    }

    fn length(self, random: &mut Random) -> String {
        match self {
            Numbers::Right => ["0".into(), format!("{:.2}", random.unit())][random.below(2)].clone(),
            Numbers::Special => ["0", "0.25", "0.25"][random.below(3)].into(),
            Numbers::General => format!("{:.3}", random.unit()),
            Numbers::Nearly => format!("{:e}", random.unit() * 10f64.powi(-(random.below(11) as i32))),
        }
    }
}

/// A robot file in YAML. The first joint is a coordinate; the others are coordinates, mimic joints or locked joints.
fn description(seed: u64, numbers: Numbers) -> String {
    let random = &mut Random(seed);
    let (n, is_tree) = (1 + random.below(6), random.below(2) == 0);
    let mut text = format!("convention: khalil-kleinfinger\nname: seed {seed}\ngravity: [1.2, -3.4, -9.1]\nlinks:\n");
    let mut coordinates: Vec<usize> = Vec::new();
    for j in 1..=n {
        let antecedent = if is_tree { random.below(j) } else { j - 1 };
        let antecedent = if antecedent == 0 { "base".into() } else { antecedent.to_string() };
        let [gamma, b] = match random.below(3) {
            0 => [numbers.angle(random), numbers.length(random)],
            _ => ["0".into(), "0".into()],
        };
        let (alpha, d) = (numbers.angle(random), numbers.length(random));
        let (angle, length) = (numbers.angle(random), numbers.length(random));
        let kind = if coordinates.is_empty() { random.below(2) } else { random.below(8) };
        let joint = match kind {
            1..=2 => format!("joint: prismatic, theta: {angle}, r: q{j}"),
            3 => {
                let [one, other] = [0, 1].map(|_| coordinates[random.below(coordinates.len())]);
                format!("drive: passive, theta: 2*q{one} - q{other} + 0.3, r: {length}")
            }
            4 => format!("drive: locked, theta: {angle}, r: {length}"),
            _ => format!("theta: q{j}, r: {length}"),
        };
        if !joint.starts_with("drive") {
            coordinates.push(j);
        }
        text += &format!(
            "  - {{link: {j}, antecedent: {antecedent}, gamma: {gamma}, b: {b}, alpha: {alpha}, d: {d}, {joint}}}\n"
        );
    }
    text
}

struct Derived {
    regressor: Function,
    torque: Function,
    /// The base parameters, or an error text if the rank is unclear.
    base: Result<BaseParameters, String>,
}

fn derived(robot: &Robot, what: &str) -> Derived {
    let mut derivation = Derivation::new(robot).unwrap_or_else(|open| panic!("{what}: {open}"));
    let regressor = derivation.regressor();
    let base = derivation.base_parameters(&regressor).map_err(|unclear| unclear.to_string());
    Derived { torque: derivation.torque(), regressor, base }
}

/// The rank of the regressor D over many states, from the singular values of its scaled columns.
fn rank(regressor: &Function, robot: &Robot, random: &mut Random, p: usize) -> usize {
    let n = robot.n_coordinates();
    let rows =
        (0..2 * p / n + 20).flat_map(|_| evaluated(regressor, &[&random.state(robot).inputs()])).collect::<Vec<_>>();
    rank_of(DMatrix::from_row_slice(rows.len() / p, p, &rows)).0
}

fn holds(seed: u64, numbers: Numbers) {
    let text = description(seed, numbers);
    let what = format!("{numbers:?}\n{text}");
    let robot = format::read_yaml(&text, "random.yaml").unwrap_or_else(|e| panic!("{what}: {e}"));
    let Derived { regressor, torque, base } = derived(&robot, &what);
    let random = &mut Random(seed + 1_000_000);
    let n = robot.n_coordinates();
    let p = tests::standard_names(&robot).len();
    let base = match base {
        Ok(base) => {
            assert!(numbers == Numbers::Nearly || base.weak.is_empty(), "{what}");
            Some(base)
        }
        // An unclear rank is allowed only if the geometry is nearly special.
        Err(why) => {
            assert_eq!(numbers, Numbers::Nearly, "{what}{why}");
            None
        }
    };
    let base_regressor = base.as_ref().map(|base| base.regressor(&regressor));
    for _ in 0..3 {
        let (state, x): (State, Vec<f64>) = (random.state(&robot), random.parameters(&robot));
        let tau = recursion::torque(&robot, &state, &x);
        let d = evaluated(&regressor, &[&state.inputs()]);
        let (by_regressor, size): (Vec<f64>, Vec<f64>) = d.chunks(p).map(|row| dot(row, &x)).unzip();
        let directly = evaluated(&torque, &[&state.inputs(), &x]);
        let by_base = base.as_ref().zip(base_regressor.as_ref()).map(|(base, function)| {
            let y = evaluated(function, &[&state.inputs()]);
            let values = base.values(&x);
            (0..n).map(|i| dot(&y[i * values.len()..][..values.len()], &values).0).collect::<Vec<f64>>()
        });
        for k in 0..n {
            let room = ROUNDING * (1.0 + size[k]);
            assert!((by_regressor[k] - tau[k]).abs() <= room, "D X, row {k}: {} {}\n{what}", by_regressor[k], tau[k]);
            assert!((directly[k] - tau[k]).abs() <= room, "torque, row {k}: {} {}\n{what}", directly[k], tau[k]);
            // If a kept column is nearly dependent, the numeric coefficients have an error of at most 1e-9. The bound `left_out`
            // is relative to the norm of a column over some 300 rows. The entries of these rows are about three times larger than
            // here. So the factor is 50.
            let left_out = base.as_ref().map_or(0.0, |base| base.rank.left_out);
            let largest = d[k * p..][..p].iter().fold(0.0, |a: f64, x| a.max(x.abs()));
            let left_out = 50.0 * left_out * largest * x.iter().map(|x| x.abs()).sum::<f64>();
            let room = if numbers == Numbers::Nearly { 1e-9 * (1.0 + size[k]) + left_out } else { room };
            let found = by_base.as_ref().map_or(tau[k], |t| t[k]);
            assert!((found - tau[k]).abs() <= room, "D_base X_base, row {k}: {found} {}\n{what}", tau[k]);
        }
    }
    if let (Some(base), Some(function)) = (base, base_regressor) {
        let count = function.count();
        let links = robot.links.len();
        assert!(count.mul + count.add <= OPERATIONS * links * links, "{} + {}\n{what}", count.mul, count.add);
        if numbers != Numbers::Nearly {
            assert_eq!(base.len(), rank(&regressor, &robot, random, p), "{what}");
        }
    }
}

#[test]
fn what_is_derived_is_what_mechanics_says() {
    for (first, numbers) in
        [(0, Numbers::Right), (100, Numbers::Special), (200, Numbers::General), (300, Numbers::Nearly)]
    {
        (first..first + 50).for_each(|seed| holds(seed, numbers));
    }
}
