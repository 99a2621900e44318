//! Tests how often a "yes" of `rist identify` (the program trusts its estimate) is wrong, with random robots, motions, noise,
//! defects and gross faults.
//!
//! `cargo bench --profile dev -p tests --bench random_situations -- [COUNT] [from SEED] [each] [predicted]`: prints counts.
//! `each`: prints every situation with the reasons. `predicted`: only the first log is fitted, and it predicts the other one
//! (`--validate`). `cargo bench --profile dev -p tests --bench random_situations -- seed SEED`: one situation with the whole
//! output of the program.
//!
//! | column | meaning |
//! |---|---|
//! | yes, care, no, error | number of situations with this answer of the program |
//! | yes: torque > 5 % | of the "yes": the predicted torque on another motion, including friction, is more than 5 % wrong |
//! | as logged > 5 % | the same in the unit of the logged torques, if these have a wrong scale |
//! | bodies > 5 % | the same for the torque of bodies and rotors only, without friction |
//! | > 5 sigma | of the "yes": some parameter has an error of more than five printed standard deviations |
//! | as logged > 5 sigma | the same in the unit of the logged torques, if all have the same wrong scale |
//! | good | good situations: torque within 2 %, all parameters within four standard deviations, both logs of the same robot |
//! | no, with care | number of good situations with this answer of the program |

use tests::random_situations::Situation;
use tests::random_situations::judge::Outcome;
use tests::random_situations::tally::{Tally, line};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| w != "--bench").collect();
    let behind = |word: &str| {
        let place = words.iter().position(|w| w == word)?;
        let number = words.get(place + 1).and_then(|w| w.parse::<u64>().ok());
        Some(number.unwrap_or_else(|| panic!("`{word}` has no number behind it; `{word} 123` is expected")))
    };
    let has = |word: &str| words.iter().any(|w| w == word);
    let fits_all = !has("predicted");
    if let Some(seed) = behind("seed") {
        let situation = Situation::of(seed);
        show(&situation, &situation.outcome(fits_all));
        return;
    }
    let count: u64 = words.first().and_then(|w| w.parse().ok()).unwrap_or(600);
    let first = behind("from").unwrap_or(1);
    let each = has("each");
    let mut tally = Tally::default();
    for seed in first..first + count {
        let start = std::time::Instant::now();
        let situation = Situation::of(seed);
        let outcome = situation.outcome(fits_all);
        if each {
            println!("{}", line(&situation, &outcome));
            let reasons = outcome.verdict.iter().flat_map(|verdict| &verdict.reasons);
            reasons.for_each(|reason| println!("    {reason}"));
        }
        eprintln!("{seed}: {:.1} s", start.elapsed().as_secs_f64());
        tally.add(&situation, &outcome);
    }
    println!("{tally}");
}

/// Prints one random situation with the output of the program and the true values.
fn show(situation: &Situation, outcome: &Outcome) {
    println!("{situation}\n{}\n{}", situation.description(), outcome.said);
    let Some(judgement) = &outcome.judgement else { return };
    println!("parameter                     value        sigma        truth   sigmas off");
    for (name, value, sigma, exact) in &judgement.parameters {
        let off = (value - exact) / sigma;
        println!("{name:<22} {value:>12.5} {sigma:>12.5} {exact:>12.5} {off:>12.2}");
    }
    println!("{}", line(situation, outcome));
    let (left, unsaid) = (judgement.left, judgement.unsaid);
    println!("the true bodies leave {left:.1e} of the torque in the columns of the model, {unsaid} rotors have none");
}
