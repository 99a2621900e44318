//! Tests of the verdict at the end of `rist identify` and `rist validate`: mistakes are reported, and a good log is trusted.

use rist::Model;
use tests::faults::{amperes, changed, cut, each, mirrored};
use tests::joint_log::{self, JointLog, described, swinging, unlike};
use tests::program::{Run, folder, rist};
use tests::urdf_text;

/// Path and model of the UR5 in models/, and a log of a UR5 whose bodies differ slightly from the description.
fn arm() -> (String, Model, JointLog) {
    let (model, good) = joint_log::ur5();
    (model.path.display().to_string(), model, good)
}

/// The last lines of the output: the line "found:", the lines "trust:" with the reasons, and the line "next:".
fn verdict(run: &Run) -> [String; 3] {
    let lines: Vec<&str> = run.out.lines().collect();
    let place = |start: &str| {
        let found = lines.iter().rposition(|line| line.starts_with(start));
        found.unwrap_or_else(|| panic!("no `{start}`\n{}\n{}", run.out, run.err))
    };
    let (found, trust, next) = (place("found: "), place("trust: "), place("next: "));
    assert_eq!((found + 1, next + 1), (trust, lines.len()), "{}", run.out);
    assert!(lines[trust + 1..next].iter().all(|line| line.starts_with("  - ")) && next > trust + 1, "{}", run.out);
    [lines[found].into(), lines[trust..next].join("\n"), lines[next].into()]
}

/// Ten mistakes in logs that earlier versions did not report. For each, the program prints a sentence and ends with exit code 1;
/// it writes an estimate but no URDF.
#[test]
fn no_mistake_is_silent() {
    let here = folder("silent");
    let (ur5, _, good) = arm();
    std::fs::write(here.join("other.urdf"), urdf_text::random_tree(6, 1, 1)).unwrap();
    let numbers: Vec<String> = (1..7).map(|k| k.to_string()).collect();
    let mistakes: [(&str, &str, JointLog, &str); 11] = [
        (
            "off90",
            &ur5,
            changed(&good, |l| each(&mut l.q[2..3], |x| x + std::f64::consts::FRAC_PI_2)),
            "the zero of elbow is off by -90",
        ),
        ("nmm", &ur5, changed(&good, |l| each(&mut l.tau, |x| 1e3 * x)), "in another unit: 10^3 times"),
        ("amps", &ur5, amperes(&good), "the efforts are no torques of the joints: currents"),
        (
            "signall",
            &ur5,
            changed(&good, |l| each(&mut l.tau, |x| -x)),
            "the torques of all joints have the wrong sign",
        ),
        ("sign1", &ur5, mirrored(&good, 2, false, true), "the torque of elbow has the wrong sign"),
        ("qsign", &ur5, mirrored(&good, 1, true, false), "the position of shoulder_lift has the wrong sign"),
        (
            "swapped",
            &ur5,
            changed(&good, |l| {
                l.q.swap(2, 3);
                l.dq.swap(2, 3);
            }),
            "the columns of elbow and wrist_1 are swapped",
        ),
        (
            "permuted",
            &ur5,
            changed(&good, |l| [&mut l.q, &mut l.dq, &mut l.tau].into_iter().for_each(|x| x.reverse())),
            "are in another order (position, velocity and torque)",
        ),
        ("zeros", &ur5, changed(&good, |l| each(&mut l.tau, |_| 0.0)), "is not measured: it never changes"),
        ("robot", "other.urdf", good.clone(), "this log is not of the described robot"),
        ("short", &ur5, cut(&good, 0.6), "the log is too short"),
    ];
    for (name, robot, log, sentence) in mistakes {
        let (file, estimate, urdf) = (format!("{name}.csv"), format!("{name}.yaml"), format!("{name}.urdf"));
        log.write(&here.join(&file), &numbers);
        let run = rist(&here, &["identify", robot, &file, "--out", &estimate, "--write-urdf", &urdf]).ended(1);
        let last = verdict(&run);
        assert!(last[1].starts_with("trust: no\n") && last[1].contains(sentence), "{name}: {last:?}");
        assert!(run.err.contains("not to be trusted") && run.err.contains("--anyway"), "{name}: {}", run.err);
        assert!(here.join(&estimate).is_file() && !here.join(&urdf).exists(), "{name}");
        rist(&here, &["doctor", robot, &file]).told(1, &[sentence]);
    }
    let anyway = ["identify", &ur5, "sign1.csv", "--write-urdf", "sign1.urdf", "--anyway"];
    assert_eq!(rist(&here, &anyway).code, Some(1));
    assert!(here.join("sign1.urdf").is_file());
}

#[test]
fn a_good_log_is_trusted() {
    let here = folder("trusted");
    let (ur5, model, good) = arm();
    good.write_for(&model, &here.join("a.csv"));
    rist(&here, &["doctor", &ur5, "a.csv"]).told(0, &["nothing is contradicted", "brakes"]);

    // Ten repetitions of a motion of three seconds count as one motion.
    let short = cut(&good, 3.0);
    let periods = |x: &Vec<f64>| (0..10).flat_map(|_| x.iter().copied()).collect::<Vec<f64>>();
    let again = changed(&short, |l| {
        l.t = (0..10 * short.t.len()).map(|i| short.t[0] + i as f64 * (short.t[1] - short.t[0])).collect();
        l.q.iter_mut().chain(&mut l.dq).chain(&mut l.tau).for_each(|x| *x = periods(x));
    });
    again.write_for(&model, &here.join("periods.csv"));
    let alone = rist(&here, &["identify", &ur5, "periods.csv"]);
    let found = verdict(&alone);
    assert!(!found[1].starts_with("trust: yes"), "{found:?}");
    let other = swinging(&model.robot, &unlike(&model.robot, 5), 0.8, 0.0);
    other.write_for(&model, &here.join("b.csv"));
    let write = ["--consistent", "--write-urdf", "w.urdf", "--out", "e.yaml", "--validate", "b.csv"];
    let run = rist(&here, &[&["identify", &ur5, "a.csv"], &write[..]].concat()).ended(0);
    let found = verdict(&run);
    assert!(found[1].starts_with("trust: yes\n"), "{found:?}");
    let percent = |line: &str, behind: &str| -> f64 {
        let rest = line.split(behind).nth(1).unwrap_or_else(|| panic!("no `{behind}` in {line}"));
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    let description = percent(&found[0], "relative residual of this log: ");
    let identified = percent(&found[0], "with the nominal parameters, ");
    // The parameters differ by up to 15 % in both directions; noise of 0.1 N m is small compared with torques of tens of N m.
    assert!((0.5..15.0).contains(&description) && identified < 0.5 * description, "{found:?}");
    assert!(here.join("w.urdf").is_file());

    let validated = rist(&here, &["validate", &ur5, "e.yaml", "b.csv"]).ended(0);
    assert!(verdict(&validated)[1].starts_with("trust: yes\n"), "{}", validated.out);
    let backwards = changed(&good, |l| each(&mut l.tau, |x| -x));
    backwards.write_for(&model, &here.join("c.csv"));
    let refused = rist(&here, &["validate", &ur5, "e.yaml", "c.csv"]).ended(1);
    assert!(verdict(&refused)[1].contains("wrong sign"), "{}", refused.out);
}

/// If several logs are fitted, each is predicted from the other logs. A small prediction error is a reason for the verdict yes.
/// This needs different motions. If the logs are from two different robots, they contradict each other.
#[test]
fn logs_of_one_fit_predict_each_other() {
    let here = folder("together");
    let (ur5, model, good) = arm();
    let names = model.regressor().coordinates();
    let own = unlike(&model.robot, 5);
    let heavy: Vec<f64> = own.iter().map(|x| 1.4 * x).collect();
    let files = [
        ("a.csv", good.clone()),
        ("b.csv", swinging(&model.robot, &own, 0.8, 0.0)),
        ("heavy.csv", swinging(&model.robot, &heavy, 0.8, 0.0)),
        ("again.csv", changed(&good, |l| each(&mut l.tau, |x| x + 1e-3))),
    ];
    files.iter().for_each(|(name, log)| log.write(&here.join(name), names));
    let trust = |logs: &[&str]| verdict(&rist(&here, &[&["identify", &ur5], logs].concat()))[1].clone();
    let predicted = "relative residual of each log, predicted by parameters from the others: ";
    let alone = trust(&["a.csv"]);
    assert!(!alone.contains(predicted), "{alone}");
    let together = trust(&["a.csv", "b.csv"]);
    assert!(together.starts_with("trust: yes") && together.contains(predicted), "{together}");
    let repeated = trust(&["a.csv", "again.csv"]);
    assert!(!repeated.contains(predicted) && !repeated.contains("contradict"), "{repeated}");
    assert!(!together.contains("contradict"), "{together}");
    let each = "each log is predicted by parameters from the others";
    let printed = |logs: &[&str]| rist(&here, &[&["identify", &ur5], logs].concat()).out.contains(each);
    assert!(printed(&["a.csv", "b.csv"]) && !printed(&["a.csv"]));
    let apart = trust(&["a.csv", "heavy.csv"]);
    assert!(!apart.starts_with("trust: yes"), "{apart}");
    assert!(apart.contains("the logs contradict each other") && apart.contains(" of its torque"), "{apart}");
}

/// A common factor of all torques is mentioned in a remark only if the description cannot exclude such a factor. Three cases: the
/// bodies are wrong by 15 % (the factor is bounded); there are no bodies (any factor is possible); the description is exact (no
/// remark).
#[test]
fn a_factor_of_all_torques_is_said_where_it_counts() {
    let here = folder("units");
    let (ur5, model, _) = arm();
    let robot = &model.robot;
    let text = tests::model_text("ur5.urdf");
    let bare: String = text.split("<inertial>").map(|part| part.split("</inertial>").last().unwrap()).collect();
    std::fs::write(here.join("bare.urdf"), bare).unwrap();
    let logs = |x: &[f64], name: &str| {
        [1.2, 0.8].map(|a| {
            let file = format!("{name}_{a}.csv");
            swinging(robot, x, a, 0.0).write_for(&model, &here.join(&file));
            file
        })
    };
    let [other, exact] = [logs(&unlike(robot, 5), "other"), logs(&described(robot), "exact")];
    let scale = "in the units of the torques as logged: a factor";
    for (model, [a, b], said) in
        [(&ur5[..], &other, Some("below ")), ("bare.urdf", &other, Some("that all")), (&ur5, &exact, None)]
    {
        let run = rist(&here, &["identify", model, a, "--validate", b]);
        let trust = verdict(&run)[1].split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(trust.starts_with("trust: yes"), "{model} {a}: {}", run.out);
        let found = trust.split_once(scale).map(|(_, rest)| rest.trim_start());
        assert_eq!(found.is_some(), said.is_some(), "{model} {a}: {trust}");
        assert!(found.zip(said).is_none_or(|(found, said)| found.starts_with(said)), "{model} {a}: {trust}");
    }
}

/// The fitted log is from a robot that is heavier than its description. Then the description predicts a log of the real robot
/// better than the estimate does. The verdict of `validate` uses the error on the new log and not the residual of the fit.
#[test]
fn a_validation_judges_its_own_residual() {
    let here = folder("another_robot");
    let (ur5, model, _) = arm();
    let names = model.regressor().coordinates();
    let described = described(&model.robot);
    let heavy: Vec<f64> = described.iter().map(|x| 1.4 * x).collect();
    swinging(&model.robot, &heavy, 1.2, 0.0).write(&here.join("a.csv"), names);
    swinging(&model.robot, &described, 0.8, 0.0).write(&here.join("b.csv"), names);
    assert!(rist(&here, &["identify", &ur5, "a.csv", "--out", "e.yaml"]).out.contains("the residual "));
    let run = rist(&here, &["validate", &ur5, "e.yaml", "b.csv"]);
    let found = verdict(&run);
    assert_eq!(run.code, Some(1), "{found:?}");
    assert!(found[1].starts_with("trust: no\n  - the description predicts the other log better"), "{found:?}");
    assert!(!run.out.contains("the residual "), "{}", run.out);
}

#[test]
fn a_fitted_log_validates_nothing() {
    let here = folder("fitted");
    let (ur5, model, good) = arm();
    good.write_for(&model, &here.join("a.csv"));
    assert_eq!(rist(&here, &["identify", &ur5, "a.csv", "--out", "e.yaml"]).code, Some(0));
    let run = rist(&here, &["validate", &ur5, "e.yaml", "./a.csv"]);
    let found = verdict(&run);
    assert!(run.err.contains("the estimate was fitted to it"), "{}", run.err);
    assert!(found[1].contains("no motion was predicted but the one that was fitted"), "{found:?}");
    assert!(found[2].contains("a log of another motion"), "{found:?}");
}

#[test]
fn a_refused_estimate_makes_no_code() {
    let here = folder("refused");
    let (ur5, model, good) = arm();
    let degrees = changed(&good, |l| each(&mut l.q[2..3], |x| x + 1.0));
    degrees.write_for(&model, &here.join("a.csv"));
    assert_eq!(rist(&here, &["identify", &ur5, "a.csv", "--out", "e.yaml"]).code, Some(1));
    let generate = ["generate", &ur5, "--estimate", "e.yaml", "--out", "x.rs"];
    rist(&here, &generate).failed(1, &["e.yaml: not to be trusted: the zero of elbow", "--anyway"]);
    assert!(!here.join("x.rs").exists());
    assert_eq!(rist(&here, &[&generate[..], &["--anyway"]].concat()).code, Some(0));
    assert!(here.join("x.rs").exists());
}

/// Drive gains that are wrong by a common factor give masses that are wrong by this factor. The comparison with the description
/// shows this, and the verdict proposes the gains that agree with the description.
#[test]
fn wrong_gains_are_named_with_those_that_fit() {
    let here = folder("gains");
    let (ur5, model, good) = arm();
    let names = model.regressor().coordinates();
    // Currents of drives with 10 N m/A; `sign` is the sign of the current of the elbow.
    let write = |file: &str, sign: f64| {
        let currents = changed(&good, |l| {
            each(&mut l.tau, |x| x / 10.0);
            each(&mut l.tau[2..3], |x| sign * x);
        });
        currents.write_for(&model, &here.join(file));
        let text = std::fs::read_to_string(here.join(file)).unwrap();
        std::fs::write(here.join(file), text.replace("tau", "i")).unwrap();
    };
    write("a.csv", 1.0);
    let with = |gain: f64| {
        let gains: Vec<String> = names.iter().map(|name| format!("{name}={gain}")).collect();
        rist(&here, &["identify", &ur5, "a.csv", "--gain", &gains.join(",")])
    };
    for (gain, trust) in [(10.0, "yes"), (30.0, "no"), (60.0, "no")] {
        let run = with(gain);
        let found = verdict(&run);
        assert!(found[1].starts_with(&format!("trust: {trust}\n")), "{gain}: {found:?}");
        assert_eq!(run.code, Some(i32::from(trust == "no")), "{gain}");
        if trust == "no" {
            assert!(found[1].contains("the drive gains are"), "{found:?}");
            let told = found[2].split("elbow=").nth(1).unwrap_or_else(|| panic!("{found:?}"));
            let told: f64 = told.split(',').next().unwrap().parse().unwrap();
            // The bodies of the simulated robot differ from the model file by up to 15 %.
            assert!((told / 10.0 - 1.0).abs() < 0.2, "{told}");
        }
    }
    // A drive with reversed current sign has a negative gain.
    write("reversed.csv", -1.0);
    let gains = |of_elbow: f64| {
        let gain = |name: &String| format!("{name}={}", if name == "elbow" { of_elbow } else { 10.0 });
        names.iter().map(gain).collect::<Vec<_>>().join(",")
    };
    let run = rist(&here, &["identify", &ur5, "reversed.csv", "--gain", &gains(-10.0)]);
    assert_eq!(verdict(&run), verdict(&with(10.0)));
    assert_eq!(rist(&here, &["doctor", &ur5, "reversed.csv", "--gain", &gains(-10.0)]).code, Some(0));
    rist(&here, &["identify", &ur5, "reversed.csv", "--gain", &gains(0.0)]).failed(2, &["a number that is not 0"]);
    let doctor = rist(&here, &["doctor", &ur5, "a.csv"]);
    assert!(doctor.out.contains("currents without gains") && doctor.out.contains("nothing is contradicted"));
}

#[test]
fn very_late_torques_are_named() {
    let here = folder("late");
    let (ur5, model, _) = arm();
    for late in [0.05, 0.1] {
        let log = swinging(&model.robot, &unlike(&model.robot, 5), 1.2, late);
        log.write_for(&model, &here.join("a.csv"));
        rist(&here, &["doctor", &ur5, "a.csv"]).told(1, &["later than the positions"]);
        let run = rist(&here, &["identify", &ur5, "a.csv", "--delay", "auto", "--json"]);
        let found: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        assert!((found["delay_s"].as_f64().unwrap() - late).abs() < 1e-3, "{late}: {}", found["delay_s"]);
    }
}

/// The advice in the line "next:" can be followed. Writing a URDF is advised only if `--write-urdf` succeeds.
#[test]
fn the_next_step_works() {
    let here = folder("next");
    let (ur5, model, good) = arm();
    let shipped = tests::workspace().join("docs/ur5/log.csv").display().to_string();
    good.write_for(&model, &here.join("good.csv"));
    for log in [shipped.as_str(), "good.csv"] {
        let command = ["identify", &ur5, log];
        let [_, trust, next] = verdict(&rist(&here, &command));
        assert!(
            trust.starts_with("trust: yes") && !next.contains("write-urdf") && next.contains("--consistent"),
            "{next}"
        );
        let [.., next] = verdict(&rist(&here, &[&command[..], &["--consistent"]].concat()));
        let written = rist(&here, &[&command[..], &["--write-urdf", "new.urdf"]].concat());
        assert_eq!(next.contains("write-urdf"), written.code == Some(0), "{log}: {next}\n{}", written.err);
        assert!(next.contains("rist generate"), "{next}");
    }
}
