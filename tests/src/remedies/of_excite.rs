//! Tests `rist excite`: it must find a motion, or name the limit that allows no motion.
//!
//! Each case is a robot with limits of one kind, which may be too narrow for a motion. They are in the file of limits, as a
//! user would write it.

use serde_json::Value;

use super::arms::Arm;
use super::case::{Case, Command, Told, written};
use super::obedience::merge;
use super::of_lint::{Element, text_of};
use crate::program::{Run, folder, rist};
use crate::random_situations::draw::Draw;

/// For each kind: what is limited, and phrases of an error message that name this limit.
const KINDS: [(&str, &[&str]); 8] = [
    ("none", &[]),
    ("floor", &["floor"]),
    ("distance", &[" and ", "distance"]),
    ("wall", &["wall"]),
    ("box", &["box"]),
    ("narrow", &["limit of", "separates the parameters"]),
    ("effort", &["effort"]),
    ("margins", &["the errors of margins"]),
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
        "floor" => format!("space: {{floor: {}}}", draw.uniform(-0.4, 0.6)),
        "distance" => format!("space: {{distance: {size}}}"),
        "wall" => {
            let normal = ["[-1, 0, 0]", "[0, 0, -1]", "[0, 1, 0]"][draw.below(3)];
            format!("space: {{walls: [{{point: [{size}, 0, {size}], normal: {normal}}}]}}")
        }
        "box" => format!("space: {{boxes: [{{low: [{0}, {0}, {0}], high: [{reach}, {reach}, 2]}}]}}", -0.5 * size),
        "narrow" => format!("coordinates: {{{joint}: {{position: [0, {}]}}}}", size.powi(8)),
        "margins" => format!("margins: {{encoder_zero: {}}}", 0.2 * size),
        _ => "{}".to_string(),
    };
    let [limits, motion] =
        [written("limits.yaml", &limits), folder("remedies").join("motion.yaml").display().to_string()];
    let search = ["--limits", &limits, "--starts", "2", "--iterations", "20", "--out", &motion].map(String::from);
    let robot = written("robot.urdf", &with_shapes(arm));
    let mut words = [vec!["excite".into(), robot], search.to_vec(), arm.flags()].concat();
    if name == "effort" {
        words.extend(["--effort-share".to_string(), size.to_string()]);
    }
    // If a motion is found, no finding is expected.
    let is_right = move |text: &str| !text.contains("rist: ") || says.iter().any(|words| text.contains(words));
    Case { arm, kind: name, is_right: Box::new(is_right), is_above: name != "none", words, clean: None }
}

/// The description with other collision shapes: each link has a cube around its centre of mass, with the volume of water of the
/// link's mass.
fn with_shapes(arm: &Arm) -> String {
    let mut text = text_of(arm, "<collision", "</collision>");
    for link in Element::all(&text.clone(), "link") {
        let edge = (link.number(&text, "mass", "value") / 1000.0).cbrt();
        let [x, y, z] = link.centre(&text);
        let shape = format!(
            "<collision><origin xyz=\"{x} {y} {z}\"/><geometry><box size=\"{edge} {edge} {edge}\"/></geometry></collision>"
        );
        if edge > 0.0 {
            link.append(&mut text, &shape);
        }
    }
    text
}

/// The findings of a run: error messages, motions that are not proven, and motions that `rist check` does not accept.
fn findings(words: &[String], run: &Run) -> Vec<String> {
    if run.code != Some(0) {
        return vec![run.err.trim().to_string()];
    }
    let locks = words.windows(2).filter(|pair| pair[0] == "--lock").flatten();
    let check = ["check", &words[1], word(words, "--out"), "--limits", word(words, "--limits")];
    let check: Vec<&str> = check.into_iter().chain(locks.map(String::as_str)).collect();
    let check = rist(&folder("remedies"), &check);
    if check.code == Some(0) { vec![] } else { vec![format!("rist check: {}", check.err.trim())] }
}

/// Applies a finding: adds the lines that it proposes to the file of limits.
fn obeyed(case: &Case, finding: &str) -> Told {
    let said =
        ["tried, and a motion is proven: ", "moves it away: "].into_iter().find_map(|words| finding.split_once(words));
    let (_, remedy) = said?;
    if let Some((_, share)) = remedy.split_once("--effort-share ") {
        let asked = word(&case.words, "--effort-share");
        return Some(Ok(case
            .words
            .iter()
            .map(|word| if word == asked { share.into() } else { word.clone() })
            .collect()));
    }
    let path = word(&case.words, "--limits");
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut limits: Value = serde_yaml::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"));
    if remedy.contains("space without `distance") {
        limits["space"].as_object_mut().map(|space| space.remove("distance"));
    } else {
        let begin = ["coordinates: {", "space: {"].iter().filter_map(|key| remedy.find(key)).min()?;
        let end = [" in --limits", " is below it"].iter().filter_map(|words| remedy[begin..].find(words)).min();
        let yaml = end.map_or(&remedy[begin..], |end| &remedy[begin..begin + end]);
        match serde_yaml::from_str::<Value>(yaml) {
            Ok(more) => merge(&mut limits, more),
            Err(_) => return Some(Err(format!("`{yaml}` is no file of limits"))),
        }
    }
    let obeyed = written("obeyed.yaml", &limits.to_string());
    Some(Ok(case.words.iter().map(|word| if word == path { obeyed.clone() } else { word.clone() }).collect()))
}

fn word<'a>(words: &'a [String], flag: &str) -> &'a str {
    words.iter().position(|word| word == flag).map_or("", |k| &words[k + 1])
}
