//! Tests that compiled code, the tape (a list of operations) and evaluation in plain f64 agree for every robot of the crate
//! `generated`.

use expr::{Function, Tape};
use generated::robots;
use modeling::BaseParameters;
use robot::Robot;
use tests::random::{Random, State};
use tests::running_error::bounded;
use tests::{derived, models};

fn base_regressor(robot: &Robot) -> (BaseParameters, Function) {
    let (_, regressor, base) = derived(robot);
    let function = base.regressor(&regressor).bound();
    (base, function)
}

#[test]
fn every_model_finds_its_compiled_robot_and_no_robot_is_left() {
    let mut found: Vec<&str> = Vec::new();
    for (file, robot) in models() {
        let (base, function) = base_regressor(&robot);
        let compiled = generated::find(function.fingerprint());
        let compiled = compiled.unwrap_or_else(|| panic!("{file}: not compiled; run `cargo xtask gen`"));
        assert_eq!(compiled.name, robot.name, "{file}");
        assert_eq!(compiled.parameters, base.base.iter().map(|b| b.name.as_str()).collect::<Vec<_>>(), "{file}");
        assert_eq!(
            compiled.coordinates,
            robot.coordinates.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(),
            "{file}"
        );
        found.push(compiled.name);
    }
    found.sort();
    let mut all: Vec<&str> = generated::all().iter().map(|c| c.name).collect();
    all.sort();
    assert_eq!(found, all);
    assert!(generated::find(0).is_none());
}

#[test]
fn compiled_code_the_tape_and_plain_f64_agree() {
    for (file, robot) in models() {
        let (_, function) = base_regressor(&robot);
        let compiled = generated::find(function.fingerprint()).unwrap();
        let tape = Tape::new(&function);
        let mut random = Random(21);
        // 70 states: more than one block of SIMD lanes, plus an incomplete block.
        let states: Vec<State> = (0..70).map(|_| random.state(&robot)).collect();
        let inputs: Vec<f64> = states.iter().flat_map(State::inputs).collect();
        let size = tape.n_outputs();
        let mut many = vec![f64::NAN; states.len() * size];
        tape.evaluate_many(&inputs, &mut tape.workspace(), &mut many);
        let mut work = tape.workspace();
        let (mut one, mut y) = (vec![f64::NAN; size], vec![f64::NAN; size]);
        for (state, many) in states.iter().zip(many.chunks(size)) {
            tape.evaluate(&state.inputs(), &mut work, &mut one);
            assert_eq!(one, many, "{file}: the same operations, one sample or many");
            assert!(compiled.fill(&state.q, &state.dq, &state.ddq, &mut y), "{file}");
            let bits = |y: &[f64]| y.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
            assert_eq!(bits(&one), bits(&y), "{file}: the same operations, by tape or compiled");
            for (k, plain) in bounded(&function, &state.inputs()).into_iter().enumerate() {
                let allowed = 2.0 * plain.error;
                assert!((one[k] - plain.value).abs() <= allowed, "{file}, entry {k}: tape {} plain {plain:?}", one[k]);
                assert!((y[k] - plain.value).abs() <= allowed, "{file}, entry {k}: compiled {} plain {plain:?}", y[k]);
            }
        }
    }
}

#[test]
fn wrong_lengths_are_refused_and_nothing_is_written() {
    for compiled in generated::all() {
        let n = compiled.coordinates.len();
        let size = n * compiled.parameters.len();
        let (q, longer) = (vec![0.1; n], vec![0.1; n + 1]);
        let mut y = vec![7.0; size];
        assert!(!compiled.fill(&longer, &q, &q, &mut y) && !compiled.fill(&q, &q[1..], &q, &mut y));
        assert!(!compiled.fill(&q, &q, &longer, &mut y) && !compiled.fill(&q, &q, &q, &mut y[1..]));
        assert!(!compiled.fill(&q, &q, &q, &mut vec![7.0; size + 1]));
        assert!(y.iter().all(|&y| y == 7.0), "{}", compiled.name);
        assert!(compiled.fill(&q, &q, &q, &mut y));
    }
}

/// An f64 number on a processor without fused multiply-add: `mul_add` rounds twice.
#[derive(Clone, Copy)]
struct Unfused(f64);

macro_rules! by_f64 {
    ($($operator:ident $method:ident),*) => {$(
        impl std::ops::$operator for Unfused {
            type Output = Unfused;
            fn $method(self, other: Unfused) -> Unfused {
                Unfused(std::ops::$operator::$method(self.0, other.0))
            }
        }
    )*};
}
by_f64!(Add add, Sub sub, Mul mul);

impl std::ops::Neg for Unfused {
    type Output = Unfused;
    fn neg(self) -> Unfused {
        Unfused(-self.0)
    }
}

macro_rules! unfused {
    ($($module:ident),*) => {$(
        impl robots::$module::Real for Unfused {
            fn from_f64(x: f64) -> Unfused {
                Unfused(x)
            }
            fn mul_add(self, b: Unfused, c: Unfused) -> Unfused {
                self * b + c
            }
            fn sin_cos(self) -> (Unfused, Unfused) {
                let (s, c) = self.0.sin_cos();
                (Unfused(s), Unfused(c))
            }
        }
    )*};
}
unfused!(race, ur5, panda, tree);

/// Compares a generated function without and with fused multiply-add. The difference must be within twice the bound of the
/// rounding error without it.
macro_rules! unfused_is_within_the_bound {
    ($($module:ident: $file:literal),* $(,)?) => {$({
        const N: usize = robots::$module::COORDINATES.len();
        const P: usize = robots::$module::PARAMETERS.len();
        let robot = tests::model($file);
        let (_, function) = base_regressor(&robot);
        let compiled = generated::find(function.fingerprint()).unwrap();
        let mut random = Random(24);
        for _ in 0..20 {
            let state = random.state(&robot);
            let numbers = |v: &[f64]| -> [Unfused; N] { std::array::from_fn(|k| Unfused(v[k])) };
            let mut y = [[Unfused(f64::NAN); P]; N];
            robots::$module::base_regressor(&numbers(&state.q), &numbers(&state.dq), &numbers(&state.ddq), &mut y);
            let mut fused = [f64::NAN; N * P];
            assert!(compiled.fill(&state.q, &state.dq, &state.ddq, &mut fused));
            let inputs = state.inputs();
            for ((y, fused), plain) in y.as_flattened().iter().zip(fused).zip(bounded(&function, &inputs)) {
                // Both results are within the error bound of the exact value, because fusing removes roundings. So they differ by
                // at most twice the bound.
                assert!((y.0 - fused).abs() <= 2.0 * plain.error, "{}: {} {fused} {plain:?}", $file, y.0);
            }
        }
    })*};
}

#[test]
fn without_fusing_the_difference_is_that_of_roundings() {
    unfused_is_within_the_bound!(race: "race.yaml", ur5: "ur5.yaml", panda: "panda.yaml", tree: "tree.yaml");
}

/// Compares the generated code in f32 with an f64 evaluation at the same (f32) states.
macro_rules! agrees_in_f32 {
    ($($module:ident: $file:literal),* $(,)?) => {$({
        const N: usize = robots::$module::COORDINATES.len();
        const P: usize = robots::$module::PARAMETERS.len();
        let robot = tests::model($file);
        let (_, function) = base_regressor(&robot);
        let mut random = Random(22);
        for _ in 0..20 {
            let state = random.state(&robot);
            let single = |v: &[f64]| -> [f32; N] { std::array::from_fn(|k| v[k] as f32) };
            let [q, dq, ddq] = [&state.q, &state.dq, &state.ddq].map(|v| single(v));
            let mut y = [[0.0f32; P]; N];
            robots::$module::base_regressor(&q, &dq, &ddq, &mut y);
            let inputs: Vec<f64> = q.iter().chain(&dq).chain(&ddq).map(|&x| f64::from(x)).collect();
            let ratio = f64::from(f32::EPSILON) / f64::EPSILON;
            for (y, plain) in y.as_flattened().iter().zip(bounded(&function, &inputs)) {
                // The bound of the rounding error of f64, scaled to f32. The factor 4 allows for lengths that are rounded to f32.
                let allowed = 4.0 * ratio * plain.error.max(f64::EPSILON * plain.value.abs());
                assert!((f64::from(*y) - plain.value).abs() <= allowed, "{}: {y} {plain:?}", $file);
            }
        }
    })*};
}

#[test]
fn single_precision_is_right_to_single_precision() {
    agrees_in_f32!(race: "race.yaml", stanford: "stanford.yaml", ur5: "ur5.yaml", panda: "panda.yaml", tree: "tree.yaml");
}

#[test]
fn sine_and_cosine_of_the_generated_files_are_right_to_an_ulp() {
    let mut random = Random(23);
    let grid = (-40_000..=40_000).map(|k| f64::from(k) * 2.5e-4);
    let multiples = (-1000..=1000).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4);
    let beside = multiples.flat_map(|x| [x, f64::from_bits(x.to_bits() + 1), x + 1e-9, x - 1e-9]);
    let far: Vec<f64> = (0..20_000).map(|_| 1e5 * random.unit()).collect();
    // The range reduction is exact up to its largest argument, 2^27.
    let farther = (17..27).flat_map(|k| (0..100).map(move |i| f64::from(1 << k) * (1.0 + 0.00999 * f64::from(i))));
    let edge = [134_217_727.999, -134_217_727.5];
    let tiny = [0.0, -0.0, 1e-300, -1e-300, 1e-9, f64::MIN_POSITIVE];
    for x in grid.chain(beside).chain(far).chain(farther).chain(edge).chain(tiny) {
        let (s, c) = robots::race::Real::sin_cos(x);
        let (expected_s, expected_c) = x.sin_cos();
        // The generated file states an error of 2e-16. Half a unit in the last place is added for the sine of the standard
        // library.
        assert!((s - expected_s).abs() <= 2.6e-16 && (c - expected_c).abs() <= 2.6e-16, "{x:e}: {s} {c}");
    }
    // NaN, infinity and angles beyond 2^27, whose reduction is inexact, give NaN and no panic.
    let beyond = [134_217_728.0, -1e9, 1e15, -1e17, 1e300, f64::MAX];
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].into_iter().chain(beyond) {
        let (s, c) = robots::race::Real::sin_cos(x);
        assert!(s.is_nan() && c.is_nan());
    }
}
