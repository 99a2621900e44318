//! Tests that the commands lint, plan, simulate, identify (several methods), validate and report work for every robot of models/
//! without special flags. `rist identify` must read the files of `rist simulate` as they are.

use std::collections::BTreeMap;
use std::path::Path;

use identification::estimate::identified::Identified;
use linear_model::parameter::ParameterId;
use tests::program::{estimate, folder, rist, rist_done};
use tests::workspace;

/// Output of a command, which must end with exit code 0.
fn run(here: &Path, arguments: &str) -> String {
    rist_done(here, arguments).out
}

/// The relative error of a validation, %.
fn left(out: &str) -> f64 {
    let line = out.lines().find(|line| line.starts_with("all ")).unwrap_or_else(|| panic!("no total in\n{out}"));
    let share = line.split_whitespace().nth(1).and_then(|word| word.strip_suffix('%'));
    share.and_then(|share| share.parse().ok()).unwrap_or_else(|| panic!("no share in `{line}`"))
}

/// Flags for a short search. Its experiments are longer than the experiments of a good plan, but sufficient for these tests.
const PLAN: &str = "--experiments 6 --starts 1 --configurations 6 --duration 3 --out plan.yaml";
/// Largest allowed error of predicted torques, %. If the estimate is right, noise and friction at reversals give 1 to 3 %; a
/// wrong sign gives more than 20 %.
const LEFT: f64 = 6.0;

fn walk(file: &str) {
    let here = folder(&format!("shipped_{}", file.replace('.', "_")));
    let model = workspace().join("models").join(file);
    let model = model.display();
    // `rist lint` may have findings for a published description, but it must be able to read it.
    let lint = rist(&here, &["lint", &model.to_string()]);
    assert!(lint.code == Some(0) || lint.err.contains("findings"), "{file}: {}{}", lint.out, lint.err);
    run(&here, &format!("plan {model} {PLAN}"));
    run(&here, &format!("simulate {model} plan.yaml --out logs --validation 2"));
    for method in ["rist", "rist-mh"] {
        run(&here, &format!("identify {model} logs --plan plan.yaml --method {method} --out {method}.yaml"));
        let out = run(&here, &format!("validate {model} {method}.yaml logs --out {method}_validation.yaml"));
        // The rows of the method `rist` (the paper) contain some friction. So its error is tested elsewhere, on the robots of the
        // papers.
        assert!(method == "rist" || left(&out) < LEFT, "{file}, {method}: {out}");
        run(
            &here,
            &format!(
                "report --plan plan.yaml --estimate {method}.yaml --validation {method}_validation.yaml --out page.html"
            ),
        );
    }
    default_cutoff(&here, &model.to_string());
    // The program may object to these logs only because they are too short.
    for arguments in
        ["identify MODEL logs/v01.csv --out ls.yaml", "validate MODEL ls.yaml logs/v02.csv --out ls_validation.yaml"]
    {
        let arguments = arguments.replace("MODEL", &model.to_string());
        let run = rist(&here, &arguments.split_whitespace().collect::<Vec<_>>());
        let words = ["the log is too short", "the torque uncertainty is"];
        let is_short = run.code == Some(1) && words.iter().any(|said| run.out.contains(said));
        assert!(run.code == Some(0) || is_short, "{file}: rist {arguments}: {}{}", run.out, run.err);
    }
    run(&here, &format!("report --model {model} --estimate ls.yaml --validation ls_validation.yaml --out page.html"));
}

fn parameters(here: &Path, name: &str) -> BTreeMap<String, Identified> {
    let found = estimate(&here.join(name)).parameters;
    found.into_iter().map(|p| (p.id.to_string(), p)).collect()
}

/// Number of noise draws. Several are needed, because in a single draw the largest of forty errors depends mostly on chance.
const DRAWS: usize = 4;

/// Compares least squares with the default cut-off and with a cut-off of 20 Hz, on the motions of a plan. Compared is the largest
/// rms error of a parameter over the draws, in standard deviations of the fit with 20 Hz. A drive that holds a joint reacts to
/// encoder noise; so the torques contain noise up to half the sampling rate, which the filter must remove.
fn default_cutoff(here: &Path, model: &str) {
    let ways = ["", "--cutoff 20"];
    let mut squares: [BTreeMap<String, f64>; 2] = Default::default();
    for seed in 1..=DRAWS {
        run(here, &format!("simulate {model} plan.yaml --out draw_{seed} --seed {seed} --validation 0"));
        let logs: Vec<String> = (1..=6).map(|i| format!("draw_{seed}/e{i:02}.csv")).collect();
        let found = ways.map(|way| {
            run(here, &format!("identify {model} {} {way} --out ls_of_draw.yaml", logs.join(" ")));
            parameters(here, "ls_of_draw.yaml")
        });
        let truth = parameters(here, &format!("draw_{seed}/truth.yaml"));
        let at_20 = &found[1];
        for (found, squares) in found.iter().zip(&mut squares) {
            for (name, p) in found.iter().filter(|(_, p)| matches!(p.id, ParameterId::Base(_))) {
                let off = || Some((p.value? - truth[name].value?) / at_20[name].sigma?);
                *squares.entry(name.clone()).or_default() += off().map_or(0.0, |off| off * off);
            }
        }
    }
    let [found, expected] = squares.map(|squares| {
        assert!(squares.values().any(|square| *square > 0.0), "{model}: no parameter has a value");
        (squares.values().copied().fold(0.0, f64::max) / DRAWS as f64).sqrt()
    });
    // Errors below one standard deviation are only the noise of these draws.
    assert!(found < 1.5 * expected.max(1.0), "{model}: {found} deviations from the truth, {expected} with --cutoff 20");
}

/// Tests a part of the files in models/: every `of`-th file, starting with number `from`.
fn every(of: usize, from: usize) {
    let folder = workspace().join("models");
    let names = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut files: Vec<String> = names.collect();
    files.sort();
    assert!(files.len() >= 15, "models/ has lost models: {files:?}");
    files.iter().skip(from).step_by(of).for_each(|file| walk(file));
}

#[test]
fn one_half_of_the_shipped_models_walks() {
    every(2, 0);
}

#[test]
fn the_other_half_walks() {
    every(2, 1);
}
