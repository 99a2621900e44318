//! Tests that postures at rest give the gravity parameters, joint zeros and base mount within their standard deviations.

use identification::estimate::options::Options;
use logs::{ColumnNames, Effort, NamePattern, Postures};
use random::Random;
use rist::{Model, ModelOptions};
use statics::{gravity_parameters, identify_postures};
use tests::model_path;

fn torques(model: &Model, q: &[f64]) -> Vec<f64> {
    let regressor = model.regressor();
    let (n, p) = (q.len(), regressor.parameters().len());
    let (mut y, rest) = (vec![0.0; n * p], vec![0.0; n]);
    regressor.fill(q, &rest, &rest, &mut y);
    let x = model.nominal_parameters().unwrap();
    y.chunks_exact(p).map(|row| row.iter().zip(&x).map(|(y, x)| y * x).sum()).collect()
}

fn named(coordinates: &[String]) -> ColumnNames {
    let each = |stem: &str| Some(NamePattern::Each(coordinates.iter().map(|name| format!("{stem}_{name}")).collect()));
    ColumnNames { position: each("q"), torque: each("tau"), ..ColumnNames::default() }
}

/// Random postures of `model` at rest, with torques. `zeros`: zero errors of the joints, which the logged positions do not
/// contain; `noise`: of the torques, N m.
fn postures(model: &Model, zeros: &[f64], noise: f64, count: usize, seed: u64) -> Postures {
    let mut random = Random::new(seed);
    let n = model.regressor().coordinates().len();
    let (mut q, mut effort) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let at: Vec<f64> = (0..n).map(|_| random.between(-2.0, 2.0)).collect();
        effort.push(torques(model, &at).iter().map(|tau| tau + noise * random.normal()).collect());
        q.push(at.iter().zip(zeros).map(|(q, zero)| q - zero).collect());
    }
    Postures {
        name: "postures".into(),
        coordinates: model.regressor().coordinates().to_vec(),
        q,
        effort,
        effort_is: Effort::Torque,
        rows: count,
        names: named(model.regressor().coordinates()),
        are_plateaus: false,
    }
}

fn ur5(base: Option<[f64; 3]>) -> Model {
    Model::read_with(model_path("ur5.urdf"), &ModelOptions { base, ..ModelOptions::default() }).unwrap()
}

fn identified(model: &Model, postures: &Postures) -> statics::postures::PostureEstimate {
    identify_postures(model, postures, &Options::default()).unwrap()
}

/// The errors, divided by their standard deviations, have unit variance and no outliers. Without noise the values are exact.
#[test]
fn gravity_parameters_come_back_within_their_deviations() {
    let model = ur5(None);
    let (mut squares, mut count) = (0.0, 0.0);
    for seed in 0..20 {
        let found = identified(&model, &postures(&model, &[0.0; 6], 0.3, 60, seed));
        let described = found.described.as_ref().unwrap();
        for (told, truth) in found.values.iter().zip(described).chain(found.offsets.iter().zip(&[0.0; 6])) {
            let (x, sigma) = told.expect("all are told");
            let error = (x - truth) / sigma;
            assert!(error.abs() < 5.0, "{seed}: {x} +- {sigma}, {truth}");
            squares += error * error;
            count += 1.0;
        }
        assert!(!found.placed.unwrap().differs(), "{seed}");
    }
    // The mean square over 20 draws of more than 15 numbers is 1; four of its standard deviations are about 0.25.
    let mean: f64 = squares / count;
    assert!((0.75..1.33).contains(&mean), "{mean} of {count}");
    // Without noise the values are exact.
    let exact = identified(&model, &postures(&model, &[0.0; 6], 0.0, 60, 1));
    for (told, truth) in exact.values.iter().zip(exact.described.as_ref().unwrap()) {
        assert!((told.unwrap().0 - truth).abs() < 1e-9, "{told:?} {truth}");
    }
}

#[test]
fn zeros_and_mounts_come_back() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let upright = ur5(None);
    for (base, zeros) in [
        ([0.0, 0.0, 0.0], [0.0, 0.09, -0.05, 0.17, 0.0, 0.0]),
        ([PI, 0.0, 0.0], [0.0; 6]),
        ([FRAC_PI_2, 0.0, 0.0], [0.0; 6]),
        ([0.0, 0.35, 0.0], [0.0, 0.0, 0.1, 0.0, -0.1, 0.0]),
    ] {
        let truth = ur5(Some(base));
        let measured = postures(&truth, &zeros, 0.05, 100, 7);
        let found = identified(&upright, &measured).placed.unwrap();
        assert!(found.explains && found.left[1] < 0.1 * found.left[0], "{base:?}: {:?}", found.left);
        for (k, told) in found.zeros.iter().enumerate() {
            let Some((zero, sigma)) = *told else { continue };
            assert!(
                (zero - zeros[k]).abs() < 5.0 * sigma + 1e-6,
                "{base:?} joint {k}: {zero} +- {sigma}, {}",
                zeros[k]
            );
        }
        // With the base orientation from the estimate, the model has the same gravity vector as with the true orientation.
        let remedied = ur5(Some(found.base));
        let gravity = |model: &Model| nalgebra::Vector3::from(model.robot.gravity_number());
        let angle = gravity(&remedied).angle(&gravity(&truth));
        assert!(angle < 5.0 * found.tilt.unwrap().1 + 1e-4, "{base:?}: {angle}");
        assert_eq!(found.remedy().contains("offsets"), zeros.iter().any(|zero| *zero != 0.0), "{}", found.remedy());
    }
}

/// If the nominal bodies are wrong, they do not explain the postures. Then no zero error may be reported.
#[test]
fn other_bodies_tell_no_zeros() {
    let model = ur5(None);
    let mut measured = postures(&model, &[0.0; 6], 0.05, 100, 3);
    // The torques of the same arm with a forearm about four times as heavy.
    let text = tests::model_text("ur5.urdf").replacen("mass value=\"2.275\"", "mass value=\"9.0\"", 1);
    let heavy = Model::parse(&text, "ur5.urdf", &ModelOptions::default()).unwrap();
    for (q, effort) in measured.q.iter().zip(&mut measured.effort) {
        *effort = torques(&heavy, q);
    }
    let found = identified(&model, &measured);
    assert!(!found.placed.as_ref().unwrap().explains);
    assert!(found.to_string().contains("do not explain the postures"), "{found}");
}

#[test]
fn too_few_postures_are_refused_and_what_they_can_tell_is_listed() {
    let model = ur5(None);
    let message = identify_postures(&model, &postures(&model, &[0.0; 6], 0.0, 3, 1), &Options::default())
        .err()
        .unwrap()
        .to_string();
    assert!(message.contains("3 postures of 6 joints") && message.contains("are needed"), "{message}");
    let parameters = gravity_parameters(&model).unwrap();
    let names: Vec<&str> = parameters.iter().map(|p| p.name.as_str()).collect();
    assert!(names.iter().all(|name| name.starts_with('M')), "{names:?}");
    assert!(statics::postures::gravity_text(&parameters).contains("[kg m]"));
}

/// Tables of postures and logs as users record them: tables without a clock, tables with a clock in steps of a second, and logs
/// with intervals at rest (plateaus).
#[test]
fn postures_of_the_field_give_the_arm_behind_them() {
    let Some(field) = tests::field() else { return };
    let model = Model::read(field.join("a0_arm.urdf")).unwrap();
    for file in ["static_table_noclock", "static_table", "static_table_ts", "static_plateaus", "static_only"] {
        let path = field.join("logs").join(format!("{file}.csv.gz"));
        let (postures, _) = Postures::read(&path, model.regressor().coordinates(), &Default::default()).unwrap();
        assert_eq!(postures.are_plateaus, file.contains("plateaus") || file.contains("only"), "{file}");
        let found = identified(&model, &postures);
        for (told, truth) in found.values.iter().zip(found.described.as_ref().unwrap()) {
            let (x, sigma) = told.unwrap();
            assert!((x - truth).abs() < 4.0 * sigma, "{file}: {x} +- {sigma}, {truth}");
        }
        let placed = found.placed.as_ref().unwrap();
        assert!(placed.explains && placed.tilt.is_some(), "{file}: {found}");
    }
}

#[test]
fn forces_are_not_torques() {
    let model = Model::read(model_path("scara.yaml")).unwrap();
    let text = identified(&model, &postures(&model, &[0.0; 4], 0.1, 40, 3)).to_string();
    let slides = |k: usize| model.regressor().is_prismatic(k);
    for (k, name) in model.regressor().coordinates().iter().enumerate() {
        let line =
            text.lines().find(|line| line.trim_start().starts_with(name) && line.contains("offset of its torque"));
        let line = line.unwrap_or_else(|| panic!("no {name}: {text}"));
        assert_eq!(line.contains(" N m "), !slides(k), "{line}");
    }
    assert!((0..4).any(slides));
}

/// Wrong signs, units and swapped columns are reported with a remedy, and the remedy removes the fault. If the torques of all
/// joints have the wrong sign, a base that hangs upside down explains them too, so both causes are reported.
#[test]
fn mistakes_of_columns_are_named_and_not_zeros() {
    let model = ur5(None);
    let good = postures(&model, &[0.0; 6], 0.05, 100, 11);
    assert!(identified(&model, &good).mistakes.is_empty());
    type Change = fn(&mut Vec<f64>, &mut Vec<f64>);
    let cases: [(Change, &str); 6] = [
        (|q, _| q.iter_mut().for_each(|q| *q = q.to_degrees()), "in degrees, taken for radians"),
        (|_, tau| tau[1] = -tau[1], "the torque of shoulder_lift has the wrong sign"),
        (|q, _| q[2] = -q[2], "the position of elbow has the wrong sign"),
        (|_, tau| tau.iter_mut().for_each(|x| *x *= 1e3), "another unit: 10^3 times"),
        (|_, tau| tau.swap(1, 2), "the torque columns of shoulder_lift and elbow are swapped"),
        (|_, tau| tau[2] *= 3.0, "the torque of elbow is off by 200 %"),
    ];
    for (change, wanted) in cases {
        let mut wrong = good.clone();
        wrong.q.iter_mut().zip(&mut wrong.effort).for_each(|(q, tau)| change(q, tau));
        let found = identified(&model, &wrong);
        let first = found.mistakes.first().unwrap_or_else(|| panic!("{wanted}: {found}"));
        assert!(first.fault.contains(wanted) && first.left[1] < 0.8 * first.left[0], "{wanted}: {:?}", found.mistakes);
        assert!(!found.to_string().contains("zero, rad"), "{found}");
        let yaml = first.remedy.split_once("in the file of [options]: ").unwrap().1;
        let options = Options::parse("remedy.yaml", yaml).unwrap();
        let read = reread(&wrong, &options.columns);
        let mended = identify_postures(&model, &read, &options).unwrap();
        assert!(mended.mistakes.is_empty() && !mended.placed.unwrap().differs(), "{wanted}: {yaml}");
    }
    let mut upside_down = good.clone();
    upside_down.effort.iter_mut().flatten().for_each(|x| *x = -*x);
    let found = identified(&model, &upside_down).to_string();
    assert!(found.contains("all joints have the wrong sign, or the base hangs upside down"), "{found}");
}

/// The same postures, read again with the column names, signs and units of `names`.
fn reread(postures: &Postures, names: &ColumnNames) -> Postures {
    let chosen = |given: &Option<NamePattern>, stem: &str, rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let Some(NamePattern::Each(each)) = given else { return rows.to_vec() };
        let place = |name: &String| {
            let plain = name.trim_start_matches('-').trim_start_matches(stem);
            (
                postures.coordinates.iter().position(|c| c == plain).unwrap(),
                if name.starts_with('-') { -1.0 } else { 1.0 },
            )
        };
        let places: Vec<(usize, f64)> = each.iter().map(place).collect();
        rows.iter().map(|row| places.iter().map(|(k, sign)| sign * row[*k]).collect()).collect()
    };
    let (mut q, effort) = (chosen(&names.position, "q_", &postures.q), chosen(&names.torque, "tau_", &postures.effort));
    if names.units.position.as_deref() == Some("deg") {
        q.iter_mut().flatten().for_each(|q| *q = q.to_radians());
    }
    Postures { q, effort, ..postures.clone() }
}

/// The nominal bodies are slightly wrong. Then small zero errors are not reported. A zero that is wrong by a right angle, and a
/// base on a wall, are reported.
#[test]
fn far_zeros_and_mounts_are_told_by_nearly_the_bodies() {
    let nearly = |base: Option<[f64; 3]>| {
        let text = tests::model_text("ur5.urdf").replacen("mass value=\"2.275\"", "mass value=\"2.5\"", 1);
        let text = text.replacen("mass value=\"8.393\"", "mass value=\"7.4\"", 1);
        Model::parse(&text, "ur5.urdf", &ModelOptions { base, ..ModelOptions::default() }).unwrap()
    };
    let (model, truth) = (ur5(None), nearly(None));
    let said = |measured: &Postures| identified(&model, measured).to_string();
    let right = said(&postures(&truth, &[0.0; 6], 0.1, 60, 21));
    assert!(!right.contains("to hold them") && !right.contains("; corrected: "), "{right}");
    let off = said(&postures(&truth, &[0.0, 0.0, std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0], 0.1, 60, 22));
    assert!(off.contains("the zero of elbow is off by -"), "{off}");
    let wall = nearly(Some([0.0, std::f64::consts::FRAC_PI_2, 0.0]));
    let wall = said(&postures(&wall, &[0.0; 6], 0.1, 60, 23));
    assert!(wall.contains("[base="), "{wall}");
}
