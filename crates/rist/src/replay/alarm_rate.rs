//! The threshold of contact for an accepted rate of false alarms.
//!
//! A log without contact gives the peaks of the largest ratio |r| / s: the largest value of each excursion above a level u. If z^b
//! - u^b is exponential with mean m, then peaks above z happen at the rate
//!
//! ```text
//! rate(z) = (peaks / time) exp(-(z^b - u^b) / m)
//! ```
//! A normal process has b = 2 and m = 2 [Rice 1945]; with b < 2 the tails are heavier. b and m are estimated from the peaks by
//! maximum likelihood. The log has minutes, but the accepted rate is about one alarm in an hour. So the tail is extrapolated.
//!
//! r: external torque of a joint; s: its standard deviation without contact; z: value of a peak. An excursion is a time
//! interval in which the ratio is above the level u.

/// The peaks of a ratio above a level, during a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Peaks {
    peaks: Vec<f64>,
    seconds: f64,
    /// Largest value of the present excursion; zero if there is none.
    present: f64,
    /// Time since the ratio was above the level, s.
    quiet: f64,
}

/// The level u, in standard deviations. It is so high that excursions above it are separate from each other, and so low that a
/// minute has some hundred excursions.
const LEVEL: f64 = 2.0;

/// The exponents b that are compared.
const EXPONENTS: [f64; 5] = [2.0, 1.75, 1.5, 1.25, 1.0];

/// With fewer peaks than this, the tail of a normal process is assumed.
const LEAST_PEAKS: usize = 5;

/// The logs should have no contact. But a peak counts as a contact if the expected number of noise peaks above this peak is
/// smaller than this value. The expected number follows from the median of all peaks, with b = 1.
const LEAST_EXPECTED_PEAKS: f64 = 1e-3;

/// Smallest assumed mean of z - u, in standard deviations. A normal process has this mean at the level u = 2.
const LEAST_MEAN_EXCESS: f64 = 0.4;

/// Number of times in an hour that noise alone may make the torque of a joint significant. With this number, noise makes a
/// joint significant in one of a hundred contacts of 0.3 s (3600 s / 120 = 30 s).
const SIGNIFICANT_PER_HOUR: f64 = 120.0;

/// Seconds in an hour.
const HOUR_S: f64 = 3600.0;

/// The smallest threshold. With a smaller threshold, ordinary peaks of noise would be alarms.
const LEAST_THRESHOLD: f64 = 3.0;

impl Peaks {
    /// Adds a sample. `ratio`: the largest |r| / s of all joints; `period`: s; `hold`: an excursion ends when the ratio was below
    /// the level for this time, s.
    pub(crate) fn add(&mut self, ratio: f64, period: f64, hold: f64) {
        self.seconds += period;
        if ratio > LEVEL {
            self.present = self.present.max(ratio);
            self.quiet = 0.0;
            return;
        }
        self.quiet += period;
        if self.quiet >= hold {
            self.end();
        }
    }

    /// Ends the present excursion, for example at the end of a record.
    pub(crate) fn end(&mut self) {
        if self.present > 0.0 {
            self.peaks.push(self.present);
        }
        (self.present, self.quiet) = (0.0, 0.0);
    }

    /// The threshold z with `alarms` false alarms an hour. No peak of the logs without contact exceeds it.
    pub(crate) fn threshold(&self, alarms: f64) -> f64 {
        let peaks = self.peaks_of_noise();
        peaks.iter().fold(self.exceeded(&peaks, alarms), |most, peak| most.max(*peak))
    }

    /// The ratio from which a joint is significant during a contact.
    pub(crate) fn significant(&self) -> f64 {
        self.exceeded(&self.peaks_of_noise(), SIGNIFICANT_PER_HOUR)
    }

    /// The ratio that noise exceeds `rate` times an hour.
    fn exceeded(&self, peaks: &[f64], rate: f64) -> f64 {
        let count = (peaks.len() as f64).max(1.0);
        let exponents = (count / self.seconds.max(f64::MIN_POSITIVE) * HOUR_S / rate).ln().max(0.0);
        let (exponent, mean) = tail(peaks);
        (LEVEL.powf(exponent) + mean * exponents).powf(1.0 / exponent).max(LEAST_THRESHOLD)
    }

    /// The peaks that are not contacts.
    fn peaks_of_noise(&self) -> Vec<f64> {
        let mut sorted = self.peaks.clone();
        sorted.sort_by(f64::total_cmp);
        let Some(median) = sorted.get(sorted.len() / 2) else { return sorted };
        // The median of an exponential variable with mean m is m ln 2.
        let mean = ((median - LEVEL) / std::f64::consts::LN_2).max(LEAST_MEAN_EXCESS);
        let largest = LEVEL + mean * (sorted.len() as f64 / LEAST_EXPECTED_PEAKS).ln();
        sorted.retain(|peak| *peak <= largest);
        sorted
    }
}

/// The exponent b and the mean m of z^b - u^b that are most likely for the peaks.
fn tail(peaks: &[f64]) -> (f64, f64) {
    if peaks.len() < LEAST_PEAKS {
        return (2.0, 2.0);
    }
    let count = peaks.len() as f64;
    let of = |exponent: f64| {
        let excess = |z: &f64| z.powf(exponent) - LEVEL.powf(exponent);
        let mean = peaks.iter().map(excess).sum::<f64>() / count;
        // Logarithm of the likelihood of the peaks; the density of z has the factor b z^(b - 1).
        let slopes: f64 = peaks.iter().map(|z| (exponent - 1.0) * z.ln()).sum();
        (slopes + count * (exponent / mean).ln(), exponent, mean)
    };
    let all = EXPONENTS.map(of);
    let best = all.iter().fold(all[0], |best, other| if other.0 > best.0 { *other } else { best });
    (best.1, best.2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    /// The noise is filtered, and is normal or has heavier tails. Two minutes of it give the threshold; the false alarms are
    /// counted over ten hours.
    #[test]
    fn the_alarms_asked_for_come() {
        let (period, hold, gain) = (0.005, 0.1, 20.0);
        for heavy in [false, true] {
            let mut random = Random::new(6);
            let mut state = 0.0;
            let a = f64::exp(-gain * period);
            let mut next = || {
                state = a * state + (1.0 - a * a).sqrt() * random.normal();
                // Heavier tails: the cube of the ratio is added, so a ratio of 3 becomes 4.4.
                f64::abs(if heavy { state + 0.05 * state * state * state } else { state })
            };
            let mut peaks = Peaks::default();
            (0..24_000).for_each(|_| peaks.add(next(), period, hold));
            let threshold = peaks.threshold(6.0);
            let (mut count, mut quiet, mut is_contact) = (0, 0.0, false);
            for _ in 0..10 * 720_000 {
                let ratio = next();
                count += i32::from(ratio > threshold && !is_contact);
                quiet = if ratio > 0.5 * threshold { 0.0 } else { quiet + period };
                is_contact = ratio > threshold || (is_contact && quiet < hold);
            }
            // Expected are 60 alarms. After two minutes the exponent b is still uncertain, so a factor of three is allowed.
            assert!((20..180).contains(&count), "{heavy} {threshold} {count}");
        }
    }

    #[test]
    fn a_contact_does_not_raise_the_threshold() {
        let mut random = Random::new(9);
        let mut peaks = Peaks::default();
        for _ in 0..24_000 {
            peaks.add(random.normal().abs(), 0.005, 0.1);
        }
        let quiet = peaks.threshold(1.0);
        (0..200).for_each(|_| peaks.add(150.0, 0.005, 0.1));
        (0..100).for_each(|_| peaks.add(0.0, 0.005, 0.1));
        (0..200).for_each(|_| peaks.add(20.0, 0.005, 0.1));
        peaks.end();
        // The contacts only make the log longer by some seconds, and may remove or add one excursion. So the threshold must
        // hardly change.
        assert!((peaks.threshold(1.0) / quiet - 1.0).abs() < 0.01, "{quiet} {}", peaks.threshold(1.0));
    }

    #[test]
    fn without_peaks_it_is_a_normal_process() {
        let mut peaks = Peaks::default();
        (0..1000).for_each(|_| peaks.add(0.1, 0.01, 0.1));
        // In 10 s without a peak, at most one peak is assumed: with ln(360) = 5.9, the threshold is sqrt(4 + 11.8) = 3.97.
        assert!((peaks.threshold(1.0) - 3.97).abs() < 0.01, "{}", peaks.threshold(1.0));
    }
}
