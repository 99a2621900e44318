//! Whether a "yes" of `rist identify` can be believed: random robots, motions, noise, defects and gross faults.
//!
//! `cargo bench --profile dev -p tests --bench random_situations -- [COUNT] [from SEED] [each] [predicted]`: counts; `each` prints every one
//! with its reasons; `predicted` fits the first log alone, which predicts the other (`--validate`).
//! `cargo bench --profile dev -p tests --bench random_situations -- seed SEED`: one, with all that the program says.
//!
//! | column | is |
//! |---|---|
//! | yes, care, no, error | what the program says of the situation |
//! | yes: torque > 5 % | of "yes", those whose torque on another motion is more than 5 % wrong, friction and all |
//! | as logged > 5 % | the same in the units of the torques as logged, where they have a wrong scale |
//! | bodies > 5 % | the same of the torque of bodies and rotors |
//! | > 5 sigma | of "yes", those with a parameter beyond five of its printed deviations |
//! | as logged > 5 sigma | the same in the units of the torques as logged, where all have one wrong scale |
//! | good | torque within 2 %, all parameters within four deviations, both logs of one machine |
//! | no, with care | what is said of the good |

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

/// One situation, with all that is said of it and the truth beside it.
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
