//! Every robot of models/ goes through the whole walk by the same commands, none with a flag of its own: lint, plan,
//! simulate, identify by every method, validate, report. What simulate writes, identify reads as it is.

use std::collections::BTreeMap;
use std::path::Path;

use identification::estimate::identified::Identified;
use linear_model::parameter::ParameterId;
use tests::program::{estimate, folder, rist, rist_done};
use tests::workspace;

/// Runs a command, which must end with 0; its output.
fn run(here: &Path, arguments: &str) -> String {
    rist_done(here, arguments).out
}

/// The share of the torques that a validation leaves, %.
fn left(out: &str) -> f64 {
    let line = out.lines().find(|line| line.starts_with("all ")).unwrap_or_else(|| panic!("no total in\n{out}"));
    let share = line.split_whitespace().nth(1).and_then(|word| word.strip_suffix('%'));
    share.and_then(|share| share.parse().ok()).unwrap_or_else(|| panic!("no share in `{line}`"))
}

/// A plan that is looked for a moment only; the motions of a good one are shorter, those of this one do as well here.
const PLAN: &str = "--experiments 6 --starts 1 --configurations 6 --duration 3 --out plan.yaml";
/// Noise and what friction at reversals leaves of a right estimate is 1 to 3 %. A wrong sign leaves more than 20.
const LEFT: f64 = 6.0;

fn walk(file: &str) {
    let here = folder(&format!("shipped_{}", file.replace('.', "_")));
    let model = workspace().join("models").join(file);
    let model = model.display();
    // A published description may hold what lint names; it is read all the same.
    let lint = rist(&here, &["lint", &model.to_string()]);
    assert!(lint.code == Some(0) || lint.err.contains("findings"), "{file}: {}{}", lint.out, lint.err);
    run(&here, &format!("plan {model} {PLAN}"));
    run(&here, &format!("simulate {model} plan.yaml --out logs --validation 2"));
    for method in ["rist", "rist-mh"] {
        run(&here, &format!("identify {model} logs --plan plan.yaml --method {method} --out {method}.yaml"));
        let out = run(&here, &format!("validate {model} {method}.yaml logs --out {method}_validation.yaml"));
        // The paper's rows feel friction; they are held to their papers' robots elsewhere.
        assert!(method == "rist" || left(&out) < LEFT, "{file}, {method}: {out}");
        run(
            &here,
            &format!(
                "report --plan plan.yaml --estimate {method}.yaml --validation {method}_validation.yaml --out page.html"
            ),
        );
    }
    default_cutoff(&here, &model.to_string());
    // A motion that is right and short is the one thing that may be said against it.
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

/// Draws of the noise: of one, the largest of forty errors tells little of an estimator.
const DRAWS: usize = 4;

/// Least squares on the motions of a plan: the largest over the parameters of its error, the root of the mean square of some
/// draws, with the default cut-off and with 20 Hz, in deviations of the latter. Drives that hold a joint write the noise of
/// its encoder into the log up to half the rate.
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
    // Within one deviation an error is the noise of these draws.
    assert!(found < 1.5 * expected.max(1.0), "{model}: {found} deviations from the truth, {expected} with --cutoff 20");
}

/// The files of models/, one of `of` after another from `from` on.
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
