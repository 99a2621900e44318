//! Motions that are asked for within limits that may leave none.

use serde_json::Value;

use super::arms::Arm;
use super::case::{Case, Command, written};
use super::obedience::merge;
use crate::program::{Run, folder, rist};
use crate::random_situations::draw::Draw;

/// What is limited, and words of a refusal that names it.
const KINDS: [(&str, &[&str]); 8] = [
    ("none", &[]),
    ("floor", &["floor"]),
    ("distance", &[" and ", "distance"]),
    ("wall", &["wall"]),
    ("box", &["box"]),
    ("narrow", &["limit of", "tells the parameters apart"]),
    ("effort", &["effort"]),
    ("margins", &["margin", "encoder", "tracking"]),
];

pub const COMMAND: Command = Command { word: "excite", case, findings, obeyed };

fn case(seed: u64, arms: &[Arm]) -> Case<'_> {
    let draw = &mut Draw::of(seed, 1);
    let (name, says) = KINDS[(seed % KINDS.len() as u64) as usize];
    let arm = &arms[draw.below(arms.len())];
    let size = draw.log(0.02, 0.5);
    let joint = &arm.names()[draw.below(arm.n())];
    let reach = draw.uniform(0.2, 1.2);
    let limits = match name {
        "floor" => format!("space: {{floor: {}}}", draw.uniform(-0.5, 0.3)),
        "distance" => format!("space: {{distance: {size}}}"),
        "wall" => format!("space: {{walls: [{{point: [{reach}, 0, 0], normal: [-1, 0, 0]}}]}}"),
        "box" => format!("space: {{boxes: [{{low: [{0}, {0}, {0}], high: [{reach}, {reach}, 2]}}]}}", -reach),
        "narrow" => format!("coordinates: {{{joint}: {{position: [0, {}]}}}}", 1e-2 * size),
        "margins" => format!("margins: {{encoder_zero: {}}}", 0.2 * size),
        _ => "{}".to_string(),
    };
    let [limits, motion] =
        [written("limits.yaml", &limits), folder("remedies").join("motion.yaml").display().to_string()];
    let search = ["--limits", &limits, "--starts", "2", "--iterations", "20", "--out", &motion].map(String::from);
    let mut words = [vec!["excite".into(), arm.path.display().to_string()], search.to_vec(), arm.flags()].concat();
    if name == "effort" {
        words.extend(["--effort-share".to_string(), size.to_string()]);
    }
    // Where there is a motion, there is nothing to say.
    let is_right = move |text: &str| !text.contains("no motion") || says.iter().any(|words| text.contains(words));
    Case { arm, kind: name, is_right: Box::new(is_right), is_above: name != "none", words, clean: None }
}

/// Motions that are not proven, or that `rist check` does not take.
fn findings(case: &Case, run: &Run) -> Vec<String> {
    if run.code != Some(0) {
        return vec![run.err.trim().to_string()];
    }
    let words = ["check", &case.words[1], word(case, "--out"), "--limits", word(case, "--limits")];
    let flags = case.arm.flags();
    let words: Vec<&str> = words.into_iter().chain(flags.iter().map(String::as_str)).collect();
    let check = rist(&folder("remedies"), &words);
    if check.code == Some(0) { vec![] } else { vec![format!("rist check: {}", check.err.trim())] }
}

/// Puts the lines that were tried into the file of limits.
fn obeyed(case: &Case, finding: &str) -> Option<Result<Vec<String>, String>> {
    let (_, remedy) = finding.split_once("tried, and a motion is proven: ")?;
    let path = word(case, "--limits");
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut limits: Value = serde_yaml::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"));
    if remedy.contains("space without `distance") {
        limits["space"].as_object_mut().map(|space| space.remove("distance"));
    } else {
        let begin = ["coordinates: {", "space: {"].iter().filter_map(|key| remedy.find(key)).min()?;
        let yaml = remedy[begin..].split_once(" in --limits").map_or(&remedy[begin..], |(yaml, _)| yaml);
        match serde_yaml::from_str::<Value>(yaml) {
            Ok(more) => merge(&mut limits, more),
            Err(_) => return Some(Err(format!("`{yaml}` is no file of limits"))),
        }
    }
    let obeyed = written("obeyed.yaml", &limits.to_string());
    Some(Ok(case.words.iter().map(|word| if word == path { obeyed.clone() } else { word.clone() }).collect()))
}

fn word<'a>(case: &'a Case, flag: &str) -> &'a str {
    case.words.iter().position(|word| word == flag).map_or("", |k| &case.words[k + 1])
}
