//! Inputs of the commands that read no log of a motion, each with one mistake or none. Each command is run on its input, and the
//! remedy of each finding is applied separately.
//!
//! A finding is a line of the output that names a probable mistake with a remedy. The steps of a remedy are flags, options or
//! renamed columns.

use super::arms::Arm;
use super::judge::{Cause, Obeyed, Outcome};
use super::obedience::{Step, options, steps};
use super::said::{Said, claim};
use crate::program::{Run, folder, rist};

/// An input with one mistake or none.
pub struct Case<'a> {
    pub arm: &'a Arm,
    /// The kind of the mistake; `none` if the input is correct.
    pub kind: &'static str,
    /// Whether a finding names the mistake.
    pub is_right: Box<dyn Fn(&str) -> bool>,
    /// Whether the mistake is large enough to be found.
    pub is_above: bool,
    /// The arguments of the program.
    pub words: Vec<String>,
    /// The arguments for the same input without the mistake; `None` if there is no such input.
    pub clean: Option<Vec<String>>,
}

/// The arguments of the program after the remedy of a finding was applied, or the reason why it cannot be applied. `None`: only a
/// person can apply it.
pub type Told = Option<Result<Vec<String>, String>>;

/// A command, and the functions to test it.
pub struct Command {
    /// Name of the command.
    pub word: &'static str,
    /// Makes the input for a seed.
    pub case: for<'a> fn(u64, &'a [Arm]) -> Case<'a>,
    /// The findings in the output of a run with these arguments.
    pub findings: fn(&[String], &Run) -> Vec<String>,
    /// Applies the remedy of a finding.
    pub obeyed: fn(&Case, &str) -> Told,
}

impl Command {
    /// Runs the command on an input, and applies the remedies of the findings.
    pub fn outcome(&self, case: &Case) -> Outcome {
        let clean = case.clean.as_ref().map(|words| self.said(words, &[]));
        let known = clean.as_ref().map_or(vec![], |clean| clean.findings.clone());
        let said = self.said(&case.words, &known);
        let right = said.findings.iter().filter(|finding| (case.is_right)(finding)).count();
        let cause = match (right, said.findings.len()) {
            (0, 0) if case.kind == "none" || (case.is_right)(&said.whole) => Cause::Right,
            (0, 0) => Cause::Silent,
            (0, _) => Cause::Wrong,
            (right, all) => {
                if right == all {
                    Cause::Right
                } else {
                    Cause::Among
                }
            }
        };
        let told: Vec<_> = said.findings.iter().map(|finding| (self.obeyed)(case, finding)).collect();
        let needs_person = told.iter().filter(|told| told.is_none()).count();
        let (mut all, mut again) = (None, String::new());
        for told in told.into_iter().flatten() {
            let (one, text) = match told {
                Err(why) => (Obeyed { accepted: false, gone: false, nothing_new: false }, why),
                Ok(words) => {
                    let now = self.said(&words, &known);
                    let claims = |said: &Said| said.findings.iter().map(|line| claim(line)).collect::<Vec<_>>();
                    let (before, now_claims) = (claims(&said), claims(&now));
                    let is_known = |claim: &String| before.contains(claim);
                    let gone = !now_claims.iter().any(is_known);
                    let nothing_new = now_claims.iter().all(is_known);
                    (
                        Obeyed { accepted: now.is_accepted(), gone, nothing_new },
                        format!("{}\n{}", words[1..].join(" "), now.whole),
                    )
                }
            };
            let so_far = all.unwrap_or(Obeyed { accepted: true, gone: true, nothing_new: true });
            all = Some(Obeyed {
                accepted: so_far.accepted && one.accepted,
                gone: so_far.gone && one.gone,
                nothing_new: so_far.nothing_new && one.nothing_new,
            });
            again += &text;
        }
        Outcome {
            said,
            clean,
            cause,
            is_above: case.is_above,
            obeyed: all,
            needs_person,
            again,
            trust: None,
            left: None,
        }
    }

    /// The findings of a run, except those in `known`. An error message also counts as a finding.
    fn said(&self, words: &[String], known: &[String]) -> Said {
        let run = rist(&folder("remedies"), &words.iter().map(String::as_str).collect::<Vec<_>>());
        let is_refused = !matches!(run.code, Some(0 | 1));
        let mut findings = if is_refused { vec![run.err.trim().to_string()] } else { (self.findings)(words, &run) };
        findings.retain(|finding| !known.contains(finding));
        let code = if is_refused { run.code } else { Some(i32::from(!findings.is_empty())) };
        Said { code, findings, whole: format!("{}{}", run.out, run.err), error: run.err, ..Said::default() }
    }
}

/// The arguments of a case, to which the remedy of a finding is added as flags and as a file of options.
pub fn with_steps(case: &Case, finding: &str) -> Told {
    let steps = steps(finding);
    if steps.is_empty() {
        return None;
    }
    let mut words = case.words.clone();
    for step in &steps {
        if let Step::Flag(name, value) = step {
            words.extend([format!("--{name}"), value.clone()]);
        }
    }
    Some(options(&steps).map(|yaml| {
        if let Some(yaml) = yaml {
            words.extend(["--options".to_string(), written("options.yaml", &yaml)]);
        }
        words
    }))
}

/// Writes a file to the folder of the bench, and returns its path.
pub fn written(name: &str, text: &str) -> String {
    let path = folder("remedies").join(name);
    std::fs::write(&path, text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    path.display().to_string()
}
