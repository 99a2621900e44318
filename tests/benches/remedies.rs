//! Tests whether `rist doctor` names the true cause of a mistake in a log, and whether its remedy corrects the log. The robots
//! are random, and each log has one mistake.
//!
//! `cargo bench --profile dev -p tests --bench remedies -- [COUNT] [from SEED] [each] [doctor]`: prints counts. `each`: prints
//! every situation. `doctor`: does not run `rist identify`. `cargo bench --profile dev -p tests --bench remedies -- seed SEED`:
//! one situation with the whole output of the program. `cargo bench --profile dev -p tests --bench remedies -- clean [COUNT]
//! [from SEED]`: runs doctor on logs without a mistake, and prints the logs with a finding.
//!
//! `cargo bench --profile dev -p tests --bench remedies -- postures [COUNT] [from SEED] [each]`, and the same with `wrench`,
//! `lint` or `excite`: inputs of these commands, each with one mistake or none. With `seed SEED`: one situation with the whole
//! output.
//!
//! The robots are in `../shared/findings/inputs/statistics2` and in the folder of the environment variable `RIST_ARMS`. The robot
//! for a seed depends on the number of robots.
//!
//! | column | meaning |
//! |---|---|
//! | above | the mistake is larger than the detection limit that doctor states for the correct log, or gross if it states none |
//! | right, among several, wrong | all findings (or a note on a correction) name the true cause; some findings do; none does |
//! | cannot tell, silent | no finding, but a line that says that this cannot be determined; no finding and no such line |
//! | obeyed | a remedy that can be applied automatically as printed (see `obedience`) |
//! | accepted | of these: the program accepts the changed input |
//! | claim gone, new claim | of these: the finding is gone; other findings appear |
//! | by a person | findings with a remedy that only a person can apply |
//! | yes, and wrong | `rist identify` trusts an estimate from two such logs; of these: torque error > 5 % on a third motion |
//!
//! For the commands `postures`, `wrench`, `lint` and `excite`, the remedy of each finding is applied alone, also if the findings
//! are alternatives. A refusal of the input counts as a finding. These commands print no detection limit, so `above` means: for
//! postures, the mistake changes a torque by ten times all other errors, and for a zero, mount or scale the nominal bodies are
//! correct; for wrenches, the direction of gravity changes in the sensor frame; for descriptions, no real body has these numbers,
//! or they exceed the bounds of lint; for motions, some quantity is limited. Findings that lint also prints for the robot's
//! original description are not counted.

use tests::program::folder;
use tests::remedies::Situation;
use tests::remedies::arms::{Arm, arms};
use tests::remedies::case::Command;
use tests::remedies::commands::COMMANDS;
use tests::remedies::judge::Outcome;
use tests::remedies::tally::{Tally, line, share};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| w != "--bench").collect();
    let behind = |word: &str| {
        let place = words.iter().position(|w| w == word)?;
        let number = words.get(place + 1).and_then(|w| w.parse::<u64>().ok());
        Some(number.unwrap_or_else(|| panic!("`{word}` has no number behind it; `{word} 123` is expected")))
    };
    let has = |word: &str| words.iter().any(|w| w == word);
    let arms = arms();
    if arms.is_empty() {
        println!("no robots: nothing is tried");
        return;
    }
    let command = COMMANDS.iter().find(|command| has(command.word));
    let place = usize::from(has("clean") || command.is_some());
    let count: u64 = words.get(place).and_then(|w| w.parse().ok()).unwrap_or(200);
    let first = behind("from").unwrap_or(1);
    if let Some(command) = command {
        match behind("seed") {
            Some(seed) => of_command(command, &arms, seed..seed + 1, "seed"),
            None => of_command(command, &arms, first..first + count, if has("each") { "each" } else { "" }),
        }
    } else if has("clean") {
        clean(&arms, behind("seed").unwrap_or(first), if has("seed") { 1 } else { count });
    } else if let Some(seed) = behind("seed") {
        let situation = Situation::of(seed, &arms);
        show(&situation, &situation.outcome(!has("doctor")));
    } else {
        let mut tally = Tally::default();
        for seed in first..first + count {
            let start = std::time::Instant::now();
            let situation = Situation::of(seed, &arms);
            let outcome = situation.outcome(!has("doctor"));
            if has("each") {
                println!("{}", line(&situation, &outcome));
            }
            eprintln!("{seed}: {:.1} s", start.elapsed().as_secs_f64());
            tally.add(situation.entry.map_or("none", |entry| entry.name), &situation, &outcome);
        }
        println!("{tally}");
    }
    std::fs::remove_dir_all(folder("remedies")).ok();
}

/// Runs doctor on logs without a mistake. Prints and counts the logs with findings; logs that are only too short are counted
/// separately.
fn clean(arms: &[Arm], first: u64, count: u64) {
    let (mut accused, mut short, mut refused) = (0, 0, 0);
    for seed in first..first + count {
        let situation = Situation::clean(seed, arms);
        let outcome = situation.outcome(false);
        if outcome.said.code == Some(0) {
            continue;
        }
        let said = &outcome.said;
        // A log of one or two seconds is too short, so this finding is correct.
        if !said.findings.is_empty() && said.findings.iter().all(|f| f.starts_with("the log is too short")) {
            short += 1;
            continue;
        }
        println!("{situation}, {}", situation.motion.said);
        if said.findings.is_empty() {
            refused += 1;
            println!("    {}", said.error.trim());
        }
        accused += usize::from(!said.findings.is_empty());
        said.findings.iter().for_each(|line| println!("    {line}"));
    }
    println!("accused without a mistake: {}", share(accused, count as usize));
    println!("refused before it is looked at: {}", share(refused, count as usize));
    println!("too short, and nothing else: {}", share(short, count as usize));
}

/// Runs another command than doctor on its inputs. `shown`: `each` prints every situation, `seed` also the whole output of the
/// program.
fn of_command(command: &Command, arms: &[Arm], seeds: std::ops::Range<u64>, shown: &str) {
    let mut tally = Tally::default();
    for seed in seeds {
        let case = (command.case)(seed, arms);
        let name = format!("seed {seed} {}: {}", case.arm.name, case.kind);
        let outcome = command.outcome(&case);
        if shown == "seed" {
            println!("{}\n{}\n--- obeyed: {}", case.words.join(" "), outcome.said.whole, outcome.again);
        }
        if !shown.is_empty() {
            println!("{}", line(&name, &outcome));
        }
        tally.add(case.kind, &name, &outcome);
    }
    if shown != "seed" {
        println!("{tally}");
    }
}

/// Prints one situation with the whole output of the program.
fn show(situation: &Situation, outcome: &Outcome) {
    println!("{situation}\n{}: {}\n", situation.description().display(), situation.motion.said);
    println!("{}", outcome.said.whole);
    if let Some(clean) = &outcome.clean {
        println!("--- the same without the mistake\n{}", clean.whole);
    }
    if !outcome.again.is_empty() {
        println!("--- obeyed: {}", outcome.again);
    }
    println!("{}", line(situation, outcome));
}
