//! Whether the cause that `rist doctor` names is the true one, and whether what it tells a reader to do mends the log: random
//! robots, each log with one mistake.
//!
//! `cargo bench --profile dev -p tests --bench remedies -- [COUNT] [from SEED] [each] [doctor]`: counts; `each` prints every one;
//! `doctor` leaves `rist identify` out.
//! `cargo bench --profile dev -p tests --bench remedies -- seed SEED`: one, with all that the program prints.
//! `cargo bench --profile dev -p tests --bench remedies -- clean [COUNT] [from SEED]`: logs without a mistake, and those that
//! are accused.
//!
//! `cargo bench --profile dev -p tests --bench remedies -- postures [COUNT] [from SEED] [each]`, and the same with `wrench`, `lint`
//! and `excite`: inputs of these commands, each with one mistake or none; with `seed SEED` one, with all that is printed.
//!
//! The robots are those of `../shared/findings/inputs/statistics2`, and those of the folder that `RIST_ARMS` names. Which robot
//! a seed takes depends on how many there are.
//!
//! | column | is |
//! |---|---|
//! | above | the mistake is larger than what doctor says of the right log that it would have shown; where it says nothing: gross |
//! | right, among several, wrong | all findings name the true cause, or the program says that it has undone it; some do; none does |
//! | cannot tell, silent | no finding: a line says that this cannot be told, or nothing does |
//! | obeyed | a remedy that a machine can obey as it is printed (`obedience` says which words) |
//! | accepted | of these, the program takes it |
//! | claim gone, new claim | of these, the obeyed findings are gone; others came up |
//! | by a person | findings that only a person can obey |
//! | yes, and wrong | of logs: `rist identify`, given two such logs, trusts an estimate that leaves more than 5 % of the torque on a third motion |
//!
//! Of the other commands each finding is obeyed alone, also what is said in place of the first, and what is refused is a finding
//! too. They print no power. Above is, of postures: the mistake moves a torque by ten times what else does, and of a zero, mount or
//! scale the bodies are as described; of wrenches: gravity turns in the sensor; of descriptions: the numbers are those of no body, or
//! beyond what lint bounds; of motions: something is limited. What lint says of the robot's own description is known before, and
//! stands in the list of what is accused.

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

/// Logs without a mistake: prints those that are accused, and counts them; those that are only too short are counted apart.
fn clean(arms: &[Arm], first: u64, count: u64) {
    let (mut accused, mut short, mut refused) = (0, 0, 0);
    for seed in first..first + count {
        let situation = Situation::clean(seed, arms);
        let outcome = situation.outcome(false);
        if outcome.said.code == Some(0) {
            continue;
        }
        let said = &outcome.said;
        // Of a log of a second or two this is so.
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

/// Inputs of another command; `shown`: `each` prints every one, `seed` all that the program says.
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

/// One situation, with all that is printed.
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
