//! What rist says in random situations, beside the truth.
//! `cargo bench --profile dev -p tests --bench situations -- 600` (the number); `-- seed 12` prints one.

use rist::verdict::Trust;
use tests::situations::judge::{Judgement, judge};
use tests::situations::{Situation, models};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with('-')).collect();
    let numbers: Vec<u64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let models = models();
    let situation = |seed: u64| Situation::new(seed, &|file| models[file].robot.clone());
    if words.first().is_some_and(|word| word == "seed") {
        let one = situation(numbers[0]);
        println!("{} {:?}", one.file, one.defects);
        let said = judge(&one, &models[one.file]);
        said.verdict.iter().for_each(|verdict| println!("{verdict}"));
        said.refused.iter().for_each(|why| println!("refused: {why}"));
        println!("torque on another motion {:.4}, worst parameter {:.1} sigma", said.torque_error, said.sigmas);
        return;
    }
    let count = numbers.first().copied().unwrap_or(600);
    let mut all: Vec<(Situation, Judgement)> = Vec::new();
    for seed in 0..count {
        let one = situation(seed);
        let said = judge(&one, &models[one.file]);
        all.push((one, said));
    }
    println!("{:<26} {:>5} {:>10} {:>10} {:>10} {:>6}", "said", "n", "torque>5%", "torque>10%", ">5 sigma", "good");
    for (logs, has_second) in [("one log", false), ("two logs", true)] {
        for trust in [Trust::Yes, Trust::WithCare, Trust::No] {
            let those: Vec<&(Situation, Judgement)> =
                all.iter().filter(|(s, j)| s.has_second == has_second && j.trust == trust).collect();
            let count = |of: &dyn Fn(&Judgement) -> bool| those.iter().filter(|(_, j)| of(j)).count();
            println!(
                "{:<26} {:>5} {:>10} {:>10} {:>10} {:>6}",
                format!("{}, {logs}", trust.word()),
                those.len(),
                count(&|j| j.torque_error > 0.05),
                count(&|j| j.torque_error > 0.1),
                count(&|j| j.sigmas > 5.0),
                count(&Judgement::is_good)
            );
        }
    }
    println!("\nyes beside a wrong estimate (seed, torque error, sigmas):");
    for (situation, said) in all.iter().filter(|(_, j)| j.trust == Trust::Yes) {
        if said.torque_error > 0.05 || said.sigmas > 5.0 {
            let (error, sigmas) = (said.torque_error, said.sigmas);
            println!(
                "{:>5} {error:>8.4} {sigmas:>7.1} {} {}",
                situation.seed,
                situation.file,
                situation.defects.join("; ")
            );
        }
    }
    println!("\nno, or with care, beside a good one:");
    for (situation, said) in
        all.iter().filter(|(s, j)| j.trust != Trust::Yes && j.is_good() && (s.has_second || j.trust == Trust::No))
    {
        let why = said.verdict.as_ref().and_then(|v| v.reasons.first()).cloned().unwrap_or_default();
        println!(
            "{:>5} {} {}: {} | {why}",
            situation.seed,
            said.trust.word(),
            situation.file,
            situation.defects.join("; ")
        );
    }
}
