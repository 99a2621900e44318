//! Tests of the packages: compilers accept the files, and the torques are equal to the torques of the library. Late states,
//! NaN states and torque limits have the effects that the README of each package describes.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use packages::{PackageRequest, PackageTarget, package};
use rist::describe::source::IdentifiedValues;
use rist::{Estimate, Model, ModelOptions, Options};

/// An arm whose names contain characters with a special meaning in XML, YAML, CMake, C++ or Python.
const ODD: &str = r#"<robot name="arm */ &lt;b&gt; &quot;x&quot; &amp; @PREFIX@">
  <link name="base"/><link name="a"><inertial><mass value="1"/><origin xyz="0.2 0 0.01"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="b"><inertial><mass value="0.4"/><origin xyz="0.15 0.02 0"/>
    <inertia ixx="0.002" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j &quot;1&quot; \ */ &lt;&amp;" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="9" velocity="3"/></joint>
  <joint name="j'2': # ${x}" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="4" velocity="3"/></joint>
</robot>"#;

/// Viscous friction, Coulomb friction and offset (FV, FS, OFF) of both joints.
const FRICTION: [f64; 6] = [0.2, 0.15, 0.05, 0.1, 0.08, -0.02];
/// Options of drives with currents in counts; the first motor turns in the opposite direction.
const CURRENTS: &str = "columns: {units: {position: ticks(4096), velocity: counts(0.024 rad/s), current: counts(2.69 mA)}}\n\
                        transmission: {ratios: [-1, 1], drive_gains: [1.8, 0.9], offsets: [0.1, 0]}\n";
const GOALS: &str = "columns: {goal: 'g_{}', units: {position: ticks(4096), velocity: counts(0.024 rad/s)}}\n\
                     transmission: {drive_gains: [60, 30]}\n";

fn odd() -> Model {
    Model::parse(ODD, "odd.urdf", &ModelOptions::default()).unwrap()
}

/// Writes a package of `model` into an empty folder, and returns the folder.
fn written(model: &Model, target: PackageTarget, options: &str, folder: &str) -> PathBuf {
    let here = Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder);
    let _ = std::fs::remove_dir_all(&here);
    for file in made(model, target, options).unwrap() {
        let path = here.join(&file.path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, file.text).unwrap();
    }
    here
}

fn made(model: &Model, target: PackageTarget, options: &str) -> Result<Vec<packages::PackageFile>, rist::Error> {
    let n = model.robot.n_coordinates();
    let values = IdentifiedValues {
        base: model.nominal_parameters().unwrap(),
        friction: FRICTION.iter().copied().cycle().take(3 * n).collect(),
        left_out: vec!["stribeck of q1".into()],
        logs: vec!["log */ .csv".into()],
        monitor: None,
    };
    let options = (!options.is_empty()).then(|| Options::parse("options.yaml", options).unwrap());
    let request = PackageRequest { target: Some(target), options };
    package(model, &Estimate::default(), &values, &request, "rist generate odd.urdf */ \"\"\" `x`")
}

fn run(here: &Path, program: &str, options: &str) -> Output {
    Command::new(program).args(options.split_whitespace()).current_dir(here).output().unwrap()
}

fn done(here: &Path, program: &str, options: &str) -> String {
    let output = run(here, program, options);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {options}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

/// The torques that the library computes, without friction.
fn torques(model: &Model, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
    let (x, n) = (model.nominal_parameters().unwrap(), q.len());
    let mut y = vec![0.0; n * x.len()];
    model.regressor().fill(q, dq, ddq, &mut y);
    y.chunks(x.len()).map(|row| row.iter().zip(&x).map(|(y, x)| y * x).sum()).collect()
}

/// The numbers of each line that a program printed.
fn lines(text: &str) -> Vec<Vec<f64>> {
    text.lines().map(|line| line.split_whitespace().map(|x| x.parse().unwrap()).collect()).collect()
}

/// A program that runs cycles of the generated C code, and prints for each cycle the efforts of both joints and the status. The
/// cycles: gravity compensation, computed torque, no reference, 12 late states, a good state, a state with NaN, a state beyond
/// a torque limit.
const CYCLES: &str = r#"
#include <math.h>
#include <stdio.h>
#include "PREFIX_step.h"
typedef PREFIX_real real;
static void out(int status, const real *e) { printf("%.9g %.9g %d\n", (double)e[0], (double)e[1], status); }
int main(void)
{
    PREFIX_controller c;
    const real x[2] = {(real)0.3, (real)-0.4}, v[2] = {(real)0.5, (real)0.2}, bad[2] = {(real)NAN, 0};
    const real r[3][2] = {{(real)0.4, (real)-0.3}, {(real)0.6, (real)0.1}, {(real)1, (real)-2}};
    const real none[3][2] = {{0, 0}, {0, (real)NAN}, {0, 0}};
    real e[2];
    int k;
    PREFIX_start(&c);
    out(PREFIX_step(&c, UPPER_GRAVITY, 0, x, v, NULL, e), e);
    out(PREFIX_step(&c, UPPER_GRAVITY, 1, x, v, NULL, e), e);
    out(PREFIX_step(&c, UPPER_FEEDFORWARD, 1, x, v, r, e), e);
    c.kp[0] = c.kp[1] = (real)4; c.kd[0] = c.kd[1] = (real)2;
    out(PREFIX_step(&c, UPPER_COMPUTED, 1, x, v, r, e), e);
    out(PREFIX_step(&c, UPPER_COMPUTED, 1, x, v, none, e), e);
    for (k = 0; k < 12; k++)
        out(PREFIX_step(&c, UPPER_GRAVITY, 0, x, v, NULL, e), e);
    out(PREFIX_step(&c, UPPER_GRAVITY, 1, x, v, NULL, e), e);
    out(PREFIX_step(&c, UPPER_GRAVITY, 1, bad, v, NULL, e), e);
    out(PREFIX_step(&c, UPPER_GRAVITY, 1, x, bad, NULL, e), e);
    c.limit[0] = (real)0.5;
    out(PREFIX_step(&c, UPPER_GRAVITY, 1, x, v, NULL, e), e);
    return 0;
}
"#;

/// Compiles and runs [`CYCLES`] in the folder of a package's C files, and returns its lines.
fn cycles(here: &Path, prefix: &str) -> Vec<Vec<f64>> {
    let main = CYCLES.replace("PREFIX", prefix).replace("UPPER", &prefix.to_ascii_uppercase());
    std::fs::write(here.join("cycles.c"), main).unwrap();
    let files = format!("cycles.c {prefix}_step.c {prefix}.c");
    done(here, "cc", &format!("-std=c99 -Wall -Wextra -Wconversion -pedantic -Werror -O1 -o cycles {files} -lm"));
    lines(&done(here, &here.join("cycles").display().to_string(), ""))
}

fn friction(dq: [f64; 2]) -> [f64; 2] {
    let of = |k: usize| FRICTION[3 * k] * dq[k] + FRICTION[3 * k + 1] * (dq[k] / 0.02).tanh() + FRICTION[3 * k + 2];
    [of(0), of(1)]
}

/// Checks the lines that [`CYCLES`] prints, if positions, velocities and torques have the units and signs of the joints (no
/// drive units).
fn check_cycles(model: &Model, found: &[Vec<f64>], tolerance: f64) {
    let near = |line: usize, tau: &[f64], status: f64| {
        let found = &found[line];
        // The tolerance is relative to the largest torque, 9 N m.
        let is_near = found.iter().zip(tau).all(|(a, b)| (a - b).abs() < 9.0 * tolerance);
        assert!(is_near && found[2] == status, "line {line}: {found:?}, expected {tau:?} {status}");
    };
    let (q, dq) = ([0.3, -0.4], [0.5, 0.2]);
    let sum = |tau: Vec<f64>, f: [f64; 2]| vec![tau[0] + f[0], tau[1] + f[1]];
    let gravity = sum(torques(model, &q, &[0.0; 2], &[0.0; 2]), [FRICTION[2], FRICTION[5]]);
    near(0, &[0.0, 0.0], 4.0);
    near(1, &gravity, 0.0);
    let (q_r, dq_r, ddq_r) = ([0.4, -0.3], [0.6, 0.1], [1.0, -2.0]);
    near(2, &sum(torques(model, &q_r, &dq_r, &ddq_r), friction(dq_r)), 0.0);
    let back = |k: usize| ddq_r[k] + 2.0 * (dq_r[k] - dq[k]) + 4.0 * (q_r[k] - q[k]);
    near(3, &sum(torques(model, &q, &dq, &[back(0), back(1)]), friction(dq_r)), 0.0);
    near(4, &gravity, 8.0);
    (5..15).for_each(|line| near(line, &gravity, 2.0));
    near(15, &[0.0, 0.0], 4.0);
    near(16, &[0.0, 0.0], 4.0);
    near(17, &gravity, 0.0);
    near(18, &gravity, 2.0);
    near(19, &gravity, 2.0);
    assert!(gravity[0].abs() > 0.5, "the limit of this line cuts: {gravity:?}");
    near(20, &[0.5 * gravity[0].signum(), gravity[1]], 1.0);
    assert_eq!(found.len(), 21);
}

fn prefix_of(folder: &Path) -> String {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    files.filter_map(|name| name.strip_suffix("_step.h").map(String::from)).next().unwrap()
}

#[test]
fn torques_in_c_are_those_of_the_library_and_late_states_have_the_last_one() {
    let model = odd();
    let here = written(&model, PackageTarget::Ros2Control, "", "c_double").join("src");
    // Tolerance: nine digits are printed.
    check_cycles(&model, &cycles(&here, &prefix_of(&here)), 1e-8);
    let folder = written(&model, PackageTarget::Arduino, "", "c_float");
    let sketch = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).find(|path| path.is_dir()).unwrap();
    // Tolerance: some hundred operations, each with a rounding error of 6e-8.
    check_cycles(&model, &cycles(&sketch, &prefix_of(&sketch)), 1e-5);
}

#[test]
fn efforts_in_c_have_the_unit_and_sign_of_the_drives() {
    let model = odd();
    let here = written(&model, PackageTarget::Ros2Control, CURRENTS, "c_currents").join("src");
    let found = cycles(&here, &prefix_of(&here));
    let ticks = std::f64::consts::TAU / 4096.0;
    let q = [-0.3 * ticks + 0.1, -0.4 * ticks];
    let gravity = torques(&model, &q, &[0.0; 2], &[0.0; 2]);
    let expected = [-(gravity[0] + FRICTION[2]) / 1.8 / 2.69e-3, (gravity[1] + FRICTION[5]) / 0.9 / 2.69e-3];
    for (found, expected) in found[1].iter().zip(expected) {
        // Numbers of some hundred counts are printed with nine digits.
        assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    }
}

/// Writes the headers of `tests/stubs`, which replace the headers of the real libraries, each to its path.
fn stubs(here: &Path) {
    for part in include_str!("stubs/headers.txt").split("=== ").skip(1) {
        let (path, text) = part.split_once('\n').unwrap();
        let path = here.join("stubs").join(path.trim());
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

#[test]
fn a_compiler_accepts_the_plugins_of_ros_and_their_texts_are_read() {
    let here = written(&odd(), PackageTarget::Ros2Control, CURRENTS, "ros2");
    stubs(&here);
    for source in ["controller", "solver"] {
        let flags = "-fsyntax-only -std=c++17 -Wall -Wextra -Werror -Istubs -Isrc";
        done(&here, "g++", &format!("{flags} src/{source}.cpp"));
    }
    let text = |file: &str| std::fs::read_to_string(here.join(file)).unwrap();
    let package = text("package.xml");
    let name = roxmltree::Document::parse(&package)
        .unwrap()
        .descendants()
        .find(|n| n.has_tag_name("name"))
        .map(|n| n.text().unwrap().to_string());
    let name = name.unwrap();
    assert!(
        name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_') && !name.contains("__"),
        "{name}"
    );
    for (file, class) in [("controller_plugin.xml", "Controller"), ("solver_plugin.xml", "Solver")] {
        let text = text(file);
        let document = roxmltree::Document::parse(&text).unwrap();
        let of_class = document.descendants().find(|n| n.has_tag_name("class")).unwrap();
        assert_eq!(of_class.attribute("type"), Some(format!("{name}::{class}").as_str()));
        assert!(
            text_of(&here, &format!("src/{}.cpp", class.to_lowercase()))
                .contains(&format!("PLUGINLIB_EXPORT_CLASS({name}::{class}"))
        );
    }
    let yaml: serde_json::Value = serde_yaml::from_str(&text("controllers.yaml")).unwrap();
    assert_eq!(yaml["controller_manager"]["ros__parameters"][&name]["type"], format!("{name}/Controller"));
    let own = &yaml[&name]["ros__parameters"];
    assert_eq!(own["limit"], serde_json::json!([9.0, 4.0]));
    assert_eq!((own["kp"].as_array().unwrap().len(), own["mode"].as_str()), (2, Some("gravity")));
    assert!(text("src/controller.cpp").contains(r#"{{"j \"1\" \\ */ <&", "j'2': # ${x}"}}"#));
    check_readme(&text("README.md"));
}

fn text_of(here: &Path, file: &str) -> String {
    std::fs::read_to_string(here.join(file)).unwrap()
}

/// The README must be short, and must name the units, the limits, the rule for late states, the missing friction and what was
/// not tried.
fn check_readme(text: &str) {
    for said in [
        "**Units",
        "**Limits**, N m (N), from the description:",
        " at\nmost 10 cycles",
        "**Not tried",
        "stribeck of q1",
    ] {
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words(text).contains(words(said).as_str()), "{said}: {text}");
    }
    assert!(text.lines().count() <= 45 && !text.contains("@PREFIX@/") && !text.contains("@N@"), "{text}");
}

/// The sketch is compiled with a simulated bus and run. After 20 cycles, the drives on this bus send no more states.
#[test]
fn the_sketch_sends_the_last_torque_and_then_none() {
    let model = odd();
    let folder = written(&model, PackageTarget::Arduino, "", "arduino");
    check_readme(&text_of(&folder, "README.md"));
    let here = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).find(|path| path.is_dir()).unwrap();
    let prefix = prefix_of(&here);
    assert_eq!(here.file_name().unwrap().to_str(), Some(prefix.as_str()), "a sketch is in a folder of its name");
    stubs(&here);
    let main =
        format!("#include \"Arduino_CAN.h\"\n#include \"{prefix}.ino\"\n{}", include_str!("stubs/arduino_main.txt"));
    std::fs::write(here.join("main.cpp"), main).unwrap();
    for source in [prefix.clone(), format!("{prefix}_step")] {
        done(&here, "cc", &format!("-std=c99 -O1 -c {source}.c"));
    }
    done(&here, "g++", &format!("-std=c++17 -Wall -Wextra -Werror -Istubs -o run main.cpp {prefix}.o {prefix}_step.o"));
    let found = lines(&done(&here, &here.join("run").display().to_string(), ""));
    let gravity = torques(&model, &[0.3, -0.4], &[0.0; 2], &[0.0; 2])[0] + FRICTION[2];
    // Torques are sent in 20 cycles with states, then the last torque in 10 cycles, then none. The C code computes in single
    // precision.
    assert_eq!(found.len(), 40);
    for (i, line) in found.iter().enumerate() {
        let expected = if i < 30 { gravity } else { 0.0 };
        assert!((line[0] - expected).abs() < 1e-4, "cycle {i}: {line:?} {expected}");
        assert_eq!(
            line[1],
            if i < 20 {
                0.0
            } else if i < 30 {
                2.0
            } else {
                4.0
            },
            "cycle {i}"
        );
    }
}

#[test]
fn the_python_file_holds_the_arm_and_has_the_same_torques_and_rules() {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("skipped: there is no python3");
        return;
    }
    let model = odd();
    for (options, folder) in [(CURRENTS, "python_currents"), (GOALS, "python_goals")] {
        let here = written(&model, PackageTarget::Lerobot, options, folder);
        check_readme(&text_of(&here, "README.md"));
        let file = std::fs::read_dir(&here)
            .unwrap()
            .map(|e| e.unwrap().path())
            .find(|p| p.extension().is_some_and(|e| e == "py"));
        let file = file.unwrap();
        let said = done(&here, "python3", &format!("{} --simulate", file.display()));
        let numbers: Vec<f64> =
            said.split_whitespace().filter_map(|word| word.trim_end_matches(['.', ';']).parse().ok()).collect();
        // The printed text has the form: moved by .. in 2 s; without it by ..
        assert!(numbers[0] < 0.0175 && numbers[2] > 3.0 * numbers[0] && numbers[2] > 0.02, "{said}");
        let module = file.file_stem().unwrap().to_str().unwrap().to_string();
        std::fs::write(here.join("rules.py"), include_str!("stubs/rules.txt").replace("MODULE", &module)).unwrap();
        let found = lines(&done(&here, "python3", "rules.py"));
        let (q, dq, ddq) = ([0.3, -0.4], [0.5, 0.2], [1.0, -2.0]);
        for (found, expected) in found[0].iter().zip(torques(&model, &q, &dq, &ddq)) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
}

#[test]
fn refusals_say_what_to_do() {
    let said = |model: &Model, target, options: &str| made(model, target, options).unwrap_err().to_string();
    let without = ODD.replace("effort=\"4\"", "effort=\"0\"");
    let without = Model::parse(&without, "odd.urdf", &ModelOptions::default()).unwrap();
    let refused = said(&without, PackageTarget::Arduino, "");
    assert!(refused.contains("has no torque limit") && refused.contains("effort"), "{refused}");
    let refused = said(&odd(), PackageTarget::Lerobot, "");
    assert!(refused.contains("servos take currents or goals"), "{refused}");
    let floating = ModelOptions { floating_base: true, ..ModelOptions::default() };
    let floating = Model::parse(ODD, "odd.urdf", &floating).unwrap();
    let refused = said(&floating, PackageTarget::Ros2Control, "");
    assert!(refused.contains("a base that floats"), "{refused}");
}
