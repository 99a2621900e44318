//! An artefact of which something was taken away, doubled or changed is refused, or what comes of it says that the file is
//! not as rist wrote it: the promise of docs/files.md, over every line and every key of every artefact.
use std::path::Path;

use fleet::Accumulator;
use fleet::comparison::Comparison;
use linear_model::artefact::Checksum;
use rist::{Estimate, ExcitingMotion, ExperimentPlan, Validation};
use tests::mutation::{Seed, bounded, written};
use tests::program::{folder, program, rist};

/// What the sentences on a file that is not whole have in common.
const SAID: &str = "this is what the file says";

/// The seal of a text that is read; the reason where it is refused.
fn read(kind: &str, text: &str) -> Result<Checksum, String> {
    match kind {
        "estimate.yaml" => Estimate::from_yaml(kind, text).map(|x| x.checksum),
        "motion.yaml" => ExcitingMotion::from_yaml(kind, text).map(|x| x.checksum),
        "plan.yaml" => ExperimentPlan::from_yaml(kind, text).map(|x| x.checksum),
        "validation.yaml" => Validation::from_yaml(kind, text).map(|x| x.checksum),
        _ => Comparison::from_yaml(kind, text).map(|x| x.seal),
    }
    .map_err(|e| e.to_string())
}

/// Where the first line and each key of the first level begin, and the end.
fn blocks(lines: &[&str]) -> Vec<usize> {
    let begins = |line: &str| line.starts_with(|c: char| c.is_ascii_alphabetic());
    let starts = lines.iter().enumerate().filter(|(_, line)| begins(line)).map(|(k, _)| k);
    starts.chain([lines.len()]).collect()
}

/// The text without these lines, and with them twice.
fn variants(lines: &[&str], from: usize, to: usize) -> [String; 2] {
    let text = |parts: &[&[&str]]| parts.concat().iter().map(|line| format!("{line}\n")).collect::<String>();
    let (before, block, after) = (&lines[..from], &lines[from..to], &lines[to..]);
    [text(&[before, after]), text(&[before, block, block, after])]
}

/// The artefacts in YAML, as the program writes them.
fn artefacts(here: &Path) -> Vec<Seed> {
    let kinds = ["estimate.yaml", "motion.yaml", "plan.yaml", "validation.yaml", "comparison.yaml"];
    let seeds = written(program(), here).into_iter().filter(|seed| kinds.contains(&seed.name.as_str()));
    let found: Vec<Seed> = seeds.collect();
    assert_eq!(found.len(), kinds.len());
    found
}

#[test]
fn each_line_that_is_missing_or_doubled_is_refused_or_known() {
    let here = folder("whole-lines");
    let mut counts = (0, 0);
    for seed in artefacts(&here) {
        let text = String::from_utf8(seed.bytes).unwrap();
        assert_eq!(read(&seed.name, &text), Ok(Checksum::Whole), "{}", seed.name);
        let lines: Vec<&str> = text.lines().collect();
        let keys = blocks(&lines);
        let parts = (0..lines.len()).map(|k| (k, k + 1)).chain(keys.windows(2).map(|w| (w[0], w[1])));
        for (from, to) in parts {
            for (changed, what) in variants(&lines, from, to).iter().zip(["missing", "twice"]) {
                match read(&seed.name, changed) {
                    Ok(Checksum::Whole) => panic!("{}: lines {from}..{to} {what}: {}", seed.name, lines[from]),
                    // Without the first line a file is one of an earlier version.
                    Ok(seal) => {
                        assert_eq!(seal == Checksum::Absent, from == 0 && what == "missing", "{}: {from}", seed.name);
                        counts.0 += 1;
                    }
                    Err(_) => counts.1 += 1,
                }
            }
        }
    }
    // Both ways are gone, so that neither is empty by mistake.
    assert!(counts.0 > 100 && counts.1 > 100, "{counts:?}");
}

/// A reader that knows is not enough: each command has to say it, and says nothing of a file that is whole.
#[test]
fn each_command_says_what_it_read() {
    let here = folder("whole-commands");
    for seed in artefacts(&here) {
        let text = String::from_utf8(seed.bytes.clone()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let keys = blocks(&lines);
        // The first line, and each key that a file may lack: the others are refused by the reader.
        let mut changed: Vec<(String, String)> = keys
            .windows(2)
            .map(|w| (lines[w[0]].to_string(), variants(&lines, w[0], w[1])[0].clone()))
            .filter(|(_, text)| read(&seed.name, text).is_ok())
            .collect();
        changed.push(("a space".into(), format!("{text} ")));
        assert!(changed.len() > 1, "{}", seed.name);
        for command in &seed.commands {
            let outcome = |content: &str| {
                std::fs::write(here.join("file.yaml"), content).unwrap();
                std::fs::remove_file(here.join("x")).ok();
                let words: Vec<&str> = command.iter().map(|w| if w == "{}" { "file.yaml" } else { w }).collect();
                let run = bounded(program(), &here, content.len(), &words);
                assert!(matches!(run.code, Some(0..=2)), "{command:?}: {}", run.err);
                let page = std::fs::read_to_string(here.join("x")).unwrap_or_default();
                (run.code, run.out + &run.err + &page)
            };
            let (code, said) = outcome(&text);
            assert!(code != Some(2) && !said.contains(SAID), "{}: {command:?}: {said}", seed.name);
            for (what, content) in &changed {
                let (code, said) = outcome(content);
                let is_said = said.split_whitespace().collect::<Vec<_>>().join(" ").contains(SAID);
                assert!(code == Some(2) || is_said, "{}: {command:?} without `{what}`: {said}", seed.name);
            }
        }
    }
}

/// Who reads such a file and writes it again does not make it whole.
#[test]
fn what_is_written_again_stays_known() {
    let here = folder("whole-again");
    let run = |words: &[&str]| assert!(matches!(rist(&here, words).code, Some(0 | 1)), "{words:?}");
    std::fs::write(here.join("arm.yaml"), tests::program::LIMITED_ARM).unwrap();
    run(&["excite", "arm.yaml", "--starts", "1", "--iterations", "2", "--rate", "100", "--out", "motion.yaml"]);
    let text = std::fs::read_to_string(here.join("motion.yaml")).unwrap();
    let without = text.split_once('\n').unwrap().1;
    for changed in [without.to_string(), text.replace("repetitions: 3", "repetitions: 4")] {
        let read = ExcitingMotion::from_yaml("motion.yaml", &changed).unwrap();
        let again = ExcitingMotion::from_yaml("again.yaml", &read.to_yaml().unwrap()).unwrap();
        assert!(read.checksum != Checksum::Whole && again.checksum == Checksum::Broken, "{:?}", again.checksum);
    }
}

/// Sums have no text: their digest is of every byte.
#[test]
fn sums_that_lack_a_byte_are_refused() {
    let here = folder("whole-sums");
    let sums = written(program(), &here).into_iter().find(|seed| seed.name == "sums.tri").unwrap().bytes;
    let place = here.join("file.tri");
    // Each byte of the head, and one of every sixteen of the rows.
    for k in (0..sums.len()).filter(|k| *k < 64 || k % 16 == 0) {
        let mut less = sums.clone();
        less.remove(k);
        std::fs::write(&place, &less).unwrap();
        assert!(Accumulator::read(&place).is_err(), "byte {k}");
    }
    std::fs::write(&place, &sums).unwrap();
    assert!(Accumulator::read(&place).is_ok());
}
