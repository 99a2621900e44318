//! docs/files.md promises: a file written by rist in which a part is missing, doubled or changed is refused, or the output says
//! that the file was changed. These tests check this for every line and every key of every YAML file that rist writes.
use std::path::Path;

use fleet::Accumulator;
use fleet::comparison::Comparison;
use linear_model::artefact::Checksum;
use rist::{Estimate, ExcitingMotion, ExperimentPlan, Validation};
use tests::mutation::{Seed, bounded, written};
use tests::program::{folder, program, rist};

/// Words that all messages about a changed file contain.
const SAID: &str = "this is what the file says";

/// Reads a text as a file of this kind. Returns the status of its checksum, or the reason if it is refused.
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

/// Line numbers of the first line and of each top-level key, and the number of lines.
fn blocks(lines: &[&str]) -> Vec<usize> {
    let begins = |line: &str| line.starts_with(|c: char| c.is_ascii_alphabetic());
    let starts = lines.iter().enumerate().filter(|(_, line)| begins(line)).map(|(k, _)| k);
    starts.chain([lines.len()]).collect()
}

/// Two texts: without the lines from..to, and with these lines twice.
fn variants(lines: &[&str], from: usize, to: usize) -> [String; 2] {
    let text = |parts: &[&[&str]]| parts.concat().iter().map(|line| format!("{line}\n")).collect::<String>();
    let (before, block, after) = (&lines[..from], &lines[from..to], &lines[to..]);
    [text(&[before, after]), text(&[before, block, block, after])]
}

/// The YAML files that the program writes.
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
                    // If the first line is missing, the file counts as a file of an earlier version, which has no checksum.
                    Ok(seal) => {
                        assert_eq!(seal == Checksum::Absent, from == 0 && what == "missing", "{}: {from}", seed.name);
                        counts.0 += 1;
                    }
                    Err(_) => counts.1 += 1,
                }
            }
        }
    }
    // Both outcomes (read with a wrong checksum, refused) must occur often; otherwise the test would prove nothing.
    assert!(counts.0 > 100 && counts.1 > 100, "{counts:?}");
}

/// The reader of a file detects a change. Each command must also report it, and must not report a change if there is none.
#[test]
fn each_command_says_what_it_read() {
    let here = folder("whole-commands");
    for seed in artefacts(&here) {
        let text = String::from_utf8(seed.bytes.clone()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let keys = blocks(&lines);
        // These changes are accepted by the reader: a missing first line, and missing keys that are optional.
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

/// A changed file is read, and its content is written to a new file. The new file must not count as unchanged.
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

/// The file of sums (.tri) is binary. Its checksum covers every byte.
#[test]
fn sums_that_lack_a_byte_are_refused() {
    let here = folder("whole-sums");
    let sums = written(program(), &here).into_iter().find(|seed| seed.name == "sums.tri").unwrap().bytes;
    let place = here.join("file.tri");
    // Tested are the first 64 bytes, and then every sixteenth byte.
    for k in (0..sums.len()).filter(|k| *k < 64 || k % 16 == 0) {
        let mut less = sums.clone();
        less.remove(k);
        std::fs::write(&place, &less).unwrap();
        assert!(Accumulator::read(&place).is_err(), "byte {k}");
    }
    std::fs::write(&place, &sums).unwrap();
    assert!(Accumulator::read(&place).is_ok());
}
