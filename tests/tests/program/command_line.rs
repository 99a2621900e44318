//! Tests that the program `rist` prints the results of the library. Requests that it cannot fulfil end with exit code 2; the
//! message has the file, the line and the reason, and no partly written file remains.

use std::fmt::Write as _;
use std::path::Path;

use expr::{Count, Function};
use modeling::BaseParameters;
use robot::Robot;
use serde_json::{Value as Json, json};
use tests::planar_log::{HEADER, log, write_log};
use tests::program::{folder, rist};
use tests::random::{Random, State};
use tests::{dot, evaluated, has, model, model_path, recursion, standard_names, test_robot_path};

struct Derived {
    robot: Robot,
    standard: Function,
    torque: Function,
    base: Function,
    parameters: BaseParameters,
    names: Vec<String>,
}

fn derived(robot: Robot) -> Derived {
    let (mut derivation, standard, parameters) = tests::derived(&robot);
    let (base, torque) = (parameters.regressor(&standard).bound(), derivation.torque().bound());
    let names = standard_names(&robot);
    Derived { standard: standard.bound(), torque, base, parameters, names, robot }
}

fn path(file: &str) -> String {
    model_path(file).display().to_string()
}

/// Path of a description without inertial parameters. So the tests can simulate logs with any parameters.
fn bare(file: &str) -> String {
    test_robot_path(file).display().to_string()
}

#[test]
fn inspect_prints_what_the_library_finds() {
    let here = folder("inspect");
    for file in ["race.yaml", "ur5.urdf"] {
        let d = derived(model(file));
        let run = rist(&here, &["inspect", &path(file), "--json"]);
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{file}");
        let found: Json = serde_json::from_str(&run.out).unwrap();
        assert_eq!(found["robot"], d.robot.name);
        let coordinates: Vec<&str> = d.robot.coordinates.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(found["coordinates"], json!(coordinates));
        assert_eq!(found["standard"], json!(d.names));
        let no_effect: Vec<&String> = d.parameters.no_effect.iter().map(|&c| &d.names[c]).collect();
        assert_eq!(found["no_effect"], json!(no_effect));
        let rules = d.parameters.rules();
        let base: Vec<Json> = d
            .parameters
            .base
            .iter()
            .enumerate()
            .map(|(k, b)| {
                let term = |(i, t): (usize, &modeling::Term)| json!({"parameter": d.names[t.parameter], "coefficient": t.coefficient, "symbolic": rules.coefficients[k][i]});
                json!({
                    "name": b.name,
                    "parameter": d.names[b.column],
                    "rule": rules.base[k],
                    "terms": b.terms.iter().enumerate().map(term).collect::<Vec<_>>(),
                })
            })
            .collect();
        for (found, expected) in found["base"].as_array().unwrap().iter().zip(&base) {
            for key in ["name", "parameter", "rule"] {
                assert_eq!(found[key], expected[key], "{file} {key}");
            }
            let (found, expected) = (found["terms"].as_array().unwrap(), expected["terms"].as_array().unwrap());
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                assert_eq!(found["parameter"], expected["parameter"], "{file}");
                assert_eq!(found["symbolic"], expected["symbolic"], "{file}");
                let [a, b] = [found, expected].map(|term| term["coefficient"].as_f64().unwrap());
                // The reader of serde_json has an error of one unit in the last place.
                assert!((a - b).abs() <= f64::EPSILON * b.abs(), "{file}: {a} {b}");
            }
        }
        assert_eq!(found["base"].as_array().unwrap().len(), base.len());
        assert_eq!(found["rank"]["numeric"], d.parameters.len());
        let gap = &found["rank"]["gap"];
        assert!(gap.is_null() || gap.as_f64().is_some_and(|g| g >= 1e3), "{file}: {gap}");
        let count = |c: Count| json!({"mul": c.mul, "add": c.add, "sin_cos": c.sin_cos});
        for (name, function) in [("regressor", &d.standard), ("base_regressor", &d.base), ("torque", &d.torque)] {
            assert_eq!(found["ops"][name], count(function.count()), "{file} {name}");
        }

        let run = rist(&here, &["inspect", &path(file)]).ended(0);
        // The output is wrapped between words, so line breaks are replaced by blanks.
        let words = run.out.split_whitespace().collect::<Vec<_>>().join(" ");
        for (b, rule) in d.parameters.base.iter().zip(&rules.base) {
            assert!(words.contains(if b.terms.len() > 1 { rule } else { &b.name }), "{file}: {}", b.name);
        }
        assert!(words.contains(&format!("rank {}", d.parameters.len())), "{file}");
    }
}

/// The path of a CSV with states, and with the parameters `x` in each row, from which the torque is evaluated.
fn states_file(folder: &Path, robot: &Robot, states: &[State], x: &[f64]) -> String {
    let header = |kind: &str| robot.coordinates.iter().map(|c| format!("{kind}_{}", c.name)).collect::<Vec<_>>();
    let parameters: Vec<String> = standard_names(robot).iter().map(|name| format!("x_{name}")).collect();
    let mut text = [header("q"), header("dq"), header("ddq"), parameters].concat().join(",") + "\n";
    for state in states {
        let cells: Vec<String> = state.inputs().iter().chain(x).map(|x| format!("{x:?}")).collect();
        writeln!(text, "{}", cells.join(",")).unwrap();
    }
    let path = folder.join("states.csv");
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}

#[test]
fn evaluate_prints_the_three_quantities_to_the_last_bit() {
    for file in ["race.yaml", "stanford.yaml"] {
        let here = folder("evaluate");
        let d = derived(model(file));
        let mut random = Random(31);
        let states: Vec<State> = (0..5).map(|_| random.state(&d.robot)).collect();
        let x = random.parameters(&d.robot);
        let csv = states_file(&here, &d.robot, &states, &x);
        let columns = |names: &[String]| {
            let of = |c: &robot::Coordinate| names.iter().map(|p| format!("Y_{}_{p}", c.name)).collect::<Vec<_>>();
            d.robot.coordinates.iter().flat_map(of).collect::<Vec<String>>().join(",")
        };
        let base_names: Vec<String> = d.parameters.base.iter().map(|b| b.name.clone()).collect();
        let torques: Vec<String> = d.robot.coordinates.iter().map(|c| format!("tau_{}", c.name)).collect();
        for (quantity, header, function) in [
            ("regressor", columns(&d.names), &d.standard),
            ("base-regressor", columns(&base_names), &d.base),
            ("torque", torques.join(","), &d.torque),
        ] {
            let run = rist(&here, &["evaluate", &path(file), &csv, "--quantity", quantity]);
            assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{file} {quantity}");
            let mut lines = run.out.lines();
            assert_eq!(lines.next(), Some(header.as_str()), "{file} {quantity}");
            for (k, state) in states.iter().enumerate() {
                let parameters = if quantity == "torque" { &x[..] } else { &[] };
                let found: Vec<f64> = lines.next().unwrap().split(',').map(|x| x.parse().unwrap()).collect();
                // The values must be equal bit by bit: numbers are printed with enough digits to restore them, and the operations
                // do not depend on the number of states.
                assert_eq!(found, evaluated(function, &[&state.inputs(), parameters]), "{file} {quantity}, state {k}");
            }
            assert_eq!(lines.next(), None);
        }
    }
}

#[test]
fn identify_gives_back_the_parameters_that_made_the_log() {
    let here = folder("identify");
    let d = derived(model("planar2r_vertical.yaml"));
    let x = Random(32).physical_parameters(&d.robot);
    write_log(&here, &log(&d.robot, &x));
    let unfiltered = ["--order", "0", "--decimate", "1", "--friction", "none", "--weights", "none"];
    let arguments = ["identify", &bare("planar2r_vertical.yaml"), "log.csv", "--out", "estimate.yaml"];
    let run = rist(&here, &[&arguments[..], &unfiltered].concat());
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{}", run.out);

    let text = std::fs::read_to_string(here.join("estimate.yaml")).unwrap();
    let estimate: Json = serde_yaml::from_str(&text).unwrap();
    let parameters = estimate["parameters"].as_array().unwrap();
    let expected = d.parameters.values(&x);
    assert_eq!(parameters.len(), expected.len());
    let scale = expected.iter().fold(0.0f64, |s, x| s.max(x.abs()));
    for ((found, base), expected) in parameters.iter().zip(&d.parameters.base).zip(&expected) {
        assert_eq!(found["name"], base.name);
        // Accelerations are central differences of dq: relative error (w h)^2 / 6 = 3e-6 at w = 4.1 rad/s and h = 1 ms, and more
        // in the first and last of 6000 rows. These are the only errors.
        let value = found["value"].as_f64().unwrap();
        assert!((value - expected).abs() <= 3e-5 * scale, "{}: {value} {expected}", base.name);
        assert!(run.out.contains(&base.name));
    }

    // With the default filter and weights, the error is below 0.1 % of the largest parameter.
    rist(&here, &[&arguments[..], &["--friction", "none"]].concat()).ended(0);
    let text = std::fs::read_to_string(here.join("estimate.yaml")).unwrap();
    let estimate: Json = serde_yaml::from_str(&text).unwrap();
    for (found, expected) in estimate["parameters"].as_array().unwrap().iter().zip(&expected) {
        let value = found["value"].as_f64().unwrap();
        assert!((value - expected).abs() <= 1e-3 * scale, "{found}: {expected}");
    }
    // The parameters must predict the torque of another motion.
    let state = State { q: vec![0.4, -1.0], dq: vec![1.0, 2.0], ddq: vec![-3.0, 1.0] };
    let y = evaluated(&d.base, &[&state.inputs()]);
    let values: Vec<f64> =
        estimate["parameters"].as_array().unwrap().iter().map(|p| p["value"].as_f64().unwrap()).collect();
    for (row, tau) in y.chunks(values.len()).zip(recursion::torque(&d.robot, &state, &x)) {
        let (found, size) = dot(row, &values);
        assert!((found - tau).abs() <= 1e-3 * size, "{found} {tau}");
    }
}

#[test]
fn generate_writes_the_file_of_the_library() {
    let here = folder("generate");
    let model = path("race.yaml");
    rist(&here, &["generate", &model, "--out", "race.rs"]).ended(0);
    let written = std::fs::read_to_string(here.join("race.rs")).unwrap();
    let module = modeling::module(&tests::model("race.yaml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(written, codegen::rust_file(&module, &format!("rist generate {model}")));
    assert_eq!(rist(&here, &["generate", &model]).out, written);
    assert_eq!(files(&here), ["race.rs"], "and nothing beside it");
}

fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Runs the program with arguments that it must refuse: exit code 2, each phrase of `said` in the message, no output and no new
/// file.
fn refused(folder: &Path, arguments: &[&str], said: &[&str]) {
    let before = files(folder);
    let run = rist(folder, arguments);
    assert_eq!((run.code, run.out.as_str()), (Some(2), ""), "{arguments:?}: {}", run.err);
    has(&run.err, said);
    assert_eq!(files(folder), before, "{arguments:?}");
}

#[test]
fn what_cannot_be_done_is_refused_with_its_place() {
    let here = folder("refused");
    refused(&here, &["inspect", "nowhere.yaml"], &["nowhere.yaml"]);
    refused(&here, &["generate", "nowhere.yaml", "--out", "x.rs"], &["nowhere.yaml"]);
    refused(&here, &["frobnicate"], &["frobnicate"]);

    let text = tests::model_text("rx90.yaml");
    let line = 1 + text.lines().position(|l| l.contains("link: 3,")).unwrap();
    std::fs::write(here.join("typo.yaml"), text.replace("antecedent: 2, d: D3", "antecedent: 2, dd: D3")).unwrap();
    refused(&here, &["inspect", "typo.yaml"], &[&format!("typo.yaml:{line}"), "`dd`", "`d`"]);
    refused(&here, &["generate", "typo.yaml", "--out", "x.rs"], &["typo.yaml"]);
    refused(&here, &["generate", &path("race.yaml"), "--out", "no/such/folder/x.rs"], &["no/such/folder/x.rs"]);

    let states = |text: &str| std::fs::write(here.join("states.csv"), text).unwrap();
    let evaluate = |quantity| ["evaluate", "planar.yaml", "states.csv", "--quantity", quantity];
    std::fs::copy(test_robot_path("planar2r_vertical.yaml"), here.join("planar.yaml")).unwrap();
    states("q_q1,q_q2\n0.1,0.2\n0.1,NaN\n");
    refused(&here, &evaluate("regressor"), &["states.csv:3", "q_q2", "NaN"]);
    states("q_q1\n0.1\n");
    refused(&here, &evaluate("regressor"), &["states.csv", "q_q2"]);
    states("q_q1,q_q2\n");
    refused(&here, &evaluate("regressor"), &["states.csv"]);
    states("q_q1,q_q2\n0.1,0.2\n");
    refused(&here, &evaluate("torque"), &["x_XX1"]);
}

#[test]
fn a_log_that_cannot_be_used_is_refused_with_its_place() {
    let here = folder("bad_log");
    let robot = model("planar2r_vertical.yaml");
    let rows = log(&robot, &Random(33).physical_parameters(&robot));
    let arguments = ["identify", &bare("planar2r_vertical.yaml"), "log.csv", "--out", "estimate.yaml"];
    refused(&here, &arguments, &["log.csv"]);
    let mut broken = rows.clone();
    broken[40] = broken[40].replace(',', "x,");
    write_log(&here, &broken);
    refused(&here, &arguments, &["log.csv:42"]);
    std::fs::write(here.join("log.csv"), "").unwrap();
    refused(&here, &arguments, &["log.csv"]);
    std::fs::write(here.join("log.csv"), format!("{HEADER}\n")).unwrap();
    refused(&here, &arguments, &["log.csv"]);
    std::fs::write(here.join("log.csv"), format!("{}\n{}\n", HEADER.replace("tau2", "other"), rows.join("\n")))
        .unwrap();
    refused(&here, &arguments, &["log.csv", "q2"]);
}

#[test]
fn a_nan_in_a_log_is_left_out_and_told_and_a_log_of_them_refused() {
    let here = folder("nan_log");
    let robot = model("planar2r_vertical.yaml");
    let mut rows = log(&robot, &Random(33).physical_parameters(&robot));
    let without_q2 = |row: &String| {
        let mut cells: Vec<&str> = row.split(',').collect();
        cells[2] = "NaN";
        cells.join(",")
    };
    let arguments = ["identify", &bare("planar2r_vertical.yaml"), "log.csv", "--out", "estimate.yaml"];
    rows[998] = without_q2(&rows[998]);
    write_log(&here, &rows);
    rist(&here, &arguments).told(0, &["1 row left out", "line 1000"]);
    let estimate = std::fs::read_to_string(here.join("estimate.yaml")).unwrap();
    assert!(!estimate.contains("NaN") && !estimate.contains(".nan"), "{estimate}");

    std::fs::remove_file(here.join("estimate.yaml")).unwrap();
    write_log(&here, &rows.iter().map(without_q2).collect::<Vec<_>>());
    refused(&here, &arguments, &["log.csv"]);
}

#[test]
fn shells_and_manuals_know_every_command() {
    let here = folder("shells");
    rist(&here, &["completions", "bash"]).told(0, &["_rist()", "--rotor-inertia"]);
    assert_eq!(rist(&here, &["man", "--out", "man"]).code, Some(0));
    let pages = files(&here.join("man"));
    for command in ["rist.1", "rist-identify.1", "rist-inspect.1"] {
        assert!(pages.iter().any(|page| page == command), "{pages:?}");
    }
    let page = std::fs::read_to_string(here.join("man/rist-identify.1")).unwrap();
    assert!(page.contains("rist\\-identify") && page.contains("SIGNALS") && page.contains("Examples"), "{page}");
}

#[test]
fn lint_fails_on_findings_only() {
    let here = folder("lint");
    let arm = "convention: khalil-kleinfinger\nname: arm\nlinks:\n  - {link: 1, antecedent: base, theta: q1}\nstandard_parameters:\n";
    let of = |zz: f64| {
        let text =
            format!("{arm}  1: {{XX: 0.1, XY: 0, XZ: 0, YY: 0.1, YZ: 0, ZZ: {zz}, MX: 0, MY: 0, MZ: 0, M: 4}}\n");
        std::fs::write(here.join("arm.yaml"), text).unwrap();
        rist(&here, &["lint", "arm.yaml"])
    };
    // Inertias must satisfy the triangle inequality: ZZ must not exceed XX + YY.
    assert_eq!(of(0.1).code, Some(0), "{}", of(0.1).out);
    assert_eq!(of(5.0).code, Some(1), "{}", of(5.0).out);
}

/// `lint --write` changes only the numbers of the body that has the finding, and the result has no findings. If no repair is
/// known, nothing is written.
#[test]
fn lint_writes_the_repair_that_it_names() {
    let here = folder("lint_write");
    let arm = |inertia: &str| {
        let text = format!(
            "<robot name=\"r\"><!-- kept --><link name=\"b\"/><link name=\"l\"><inertial><origin xyz=\"0 0 0.01\"/><mass value=\"0.9\"/>\
             <inertia {inertia}/></inertial></link><joint name=\"j\" type=\"continuous\"><parent link=\"b\"/><child link=\"l\"/>\
             <origin xyz=\"0 0 0.3\"/><axis xyz=\"1 0 0\"/></joint></robot>"
        );
        std::fs::write(here.join("arm.urdf"), text).unwrap();
    };
    arm("ixx=\"-0.004\" ixy=\"0\" ixz=\"0\" iyy=\"-0.005\" iyz=\"0\" izz=\"0.002\"");
    let run = rist(&here, &["lint", "arm.urdf", "--write", "repaired.urdf"]);
    assert!(run.code == Some(1) && run.out.contains("with the signs of the negative moments changed"), "{}", run.out);
    let text = std::fs::read_to_string(here.join("repaired.urdf")).unwrap();
    assert!(
        text.contains("<!-- kept -->") && text.contains("ixx=\"0.004\"") && text.contains("iyy=\"0.005\""),
        "{text}"
    );
    let sound = ["lint", "repaired.urdf", "--write", "again.urdf"];
    rist(&here, &sound).told(0, &["0 findings in 1 link", "total mass 0.900 kg"]);
    assert!(!here.join("again.urdf").exists());
    rist(&here, &["lint", "repaired.urdf", "--mass", "2"]).ended(1);
    rist(&here, &["lint", "repaired.urdf", "--mass", "-2"]).ended(2);
    // The triangle inequality is violated by 9 % of the largest moment: the nearest possible moments are written.
    arm("ixx=\"0.001\" ixy=\"0\" ixz=\"0\" iyy=\"0.001\" iyz=\"0\" izz=\"0.0022\"");
    let run = rist(&here, &["lint", "arm.urdf", "--write", "nearest.urdf"]).ended(1);
    assert!(run.out.contains("do not determine the cause") && run.out.contains("nearest possible"), "{}", run.out);
    let text = std::fs::read_to_string(here.join("nearest.urdf")).unwrap();
    assert!(text.contains("ixx=\"0.0011\"") && text.contains("izz=\"0.0022\""), "{text}");
    rist(&here, &["lint", "nearest.urdf"]).told(0, &["0 findings in 1 link"]);
    // By 38 %, without shapes: there are no plausible moments.
    arm("ixx=\"0.001\" ixy=\"0\" ixz=\"0\" iyy=\"0.001\" iyz=\"0\" izz=\"0.0032\"");
    let run = rist(&here, &["lint", "arm.urdf", "--write", "none.urdf"]).ended(1);
    assert!(run.out.contains("do not determine the cause") && !run.out.contains("nearest"), "{}", run.out);
    assert!(run.err.contains("nothing is written") && !here.join("none.urdf").exists(), "{}", run.err);
}

/// `lint --write` changes the numbers of an MJCF and of a YAML in their places; the rest of the text is unchanged.
#[test]
fn lint_writes_into_other_formats() {
    let here = folder("lint_write_formats");
    let mjcf = |inertial: &str| {
        format!(
            "<mujoco><worldbody><body name=\"b\"><!-- kept --><joint name=\"j\" axis=\"0 1 0\"/>\n<inertial {inertial}/></body>\
             </worldbody><actuator><motor joint=\"j\"/></actuator></mujoco>"
        )
    };
    let yaml = |xx: &str| {
        format!(
            "convention: khalil-kleinfinger\nname: r # kept\nlinks:\n- {{link: 1, antecedent: base, theta: q1}}\nstandard_parameters:\n  \
             1: {{XX: {xx}, XY: 0, XZ: 0, YY: 0.06, YZ: 0, ZZ: 0.06, MX: 0.4, MY: 0, MZ: 0, M: 4}} # sign\n"
        )
    };
    let in_grams = "pos=\"100 0 0\" quat=\"1 1 0 0\" mass=\"4000\" diaginertia=\"10000000 20000000 20000000\"";
    // The quarter turn about x exchanges the two equal moments.
    let in_kilograms = "pos=\"0.1 0 0\" mass=\"4\" fullinertia=\"0.01 0.02 0.02 0 0 0\"";
    let of_yaml = "with the signs of the negative moments changed";
    for (file, given, repair, wanted) in [
        ("arm.xml", mjcf(in_grams), "with all in g and mm", mjcf(in_kilograms)),
        ("arm.yaml", yaml("-0.005"), of_yaml, yaml("0.005")),
    ] {
        std::fs::write(here.join(file), given).unwrap();
        let out = format!("repaired_{file}");
        let run = rist(&here, &["lint", file, "--write", &out]).ended(1);
        assert!(run.out.contains(repair), "{}", run.out);
        assert_eq!(std::fs::read_to_string(here.join(&out)).unwrap(), wanted);
        rist(&here, &["lint", &out]).ended(0);
    }
}

/// A centre of mass outside of its mesh is reported; a centre inside is not. This also holds if shape and centre are moved
/// together.
#[test]
fn lint_looks_into_meshes() {
    let here = folder("lint_meshes");
    // The corners of a box of 0.2 x 0.1 x 0.1 m about its origin, in mm.
    let corner = |k: usize| [0, 1, 2].map(|i| [100.0, 50.0, 50.0][i] * if k >> i & 1 == 1 { 1.0 } else { -1.0 });
    let mut stl = String::from("solid box\n");
    for [a, b, c] in [[0, 1, 2], [3, 4, 5], [5, 6, 7], [0, 2, 4], [1, 3, 7]] {
        stl += " facet normal 0 0 1\n outer loop\n";
        [a, b, c].map(corner).iter().for_each(|[x, y, z]| stl += &format!("  vertex {x} {y} {z}\n"));
        stl += " endloop\n endfacet\n";
    }
    std::fs::create_dir_all(here.join("meshes")).unwrap();
    std::fs::write(here.join("meshes/box.stl"), stl + "endsolid\n").unwrap();
    let of = |centre: &str, shape: &str, mesh: &str| {
        let text = format!(
            "<robot name=\"r\"><link name=\"b\"/><link name=\"l\"><inertial><origin xyz=\"{centre}\"/><mass value=\"2\"/>\
             <inertia ixx=\"0.004\" ixy=\"0\" ixz=\"0\" iyy=\"0.009\" iyz=\"0\" izz=\"0.009\"/></inertial><collision>\
             <origin xyz=\"{shape}\"/><geometry><mesh filename=\"{mesh}\" scale=\"0.001 0.001 0.001\"/></geometry>\
             </collision></link><joint name=\"j\" type=\"continuous\"><parent link=\"b\"/><child link=\"l\"/></joint></robot>"
        );
        std::fs::write(here.join("arm.urdf"), text).unwrap();
        rist(&here, &["lint", "arm.urdf"])
    };
    let outside = of("0.4 0 0", "0.1 0 0", "meshes/box.stl");
    // The centre of mass is at x = 0.4 m, the face of the box at x = 0.2 m. The diagonal of the box (0.2 x 0.1 x 0.1 m) is
    // 0.245 m.
    let said =
        "l: the centre of mass lies outside the hull of the collision meshes: by 0.200 m, of meshes 0.245 m across";
    assert!(outside.code == Some(1) && outside.out.contains(said), "{}", outside.out);
    for (centre, shape, mesh) in [
        ("0.1 0 0", "0.1 0 0", "meshes/box.stl"),
        ("0.4 0 0", "0.4 0 0", "meshes/box.stl"),
        ("0.195 0.045 0.045", "0.1 0 0", "meshes/box.stl"),
        ("0.4 0 0", "0 0 0", "meshes/absent.stl"),
    ] {
        let run = of(centre, shape, mesh);
        assert!(run.code == Some(0) && !run.out.contains("outside"), "{centre}: {}", run.out);
    }
}
