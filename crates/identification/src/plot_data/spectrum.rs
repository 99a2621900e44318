//! The spectrum of a signal, averaged over short segments, and the noise of measured torques.
//!
//! S(f) = 2 |sum_r h_r e_r exp(-2 pi j f r T)|^2 T / sum_r h_r^2, with the signal e, the sample time T and the Hann window
//! h, is averaged over segments of `SAMPLES_PER_SEGMENT` samples with an overlap of half [Welch 1967]. The result is
//! sqrt(S), in the unit of the signal over sqrt(Hz).
//!
//! Records with different sampling rates have frequency bins at different frequencies, so each sampling rate has its own sum.
//! The result is the spectrum of the sampling rate with the most segments.

use std::sync::Arc;

use logs::{Error, Log, LogSource};
use numerics::fft::RealToComplex;

use crate::estimate::options::Options;

/// Two sample times count as equal if their relative difference is smaller than this value. Then the frequencies of their bins
/// differ by less than 1 %.
const EQUAL_RATE_TOLERANCE: f64 = 0.01;

/// Number of samples of a segment.
const SAMPLES_PER_SEGMENT: usize = 256;

/// The noise is measured at frequencies above this multiple of the cut-off.
const NOISE_CUTOFF_RATIO: f64 = 2.0;
/// Least number of frequency bins from which the noise is measured.
const MIN_NOISE_BINS: usize = 8;

/// An averaged spectrum, computed sample by sample.
pub struct Spectrum {
    transform: Arc<dyn RealToComplex<f64>>,
    window: Vec<f64>,
    held: Vec<f64>,
    rates: Vec<Sums>,
    /// Index in `rates` of the sampling rate of the current record.
    current: usize,
}

/// Sums over the segments of all records with one sampling rate.
struct Sums {
    /// Sample time of the first record with this rate, s.
    period: f64,
    bins: Vec<f64>,
    stretches: usize,
}

impl Default for Spectrum {
    fn default() -> Spectrum {
        let turn = |i: usize| std::f64::consts::TAU * i as f64 / SAMPLES_PER_SEGMENT as f64;
        Spectrum {
            transform: numerics::fft::forward(SAMPLES_PER_SEGMENT),
            window: (0..SAMPLES_PER_SEGMENT).map(|i| 0.5 - 0.5 * turn(i).cos()).collect(),
            held: Vec::new(),
            rates: Vec::new(),
            current: 0,
        }
    }
}

impl Spectrum {
    /// Starts a record whose samples are `period` s apart.
    pub fn begin(&mut self, period: f64) {
        self.held.clear();
        let known = self.rates.iter().position(|sums| (period / sums.period - 1.0).abs() < EQUAL_RATE_TOLERANCE);
        self.current = known.unwrap_or_else(|| {
            self.rates.push(Sums { period, bins: vec![0.0; SAMPLES_PER_SEGMENT / 2 + 1], stretches: 0 });
            self.rates.len() - 1
        });
    }

    /// Adds the next sample of the current record.
    pub fn push(&mut self, value: f64) {
        self.held.push(value);
        if self.held.len() < SAMPLES_PER_SEGMENT {
            return;
        }
        let mean = self.held.iter().sum::<f64>() / SAMPLES_PER_SEGMENT as f64;
        let mut input: Vec<f64> = self.held.iter().zip(&self.window).map(|(e, h)| (e - mean) * h).collect();
        let mut output = self.transform.make_output_vec();
        // This never fails, because both buffers have the length for which the transform was made.
        if self.transform.process(&mut input, &mut output).is_ok()
            && let Some(sums) = self.rates.get_mut(self.current)
        {
            for (sum, bin) in sums.bins.iter_mut().zip(&output) {
                *sum += bin.norm_sqr();
            }
            sums.stretches += 1;
        }
        self.held.drain(..SAMPLES_PER_SEGMENT / 2);
    }

    /// The spectrum: pairs (frequency in Hz, root of the density), without the mean; empty if there is no complete segment.
    pub fn density(&self) -> Vec<(f64, f64)> {
        // The sums of the sampling rate with the most segments. If several rates have equal numbers, the first one is taken.
        let most = self.rates.iter().reduce(|a, b| if b.stretches > a.stretches { b } else { a });
        let Some(Sums { period, bins, stretches }) = most.filter(|sums| sums.stretches > 0) else { return Vec::new() };
        let power: f64 = self.window.iter().map(|h| h * h).sum();
        let scale = 2.0 * period / (power * *stretches as f64);
        let hertz = |k: usize| k as f64 / (SAMPLES_PER_SEGMENT as f64 * period);
        (1..bins.len()).map(|k| (hertz(k), (scale * bins[k]).sqrt())).collect()
    }
}

/// The noise of each measured torque: median of the root spectral density above twice the cut-off, N m/sqrt(Hz). `None` if the
/// sampling rate of the log is too low.
///
/// The result is the noise of the sensor only if the driver of the sensor has not filtered the torque.
///
/// Fails if a log does not match the transmission.
pub(crate) fn noise_density(options: &Options, logs: &[LogSource]) -> Result<Vec<Option<f64>>, Error> {
    let cutoff = options.signal.cutoff.unwrap_or(0.0);
    let mut spectra: Vec<Spectrum> = Vec::new();
    let mut add = |log: &Log| -> Result<(), Error> {
        for part in log.segments() {
            let torques = options.transmission.apply(part)?.tau;
            spectra.resize_with(torques.len(), Spectrum::default);
            for (spectrum, torque) in spectra.iter_mut().zip(&torques) {
                spectrum.begin(log.report.clock.period);
                torque.iter().for_each(|tau| spectrum.push(*tau));
            }
        }
        Ok(())
    };
    for log in logs {
        match log {
            LogSource::Held(log) => add(log)?,
            LogSource::Streamed(stream) => stream.each(&mut add)?,
        }
    }
    // Above the cut-off there is no motion, so the torque is noise. The median ignores single spectral lines, such as mains hum.
    let level = |spectrum: &Spectrum| {
        let mut above: Vec<f64> = spectrum
            .density()
            .into_iter()
            .filter(|(hz, _)| *hz > NOISE_CUTOFF_RATIO * cutoff)
            .map(|(_, root)| root)
            .collect();
        above.sort_by(f64::total_cmp);
        (above.len() >= MIN_NOISE_BINS).then(|| above[above.len() / 2]).filter(|level| *level > 0.0)
    };
    Ok(spectra.iter().map(level).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    /// White noise of variance s^2 and sample time T has the density 2 s^2 T. A sine has its peak at its own frequency.
    #[test]
    fn noise_is_flat_and_a_sine_is_a_peak() {
        let mut random = Random::new(2);
        let (period, sigma) = (0.002, 0.3);
        let mut spectrum = Spectrum::default();
        spectrum.begin(period);
        (0..100_000).for_each(|_| spectrum.push(sigma * random.normal()));
        let expected = (2.0 * sigma * sigma * period).sqrt();
        // There are about eight hundred segments, so the relative error of a squared bin is 1/sqrt(800). The first bin is not
        // compared, because subtracting the mean lowers it.
        for (hz, root) in &spectrum.density()[1..127] {
            assert!((root / expected - 1.0).abs() < 0.1, "{hz} {root} {expected}");
        }
        spectrum.begin(period);
        (0..100_000).for_each(|i| spectrum.push(5.0 * (std::f64::consts::TAU * 50.0 * period * i as f64).sin()));
        let density = spectrum.density();
        let peak = density.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((peak.0 - 50.0).abs() < 2.0, "{peak:?}");
        assert!(Spectrum::default().density().is_empty());
    }

    #[test]
    fn rates_are_not_mixed() {
        let of = |records: &[(f64, f64, usize)]| {
            let (mut random, mut spectrum) = (Random::new(3), Spectrum::default());
            for &(period, sigma, samples) in records {
                spectrum.begin(period);
                (0..samples).for_each(|_| spectrum.push(sigma * random.normal()));
            }
            spectrum.density()
        };
        let alone = of(&[(0.002, 0.3, 100_000)]);
        assert_eq!(of(&[(0.002, 0.3, 100_000), (0.01, 9.0, 20_000)]), alone);
        let after = of(&[(0.01, 9.0, 20_000), (0.002, 0.3, 100_000)]);
        // Tolerance: the spectra have different random noise, and each bin is known to 1/sqrt(4 * 800).
        assert!(after.iter().zip(&alone).all(|(a, b)| a.0 == b.0 && (a.1 / b.1 - 1.0).abs() < 0.15), "{after:?}");
        assert_ne!(of(&[(0.002, 0.3, 100_000), (0.002001, 0.3, 20_000)]), alone);
    }
}
