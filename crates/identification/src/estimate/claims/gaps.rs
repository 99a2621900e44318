//! Fits the widths of gaps (play, backlash) by repeated tests. One test is not enough, because the column of a gap in the
//! regressor depends on the width of the gap and on the softness of its ends. The side of a gap is the sign of the torque that
//! the gap transmits (module `play`).

use logs::Error;

use crate::estimate::claims::hypothesis_test::HypothesisTest;
use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::play::Backlash;

/// The tests of play start from these widths of a gap, rad (0.5, 1 and 2 degrees), and from the softnesses of its ends in the
/// next constant.
const START_WIDTHS_RAD: [f64; 3] = [0.0087, 0.0175, 0.035];
const SOFTNESSES: [f64; 2] = [0.0, 0.2];
/// Number of rounds of the iteration: the width of a gap gives the side of the gap at each sample, and these sides give a new
/// width.
const PLAY_ROUNDS: usize = 2;

/// Repeats the tests of play for joints whose first test shows an effect when the torque changes its sign. The side of a gap
/// depends on the width of the gap, because the width changes the velocity of the link. So the tests start from several widths
/// and softnesses, and continue with the fitted width. `again`: function that tests hypotheses with the given gaps; n: number
/// of coordinates.
pub(super) fn settle_play(
    found: &mut [HypothesisTest],
    n: usize,
    again: impl Fn(&[Backlash], &[Hypothesis]) -> Result<Vec<HypothesisTest>, Error>,
) -> Result<(), Error> {
    let is_seen = |one: &HypothesisTest| matches!(one.of, Hypothesis::Play(_)) && one.is_significant();
    let seen: Vec<usize> = (0..found.len()).filter(|&i| is_seen(&found[i])).collect();
    let all: Vec<Hypothesis> = seen.iter().map(|&i| found[i].of).collect();
    let starts = START_WIDTHS_RAD.iter().flat_map(|&width| SOFTNESSES.map(|softness| Backlash { width, softness }));
    for start in starts.filter(|_| !seen.is_empty()) {
        let mut gaps = vec![Backlash { width: 0.0, ..start }; n];
        all.iter().filter_map(Hypothesis::joint).for_each(|k| gaps[k] = start);
        for _ in 0..PLAY_ROUNDS {
            for (&i, one) in seen.iter().zip(again(&gaps, &all)?) {
                let (Some(k), true) = (one.of.joint(), one.is_significant() && one.value > 0.0) else { continue };
                gaps[k].width = one.value;
                let error =
                    |one: &HypothesisTest| one.held_out.filter(|_| one.value > 0.0).map_or(f64::INFINITY, |of| of.1);
                if error(&one) < error(&found[i]) {
                    found[i] = one;
                }
            }
        }
    }
    Ok(())
}
