//! Tests that gear ratios with any number of digits are treated exactly. Columns of the regressor that are too weak to be
//! identified are named and dropped, and the error is bounded.

use std::f64::consts::FRAC_PI_2;

use expr::Tape;
use modeling::{BaseParameters, Derivation, UnclearRank};
use nalgebra::DMatrix;
use robot::{Robot, Value, format};
use tests::has;
use tests::random::Random;
use tests::try_base_parameters as base;

fn read(text: &str) -> Robot {
    format::read_yaml(text, "weak.yaml").unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Checks the error of dropping weak columns: |D_base X_base - D X| <= left_out |D|_max sum |X| for each joint; |D|_max: norm
/// of the largest column over all states. The factor 2 allows for states that differ from the states of the derivation.
fn loses_only_what_is_said(robot: &Robot, base: &BaseParameters, what: &str) {
    assert!(base.rank.left_out <= 1e-6, "{what}: {:?}", base.rank);
    let mut derivation = Derivation::new(robot).unwrap();
    let regressor = derivation.regressor();
    let (n, p) = (robot.n_coordinates(), base.standard.len());
    let states = 3 * p / n + 10;
    let mut random = Random(12);
    let inputs: Vec<f64> = (0..states).flat_map(|_| random.state(robot).inputs()).collect();
    let tape = Tape::new(&regressor);
    let mut values = vec![f64::NAN; states * n * p];
    tape.evaluate_many(&inputs, &mut tape.workspace(), &mut values);
    let d = DMatrix::from_row_slice(states * n, p, &values);
    let norm = |joint: usize, x: &[f64]| x.iter().skip(joint).step_by(n).map(|x| x * x).sum::<f64>().sqrt();
    let mut most: f64 = 0.0;
    for joint in 0..n {
        let largest = d.column_iter().map(|c| norm(joint, c.as_slice())).fold(0.0, f64::max);
        for c in 0..p {
            let mut rest = d.column(c).into_owned();
            for b in &base.base {
                b.terms.iter().filter(|t| t.parameter == c).for_each(|t| rest -= d.column(b.column) * t.coefficient);
            }
            let rest = norm(joint, rest.as_slice()) / largest;
            // Rounding of some hundred operations.
            assert!(rest <= 2.0 * base.rank.left_out + 1e-12, "{what}: column {c}: {rest:e} {:?}", base.rank);
            most = most.max(rest);
        }
    }
    // The stated error bound must be within a factor of ten of the actual error.
    assert!(base.weak.is_empty() == (base.rank.left_out == 0.0), "{what}: {:?}", base.rank);
    assert!(base.rank.left_out <= 1e-13 || most >= 0.1 * base.rank.left_out, "{what}: {most:e} {:?}", base.rank);
}

/// A hand whose finger joints follow (mimic) one coordinate. The ratio of the second joint is the product of two ratios, so it
/// has eight digits.
fn thumb(first: &str, second: &str) -> Robot {
    read(&format!(
        "convention: khalil-kleinfinger
name: thumb
rotor_inertia: none
coordinates: [q0, q1, q2]
links:
  - {{link: 9, antecedent: base, theta: q0}}
  - {{link: 1, antecedent: 9, alpha: -pi/2, d: 0.02101, theta: q1 - 1.309, r: 0.1156}}
  - {{link: 2, antecedent: 1, alpha: pi/2, d: 0.0099, theta: q2 + 0.59}}
  - {{link: 3, antecedent: 2, drive: passive, d: 0.0378, theta: {first}*q2 - 0.0615}}
  - {{link: 4, antecedent: 3, drive: passive, d: 0.02538, theta: {second}*q2}}
"
    ))
}

#[test]
fn ratios_of_any_length_are_exact() {
    let decimal = |n: usize, places: usize| {
        format!("{}{}.{:0places$}", "", n / 10usize.pow(places as u32), n % 10usize.pow(places as u32))
    };
    let mut random = Random(61);
    for _ in 0..12 {
        let [a, b, c] = [(); 3].map(|()| 1001 + random.below(8999));
        for (first, second) in [
            (decimal(a, 4), decimal(a * b, 8)),
            (decimal(a, 4), decimal(a * b * c, 12)),
            (format!("-{}", decimal(a * b, 8)), decimal(a * b * c, 12)),
        ] {
            let robot = thumb(&first, &second);
            let found = base(&robot).unwrap_or_else(|e| panic!("{first} {second}: {e}"));
            // The rank is 28 for all ratios. (In arithmetic of 60 digits, the smallest relative distance of a column from the
            // others is 0.19.)
            assert_eq!((found.len(), found.rank.exact.rank()), (28, Some(28)), "{first} {second}");
            assert!(found.weak.is_empty() && found.rank.left_out == 0.0);
        }
    }
    // The product of the ratios is rounded to double precision, as in a file that a program writes.
    let product = (0.8024 * 0.9487).to_string();
    assert_eq!(base(&thumb("0.8024", &product)).unwrap().len(), 28);
}

/// A finger whose axes are nearly parallel; or nearly perpendicular, if `square`. `tilts`: deviations from the special angles,
/// rad.
fn nearly(tilts: [f64; 3], square: bool, rotors: bool) -> Robot {
    let rotors = if rotors { "actuated" } else { "none" };
    let mut robot = read(&format!(
        "convention: khalil-kleinfinger
name: finger
rotor_inertia: {rotors}
gravity: [0, -9.81, 0]
links:
  - {{link: 1, antecedent: base, theta: q1}}
  - {{link: 2, antecedent: 1, alpha: 0.5, d: 0.04, theta: q2}}
  - {{link: 3, antecedent: 2, alpha: 0.5, d: 0.03, theta: q3}}
  - {{link: 4, antecedent: 3, alpha: 0.5, d: 0.02, theta: q4}}
"
    ));
    for (link, tilt) in robot.links[1..].iter_mut().zip(tilts) {
        link.geometry.alpha = Value::Number(if square { FRAC_PI_2 } else { 0.0 } + tilt);
    }
    robot
}

#[test]
fn nearly_parallel_axes_leave_weak_columns() {
    let (mut weak, mut refused) = (0, Vec::new());
    let mut random = Random(7);
    for draw in 0..48 {
        let power = |random: &mut Random| 10f64.powf(-7.0 + 3.0 * random.unit().abs());
        let mut tilts = [power(&mut random), 0.0, 0.0];
        if draw % 3 > 0 {
            tilts[1] = power(&mut random);
        }
        let robot = nearly(tilts, draw % 2 == 1, draw % 4 > 1);
        let what = format!("{draw} {tilts:?}");
        match base(&robot) {
            Ok(found) => {
                weak += usize::from(!found.weak.is_empty());
                let exact = found.rank.exact.rank().unwrap();
                // Every weak column is named as weak. None is listed as a column without effect.
                assert!(found.len() <= exact && (found.len() < exact) != found.weak.is_empty(), "{what}");
                assert!(found.weak.iter().all(|w| !found.no_effect.contains(&w.column) && w.share < 1e-6), "{what}");
                loses_only_what_is_said(&robot, &found, &what);
            }
            Err(e) => refused.push(format!("{what}: {e}")),
        }
    }
    println!("{weak} weak; refused: {refused:#?}");
    assert!(weak > 10 && refused.is_empty(), "{weak} {refused:#?}");
}

#[test]
fn a_weak_ratio_leaves_weak_columns() {
    let mut seen = 0;
    for (k, ratio) in ["-0.0123", "0.0123", "101", "-0.00123", "0.000123"].into_iter().enumerate() {
        for alpha in ["0", "pi/2", "0.4"] {
            let robot = read(&format!(
                "convention: khalil-kleinfinger
name: ratio
gravity: [1.2, -3.4, -9.1]
links:
  - {{link: 1, antecedent: base, theta: q1}}
  - {{link: 2, antecedent: 1, alpha: {alpha}, d: 0.2, drive: passive, theta: {ratio}*q1 + 0.3}}
  - {{link: 3, antecedent: 2, alpha: 0.7, d: 0.1, theta: q3}}
"
            ));
            let found = base(&robot).unwrap_or_else(|e| panic!("{ratio} {alpha}: {e}"));
            seen += usize::from(!found.weak.is_empty());
            loses_only_what_is_said(&robot, &found, &format!("{k} {ratio} {alpha}"));
        }
    }
    println!("{seen}");
}

/// The sentence on the rank contains the names of the weak columns and the exact rank. If there are no weak columns, it does not
/// mention them.
#[test]
fn weak_columns_are_named() {
    let robot = nearly([7.8504e-5, 0.3, 0.4], false, false);
    let found = base(&robot).unwrap();
    let text = found.evidence_of_rank(&robot);
    let names: Vec<String> = found.weak.iter().map(|w| found.standard[w.column].display(&robot).to_string()).collect();
    assert!(!names.is_empty() && names.iter().all(|name| text.contains(name)), "{text}");
    assert!(text.contains("so weak that no motion shows"), "{text}");
    assert!(text.contains(&found.rank.exact.rank().unwrap().to_string()), "{text}");
    let robot = nearly([0.2, 0.3, 0.4], false, false);
    let text = base(&robot).unwrap().evidence_of_rank(&robot);
    assert!(!text.contains("weak") && text.contains("finite field"), "{text}");
}

/// A robot whose slanted rail is parallel to gravity, perhaps by chance, because both are numbers. So its base parameters are
/// refused.
const BY_CHANCE: &str = "convention: khalil-kleinfinger
name: rail
gravity: [0, 3.8202140182587, -9.035788350852]
links:
  - {link: 1, antecedent: base, joint: prismatic, alpha: 0.4, r: q1}
  - {link: 2, antecedent: 1, joint: prismatic, alpha: pi/2, r: q2}
  - {link: 3, antecedent: 2, d: 0.1, theta: q3}
";

/// For such a robot, functions that need no base parameters are derived and correct; functions that need them are refused.
#[test]
fn only_what_uses_base_parameters_asks_for_their_rank() {
    let gravity = 0.4f64.sin_cos();
    let text = BY_CHANCE
        .replace("3.8202140182587", &(9.81 * gravity.0).to_string())
        .replace("9.035788350852", &(9.81 * gravity.1).to_string());
    let robot = read(&text);
    assert!(matches!(base(&robot), Err(UnclearRank::Coincident { .. })), "{:?}", base(&robot).map(|b| b.len()));
    let path = std::path::Path::new("rail.yaml");
    let refused = rist::Model::of(robot.clone(), path, false).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("Two lengths or angles agree"), "{refused}");
    let model = rist::Model::at_any_rank(robot.clone(), path, false).unwrap();
    assert!(model.parameters.refused.is_some());

    let mut random = Random(3);
    let (state, x) = (random.state(&robot), random.physical_parameters(&robot));
    let tau = tests::recursion::torque(&robot, &state, &x);
    let at = |name: &str, others: &[(&str, &[f64])]| {
        let evaluation = rist::describe::evaluation::Evaluation::of_function(&model, name).unwrap();
        let mut outputs = vec![f64::NAN; evaluation.outputs().iter().map(|o| o.rows * o.columns).sum()];
        let states = rist::describe::evaluation::ManyStates {
            q: &state.q,
            dq: &state.dq,
            ddq: &state.ddq,
            parameters: &x,
            others,
        };
        evaluation.fill(&model, &states, &mut outputs).unwrap();
        outputs
    };
    // Tolerance between two summations of some hundred terms of order ten.
    let same = |found: &[f64], wanted: &[f64]| {
        assert_eq!(found.len(), wanted.len());
        found
            .iter()
            .zip(wanted)
            .for_each(|(a, b)| assert!((a - b).abs() < 1e-11 * (1.0 + b.abs()), "{found:?} {wanted:?}"));
    };
    same(&at("torque", &[]), &tau);
    same(&at("inverse-dynamics", &[]), &tau);
    same(&at("forward-dynamics", &[("tau", &tau)]), &state.ddq);
    let by_regressor: Vec<f64> = at("regressor", &[]).chunks(x.len()).map(|row| tests::dot(row, &x).0).collect();
    same(&by_regressor, &tau);
    assert!(at("pose=3", &[]).iter().all(|x| x.is_finite()));

    let function = |word: &str| modeling::RobotFunction::of_robot(word).unwrap();
    let pose = modeling::RobotFunction::of_link("pose").unwrap()(robot::LinkId(2).into());
    let asked = [function("forward-dynamics"), function("regressor"), pose];
    let formulas = modeling::formulas(&robot, &asked).unwrap();
    assert!(formulas.functions[0].0[0].contains("accelerations"), "{:?}", formulas.functions[0].0);
    let doc = formulas.doc.join(" ");
    assert!(doc.contains("standard parameters, in the order") && !doc.contains("base parameters"), "{doc}");
    let module = modeling::module(&robot, &asked).unwrap();
    let source = codegen::rust_file(&module, "a test");
    has(&source, &["The standard parameters X", "There are no base parameters"]);
    assert!(!source.contains("base_regressor") && source.matches("pub fn regressor<").count() == 1, "{source}");
    for refused in [&[][..], &[function("base-regressor")]] {
        assert!(modeling::module(&robot, refused).is_err());
    }
    assert!(modeling::formulas(&robot, &[function("base-regressor")]).is_err());
}
