//! Tests of the output of the program: results as JSON, with the same numbers as the written files; quiet mode; colours; and a
//! robot description from standard input.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use experiments::plan::experiment_plan::ExperimentPlan;
use serde_json::Value as Json;
use tests::planar_log::{log, write_log};
use tests::program::{Run, folder, program, rist, run};
use tests::random::Random;
use tests::{model, model_path, test_robot_path};

fn path(file: &str) -> String {
    model_path(file).display().to_string()
}

/// The JSON output of a command that must end with exit code `code`.
fn json(here: &Path, arguments: &[&str], code: i32) -> Json {
    let run = rist(here, &[arguments, &["--json", "--quiet"]].concat());
    assert_eq!(run.code, Some(code), "{arguments:?}: {}", run.err);
    serde_json::from_str(&run.out).unwrap_or_else(|e| panic!("{arguments:?}: {e}: {}", run.out))
}

/// A YAML file that the program wrote, as a JSON value, without its first line.
fn artefact(file: &Path) -> Json {
    let mut artefact: Json = serde_yaml::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    // The first line has the kind, version and checksum of the file. The JSON output does not contain it.
    artefact.as_object_mut().unwrap().remove("rist");
    artefact
}

/// Compares two JSON values entry by entry. Numbers may differ by the rounding of the last digit in the JSON reader.
fn assert_same(found: &Json, expected: &Json, place: &str) {
    match (found, expected) {
        (Json::Object(a), Json::Object(b)) => {
            let keys = |o: &serde_json::Map<String, Json>| o.keys().cloned().collect::<Vec<_>>();
            assert_eq!(keys(a), keys(b), "{place}");
            a.iter().for_each(|(key, value)| assert_same(value, &b[key], &format!("{place}.{key}")));
        }
        (Json::Array(a), Json::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter().zip(b).for_each(|(a, b)| assert_same(a, b, place));
        }
        (Json::Number(a), Json::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!((a - b).abs() <= 2.0 * f64::EPSILON * b.abs(), "{place}: {a:?} {b:?}");
        }
        (a, b) => assert_eq!(a, b, "{place}"),
    }
}

/// Writes the log that most of these tests read. Returns the path of the description of its arm.
fn arm_with_log(here: &Path) -> String {
    let robot = model("planar2r_vertical.yaml");
    write_log(here, &log(&robot, &Random(3).physical_parameters(&robot)));
    test_robot_path("planar2r_vertical.yaml").display().to_string()
}

#[test]
fn estimates_and_what_follows_from_them_as_json() {
    let here = folder("terminal-estimates");
    let arm = arm_with_log(&here);
    let found = json(&here, &["identify", &arm, "log.csv", "--out", "e.yaml"], 0);
    let mut estimate = artefact(&here.join("e.yaml"));
    // The key `parameter_count` is in the file, to detect incomplete files. It is not in the JSON output.
    let count = estimate.as_object_mut().unwrap().remove("parameter_count").unwrap();
    assert_eq!(count, estimate["parameters"].as_array().unwrap().len());
    assert_same(&found["estimate"], &estimate, "estimate");
    assert_eq!(found["verdict"]["trust"], "yes");
    assert_eq!(found["verdict"]["uses"].as_array().unwrap().len(), 3);
    assert!(found["findings"].as_array().unwrap().is_empty() && found["validation"].is_null());

    let found = json(&here, &["validate", &arm, "e.yaml", "log.csv", "--out", "v.yaml", "--series", "s.parquet"], 0);
    assert_same(&found["validation"], &artefact(&here.join("v.yaml")), "validation");
    assert!(found["verdict"]["next"].is_string());
    let series = std::fs::read(here.join("s.parquet")).unwrap();
    let table = logs::Table::from_bytes("s.parquet", &series).unwrap();
    assert_eq!(table.header, ["log", "t", "measured_q1", "predicted_q1", "measured_q2", "predicted_q2"]);

    let doctor = json(&here, &["doctor", &arm, "log.csv"], 0);
    assert_eq!(doctor["logs"][0]["log"], "log.csv");
    assert_eq!(doctor["logs"][0]["joints"].as_array().unwrap().len(), 2);

    let sums = json(&here, &["accumulate", &arm, "log.csv", "--cutoff", "10", "--out", "a.tri"], 0);
    assert_eq!((&sums["logs"][0]["rows"], &sums["cutoff_hz"]), (&6000.into(), &10.0.into()));
    assert_same(&json(&here, &["merge", "a.tri", "--out", "b.tri"], 0), &sums, "merge");
    let solved = json(&here, &["solve", "b.tri"], 0);
    assert_eq!(solved["estimate"]["rows"], 2 * sums["logs"][0]["samples"].as_u64().unwrap());
    assert_eq!(solved["verdict"]["trust"], "with care");
}

#[test]
fn motions_and_findings_as_json() {
    let here = folder("terminal-motions");
    let arm = path("planar2r_vertical.yaml");
    let fast = ["--starts", "1", "--iterations", "5"];
    let motion = json(&here, &[&["excite", &arm, "--out", "m.yaml"], &fast[..]].concat(), 0);
    assert_same(&motion, &artefact(&here.join("m.yaml")), "motion");
    let checked = json(&here, &["check", &arm, "m.yaml"], 0);
    assert_eq!(checked["proven"], true);
    assert_same(&checked["certificate"], &motion["certificate"], "certificate");

    let small = ["-n", "2", "--steps", "2", "--configurations", "4", "--starts", "1"];
    let plan = json(&here, &[&["plan", &arm, "--out", "p.yaml"], &small[..]].concat(), 0);
    // If there are few experiments, a condition number is infinite. JSON writes it as null.
    let written = std::fs::read_to_string(here.join("p.yaml")).unwrap();
    let written = ExperimentPlan::from_yaml("p.yaml", &written).unwrap();
    assert_same(&plan["plan"], &serde_json::to_value(&written).unwrap(), "plan");
    let simulated = json(&here, &["simulate", &arm, "p.yaml", "--validation", "1", "--out", "logs"], 0);
    let logs: Vec<&str> = simulated["logs"].as_array().unwrap().iter().map(|l| l.as_str().unwrap()).collect();
    assert_eq!(logs, ["logs/e01.csv", "logs/e02.csv", "logs/v01.csv"]);
    assert!(logs.iter().chain([&"logs/truth.yaml"]).all(|file| here.join(file).is_file()));

    let linted = json(&here, &["lint", &path("ur5.urdf")], 0);
    assert_eq!((&linted["links"], linted["findings"][0]["subjects"][0].as_str()), (&6.into(), Some("upper_arm")));
    for command in [&["convert", &arm, "--to", "par"][..], &["completions", "bash"], &["generate", &arm]] {
        let run = rist(&here, &[command, &["--json"]].concat());
        assert_eq!((run.code, run.out.as_str()), (Some(2), ""), "{command:?}");
        assert!(run.err.starts_with("rist: --json: "), "{}", run.err);
    }
}

#[test]
fn quiet_and_colours() {
    let here = folder("terminal-words");
    let arm = path("planar2r_vertical.yaml");
    let plan = ["plan", &arm, "-n", "2", "--steps", "2", "--configurations", "4", "--starts", "1"];
    let loud = rist(&here, &plan);
    assert_eq!((loud.code, loud.err.lines().count()), (Some(0), 1), "{}", loud.err);
    let (notes, result): (Vec<&str>, Vec<&str>) = loud.out.lines().partition(|line| line.starts_with("note: "));
    assert!(!notes.is_empty());
    let quiet = rist(&here, &[&plan[..], &["-q"]].concat());
    assert_eq!((quiet.code, quiet.err.as_str()), (Some(0), ""));
    assert_eq!(quiet.out.lines().collect::<Vec<_>>(), result);
    // Output to a pipe has no colours unless the user asks for them.
    let none = rist(&here, &["inspect", "none.yaml"]);
    let colours = rist(&here, &["inspect", "none.yaml", "--color", "always"]);
    assert_eq!(colours.err, format!("\u{1b}[1m\u{1b}[31mrist:\u{1b}[0m{}", &none.err["rist:".len()..]));
}

fn fed(here: &Path, arguments: &[&str], text: &str) -> Run {
    let file = here.join("fed");
    std::fs::File::create(&file).unwrap().write_all(text.as_bytes()).unwrap();
    let input = Stdio::from(std::fs::File::open(&file).unwrap());
    run(Command::new(program()).args(arguments).current_dir(here).stdin(input))
}

#[test]
fn a_description_from_standard_input() {
    let here = folder("terminal-input");
    for (file, format) in [("race.yaml", "par"), ("ur5.urdf", "yaml")] {
        let text = std::fs::read_to_string(model_path(file)).unwrap();
        let (given, named) = (fed(&here, &["inspect", "-"], &text), rist(&here, &["inspect", &path(file)]));
        assert_eq!((given.code, given.out), (named.code, named.out), "{file}");
        let converted = rist(&here, &["convert", &path(file), "--to", format]).out;
        let name = format!("converted.{format}");
        std::fs::write(here.join(&name), &converted).unwrap();
        let (given, named) = (fed(&here, &["inspect", "-"], &converted), rist(&here, &["inspect", &name]));
        assert_eq!((given.code, given.out), (named.code, named.out), "{file} as {format}");
    }
    let broken = fed(&here, &["inspect", "-"], "links: [");
    assert!(broken.code == Some(2) && broken.err.starts_with("rist: -:1"), "{}", broken.err);
}

/// A search with a thousand starts is ended early by Ctrl-C. The best motion so far is proven and written.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_best_so_far() {
    use std::io::{BufRead, BufReader};
    let here = folder("terminal-interrupt");
    let arm = path("planar2r_vertical.yaml");
    let mut search = Command::new(program())
        .args(["excite", &arm, "--starts", "1000", "--out", "m.yaml"])
        .current_dir(&here)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told = BufReader::new(search.stderr.take().unwrap());
    let mut line = String::new();
    told.read_line(&mut line).unwrap();
    // The starts run in parallel, so any of them may end first.
    assert!(line.starts_with("start ") && line.contains(" of 1000: "), "{line}");
    let killed = Command::new("kill").args(["-INT", &search.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let rest = told.lines().count();
    assert!(search.wait().unwrap().success() && rest < 900, "{rest}");
    let motion = artefact(&here.join("m.yaml"));
    assert_eq!(motion["proven"], true);
    let said = motion["notes"].as_array().unwrap().iter().filter_map(Json::as_str).collect::<Vec<_>>().join("\n");
    assert!(said.contains("the search was interrupted: the best of ") && said.contains(" starts, of 1000"), "{said}");
    assert_eq!(rist(&here, &["check", &arm, "m.yaml"]).code, Some(0));
}
