//! Draws 95 % intervals for noise with autocorrelation: forty logs of the same constant, with two intervals each.
//!
//! Each log has 2000 samples with the noise e_i = 0.9 e_(i-1) + white noise. The first interval assumes white noise: sigma
//! divided by the root of the number of samples. The second interval uses the standard deviation of the means of twenty blocks.

use super::canvas::{Anchor, Canvas, Ink};
use random::SplitMix;

const LOGS: usize = 40;
const SAMPLES: usize = 2000;
const BLOCKS: usize = 20;
/// The coefficient 0.9 in e_i = 0.9 e_(i-1) + white noise.
const AUTOREGRESSION: f64 = 0.9;
/// Number of samples that are discarded at the start, because the noise is not yet stationary.
const DISCARDED_SAMPLES: usize = 200;
/// Quantile of the normal distribution for a two-sided 95 % interval.
const QUANTILE_95: f64 = 1.96;

/// The mean of a log, and two standard deviations of this mean: for white noise, and from the means of blocks.
fn log(random: &mut SplitMix) -> (f64, f64, f64) {
    let mut slow = 0.0;
    let mut sample = || {
        // The sum of twelve numbers that are uniform in [-1, 1) is nearly normal. The variance of the sum is 12 / 3 = 4, so
        // half of the sum has the variance 1.
        let white: f64 = (0..12).map(|_| random.unit()).sum::<f64>() / 2.0;
        slow = AUTOREGRESSION * slow + white;
        slow
    };
    (0..DISCARDED_SAMPLES).for_each(|_| {
        sample();
    });
    let x: Vec<f64> = (0..SAMPLES).map(|_| sample()).collect();
    let deviation = |x: &[f64]| {
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        let squares = x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
        (mean, libm::sqrt(squares / (x.len() - 1) as f64))
    };
    let (mean, white) = deviation(&x);
    let means: Vec<f64> = x.chunks(SAMPLES / BLOCKS).map(|block| deviation(block).0).collect();
    (mean, white / libm::sqrt(SAMPLES as f64), deviation(&means).1 / libm::sqrt(BLOCKS as f64))
}

pub(crate) fn draw() -> Result<String, String> {
    let mut random = SplitMix(42);
    let logs: Vec<(f64, f64, f64)> = (0..LOGS).map(|_| log(&mut random)).collect();
    let mut canvas = Canvas::new(760.0, 420.0, "Forty intervals that take slow noise for white, and forty that do not");
    for (k, name) in ["as if noise were white", "by parts of the log, as here"].into_iter().enumerate() {
        let sigma = |log: &(f64, f64, f64)| if k == 0 { log.1 } else { log.2 };
        let middle = 120.0 + 190.0 * k as f64;
        let holds = |log: &(f64, f64, f64)| log.0.abs() <= QUANTILE_95 * sigma(log);
        let held = logs.iter().filter(|log| holds(log)).count();
        canvas.heading((20.0, middle - 88.0), &format!("{name}: {held} of {LOGS} intervals hold the truth"));
        canvas.line((20.0, middle), (740.0, middle), Ink::Word, 1.0);
        for (i, log) in logs.iter().enumerate() {
            let x = 34.0 + 17.8 * i as f64;
            let y = |value: f64| middle - (72.0 * value).clamp(-78.0, 78.0);
            let (ink, half) = (if holds(log) { Ink::Blue } else { Ink::Orange }, QUANTILE_95 * sigma(log));
            canvas.line((x, y(log.0 - half)), (x, y(log.0 + half)), ink, 2.0);
            canvas.dot((x, y(log.0)), 3.0, ink);
        }
    }
    canvas.words(
        (20.0, 408.0),
        Anchor::Start,
        Ink::Word,
        "the line is the truth; orange intervals miss it; two of forty should",
    );
    Ok(canvas.finish())
}
