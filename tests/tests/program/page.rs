//! Tests of the HTML page of an identification and of the data sheet of a robot: they show the numbers of the estimate, load
//! nothing from the network, and stay small for long logs.

use tests::planar_log::write_rubbed;
use tests::program::{LIMITED_ARM, folder, rist};
use tests::{has, model_path};

/// The page without its JSON data, because the data may contain any letters.
fn shown(page: &str) -> String {
    let mut parts = page.split("<script type=\"application/json\"");
    let first = parts.next().unwrap();
    let behind = parts.map(|part| part.split_once("</script>").unwrap().1);
    std::iter::once(first).chain(behind).collect()
}

#[test]
fn a_log_becomes_a_page_and_a_series() {
    let here = folder("page");
    let arm = write_rubbed(&here.join("a <b>.csv"), 0.4);
    let made = ["--report", "page.html", "--series", "torques.csv", "--out", "e.yaml", "--date", "1 April 2026"];
    rist(&here, &[&["identify", &arm, "a <b>.csv"], &made[..]].concat()).ended(0);
    let page = std::fs::read_to_string(here.join("page.html")).unwrap();
    // For each of two joints: torque, residual, parts, friction, spectrum and autocorrelation. There are three more pictures: the
    // robot, the correlation map and the clip paths.
    assert_eq!(page.matches("<svg").count(), 12 + 3);
    let parts = ["Trust it", "1 April 2026", "a &lt;b&gt;.csv", "upper arm (joint 1)", "ZZR1 = ZZ1 + IA1 + L1^2*M2"];
    has(&page, &parts);
    assert!(!page.contains("could not be made") && !shown(&page).contains("NaN") && !page.contains("a <b>"));
    assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count(), "it loads something");
    // A page that `rist report` makes from the estimate has the same charts.
    rist(&here, &["report", "--model", &arm, "--estimate", "e.yaml", "--out", "b.html", "--date", "1 April 2026"])
        .ended(0);
    let again = std::fs::read_to_string(here.join("b.html")).unwrap();
    let charts = |page: &str| {
        page.split("<svg").skip(1).map(|s| s.split("</svg>").next().unwrap_or("").to_string()).collect::<Vec<_>>()
    };
    assert!(charts(&page) == charts(&again), "the charts differ");

    // The fitted model is exact, so predicted and measured torques must agree.
    let series = std::fs::read_to_string(here.join("torques.csv")).unwrap();
    let mut lines = series.lines();
    let expected = "log,t,measured_q1,predicted_q1,measured_q2,predicted_q2";
    assert_eq!(lines.next(), Some(expected));
    let (mut left, mut whole) = (0.0, 0.0);
    for line in lines {
        // The first two cells are the log name, without a comma, and the time. Cells of rows that are not fitted are empty.
        let cells: Vec<Option<f64>> = line.split(',').skip(2).map(|x| x.parse().ok()).collect();
        for pair in cells.chunks(2) {
            if let [Some(measured), Some(predicted)] = pair {
                left += (measured - predicted).powi(2);
                whole += measured * measured;
            }
        }
    }
    // The filter smooths the jumps of the friction torque, so the tolerance is 1 %.
    assert!(left.sqrt() < 0.01 * whole.sqrt(), "{left} {whole}");
}

#[test]
fn a_sheet_in_every_language() {
    let here = folder("sheet");
    let arm = model_path("race.yaml").display().to_string();
    let of = |format: &str| {
        let run = rist(&here, &["inspect", &arm, "--format", format]).ended(0);
        assert!(!run.out.contains("could not be made"), "{}", run.out);
        run.out
    };
    // The lines are at most 80 characters long. Only a longer word could exceed this, but the rules of this robot have no such
    // word.
    assert!(of("text").lines().all(|line| line.chars().count() <= 80));
    assert!(of("markdown").contains("| ZZR4 | 0.065 kg m^2 |"));
    let latex = of("latex");
    assert_eq!(latex.matches("\\\\\n").count(), 18 + 2);
    let html = of("html");
    assert!(html.contains("id=\"base-ZZR4\"") && !html.contains("http"));
    // The standard parameter YY10 is a term of the base parameters ZZR1 and XXR4.
    let json: serde_json::Value = serde_json::from_str(&of("json")).unwrap();
    let holds = |b: &&serde_json::Value| b["terms"].as_array().unwrap().iter().any(|t| t["parameter"] == "YY10");
    let holders: Vec<_> = json["base"].as_array().unwrap().iter().filter(holds).map(|b| &b["name"]).collect();
    assert_eq!(holders, ["ZZR1", "XXR4"]);
    let fate = html.split("<code>YY10</code></td><td>").nth(1).unwrap().split("</td>").next().unwrap();
    assert!(fate.contains("ZZR1") && fate.contains("XXR4"), "{fate}");
    assert!((json["links"][2]["geometry"]["d"]["number"].as_f64().unwrap() - 0.3).abs() < 1e-12);
}

#[test]
fn a_plan_has_a_picture_a_motion() {
    let here = folder("plan_page");
    let arm = model_path("planar2r_vertical.yaml").display().to_string();
    assert_eq!(rist(&here, &["plan", &arm, "--out", "plan.yaml"]).code, Some(0));
    assert_eq!(rist(&here, &["report", "--plan", "plan.yaml", "--out", "page.html"]).code, Some(0));
    let text = |file: &str| std::fs::read_to_string(here.join(file)).unwrap();
    let plan: serde_json::Value = serde_yaml::from_str(&text("plan.yaml")).unwrap();
    let (page, experiments) = (text("page.html"), plan["experiments"].as_array().unwrap());
    assert!(experiments.len() > 2);
    for experiment in experiments {
        let name = experiment["name"].as_str().unwrap();
        assert!(page.contains(&format!("<title>Motion {name}</title>")), "{name} has no picture");
    }
    assert_eq!(page.matches("<svg").count(), experiments.len());
    assert!(page.contains("<h1><span class=\"kind\">Plan of experiments</span>"), "{page}");
    // The picture of every experiment names every joint.
    for joint in plan["coordinates"].as_array().unwrap() {
        let named = format!(">{}<", joint.as_str().unwrap());
        let rests = format!(">{} (rests)<", joint.as_str().unwrap());
        assert!(page.matches(&named).count() + page.matches(&rests).count() >= experiments.len(), "{named}");
    }
}

/// If the model is given, the page of a plan proves the plan again; without the model, it quotes the claim of the file. If the
/// claim was changed by hand, the page says that it is broken.
#[test]
fn a_page_proves_a_plan_or_says_who_claims() {
    let here = folder("plan_proof_page");
    std::fs::write(here.join("arm.yaml"), LIMITED_ARM).unwrap();
    let arm = "arm.yaml".to_string();
    let plan =
        ["plan", &arm, "-n", "6", "--starts", "2", "--nodes", "60", "--configurations", "8", "--out", "plan.yaml"];
    assert_eq!(rist(&here, &plan).code, Some(0));
    let page = |plan: &str, model: &[&str]| {
        rist(&here, &[&["report", "--plan", plan, "--out", "page.html"], model].concat()).ended(0);
        std::fs::read_to_string(here.join("page.html")).unwrap()
    };
    let (quoted, proved) = (page("plan.yaml", &[]), page("plan.yaml", &["--model", &arm]));
    assert!(quoted.contains("The file says that the plan is at least") && !quoted.contains("Found again"));
    assert!(proved.contains("Found again from the plan and the model: proven again: D-efficiency at least"));
    assert!(
        proved.contains(": proven, between samples too: position of ") && !proved.contains("says that the plan is at")
    );
    assert!(!proved.contains("class=\"unproven\""));
    let text = std::fs::read_to_string(here.join("plan.yaml")).unwrap();
    let line = text.lines().find(|line| line.starts_with("d_efficiency_at_least: ")).unwrap();
    std::fs::write(here.join("more.yaml"), text.replace(line, "d_efficiency_at_least: 0.9999999")).unwrap();
    let more = page("more.yaml", &["--model", &arm]);
    assert!(more.contains("class=\"unproven\">Found again") && more.contains("BROKEN: the file says D-efficiency"));
}

/// The page of a motion draws each coordinate within its limits, and the path of the tip, and lists every parameter. `rist
/// report` draws the same charts. If the file is changed by hand so that a limit is exceeded, the page reports it.
#[test]
fn a_motion_is_drawn_within_its_limits() {
    let here = folder("motion_page");
    let arm = model_path("ur5.urdf").display().to_string();
    std::fs::write(here.join("limits.yaml"), "all: {power: 60}\ncoordinates: {wrist_3: {locked: 0.3}}\n").unwrap();
    let quick =
        ["--limits", "limits.yaml", "--starts", "1", "--iterations", "4", "--period", "5", "--repetitions", "1"];
    let files = ["--out", "motion.yaml", "--report", "page.html", "--date", "1 April"];
    rist(&here, &[&["excite", &arm], &quick[..], &files].concat()).ended(0);
    let text = |file: &str| std::fs::read_to_string(here.join(file)).unwrap();
    let page = text("page.html");
    // Position, velocity, acceleration, jerk, torque and power of six joints; three projections of the path; the robot and the
    // clip paths.
    assert_eq!(page.matches("<svg").count(), 6 * 6 + 3 + 2);
    assert!(
        !page.contains("could not be made") && !shown(&page).contains("NaN") && !page.contains("NOT proven"),
        "{page}"
    );
    assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count(), "it loads something");
    let parts = ["1 April", "Path of tool0", "locked at 0.3000", "not visible (locked: wrist_3)", "power of elbow"];
    let told =
        ["proven, between samples too: position of 6", "found from the motion and the model", "proven nowhere beyond"];
    for part in parts.iter().chain(&told) {
        assert!(page.contains(part), "{part}");
    }
    let motion: serde_json::Value = serde_yaml::from_str(&text("motion.yaml")).unwrap();
    let mut rest = page.split("Predicted accuracy").nth(1).unwrap();
    for parameter in motion["parameters"].as_array().unwrap() {
        let name = format!("<code>{}</code>", parameter["name"].as_str().unwrap());
        rest = rest.split_once(&name).unwrap_or_else(|| panic!("{name} is missing, or not in the order of the file")).1;
    }

    let drawn = |page: &str| -> Vec<String> {
        page.split("<svg").skip(1).map(|s| s.split("</svg>").next().unwrap().to_string()).collect()
    };
    let report = ["report", "--motion", "motion.yaml", "--out", "again.html"];
    rist(&here, &[&report[..], &["--model", &arm, "--svg", "pictures"]].concat()).ended(0);
    assert!(drawn(&page) == drawn(&text("again.html")), "the charts differ");
    assert_eq!(std::fs::read_dir(here.join("pictures")).unwrap().count(), 6 * 6 + 3);

    // Without a model the page shows only the data of the motion file, and says that the certificate was not proven again.
    assert_eq!(rist(&here, &report).code, Some(0));
    assert_eq!(drawn(&text("again.html")).len(), 6 * 4 + 1);
    let again = text("again.html");
    assert!(again.contains("The file says: proven, between samples too: ") && !again.contains("found from the motion"));
    for said in ["encoder zero: assumed 0", "and no safety function"] {
        assert!(page.contains(said) && again.contains(said), "{said}");
    }

    let broken = text("motion.yaml").replacen("centre: ", "centre: 9 # ", 1);
    std::fs::write(here.join("broken.yaml"), broken).unwrap();
    rist(&here, &["report", "--motion", "broken.yaml", "--model", &arm, "--out", "broken.html"]).ended(0);
    let said = ["BROKEN: position of shoulder_pan", "BEYOND its limit", "position of shoulder_pan: "];
    said.iter().for_each(|said| assert!(text("broken.html").contains(said), "{said}"));
    let run =
        rist(&here, &["report", "--motion", "motion.yaml", "--model", &model_path("race.yaml").display().to_string()]);
    assert!(run.code == Some(2) && run.err.contains("motion.yaml"), "{}", run.err);
}

/// The page of the UR5 in the README must be small enough to send by mail. Its size without pictures and script is bounded.
#[test]
fn the_page_of_the_ur5_is_small() {
    /// Size of an earlier version of the page, which contained only pictures, bytes.
    const PICTURES: usize = 390_165;
    let here = folder("page_of_ur5");
    let (arm, log) = (model_path("ur5.urdf"), tests::workspace().join("docs/ur5/log.csv"));
    let (arm, log) = (arm.display().to_string(), log.display().to_string());
    rist(&here, &["identify", &arm, &log, "--out", "e.yaml", "--report", "ur5.html"]).ended(0);
    let page = std::fs::read_to_string(here.join("ur5.html")).unwrap();
    assert!(page.len() <= PICTURES + 400_000, "{}", page.len());
    let scripts: Vec<&str> = page.split("<script>").skip(1).map(|s| s.split("</script>").next().unwrap()).collect();
    assert!(scripts.len() == 1 && scripts[0].len() <= 20_000, "{} {}", scripts.len(), scripts[0].len());
    for part in ["description", "identified", "residual", "1980", "gravity compensation", "Robot animation"] {
        assert!(shown(&page).contains(part), "{part}");
    }
}

#[test]
fn two_estimates_are_compared() {
    let here = folder("compared");
    for (file, viscous) in [("a", 0.4), ("b", 0.5)] {
        let arm = write_rubbed(&here.join(format!("{file}.csv")), viscous);
        let (log, out) = (format!("{file}.csv"), format!("{file}.yaml"));
        assert_eq!(rist(&here, &["identify", &arm, &log, "--out", &out]).code, Some(0));
    }
    rist(&here, &["report", "--estimate", "a.yaml", "--against", "b.yaml", "--out", "page.html"]).ended(0);
    let page = std::fs::read_to_string(here.join("page.html")).unwrap();
    let (_, table) = page.split_once("<table class=\"compared\">").unwrap();
    // The two estimates differ only in the viscous friction of both joints, by 0.1. So these parameters are at the top of the
    // table.
    let first: Vec<&str> = table.split("<code>").skip(1).take(2).map(|row| row.split('<').next().unwrap()).collect();
    assert!(first.contains(&"FV1") && first.contains(&"FV2"), "{first:?}");
    assert!(page.contains("Two estimates compared") && page.contains("Comparison with b.yaml"));
    let edited = std::fs::read_to_string(here.join("b.yaml")).unwrap().replacen("fingerprint: ", "fingerprint: 0", 1);
    std::fs::write(here.join("c.yaml"), edited).unwrap();
    rist(&here, &["report", "--estimate", "a.yaml", "--against", "c.yaml"]).failed(2, &["do not mean the same"]);

    rist(&here, &["report", "--validation", "v.yaml", "--against", "b.yaml"]).failed(2, &["--estimate"]);
}
