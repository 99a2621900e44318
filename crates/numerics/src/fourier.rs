//! Computes the operator Sp (projection of a signal on a reference signal at one frequency) and the discrete Fourier transform
//! (DFT), for signals that hold whole periods.
//!
//! Sp(M, v, f) = |M(f)| cos(arg M(f) - arg v(f)) / |v(f)| = Re(M(f) conj v(f)) / |v(f)|^2
//!
//! M(f), v(f): the DFT of a signal M and of a reference signal v (the projector) at the frequency f. Sp can be negative, is
//! linear in M, equals 1 for M = v, and does not change if both signals are shifted in time. The record holds a whole number of
//! periods, so the fundamental frequency is a bin. So there is no leakage, and no window is needed.
//!
//! [Vandanjon, Gautier, Desbats 1995, section 3.1]. Single bins are summed directly, because few are needed and the sum is the
//! same on every machine. Whole spectra are computed by [`crate::fft`].

pub use crate::fft::Complex;

/// Bin k of the DFT of the N samples x: sum_i x_i exp(-2 pi j k i / N).
pub fn bin(x: &[f64], k: usize) -> Complex<f64> {
    Bins::new(x.len()).of(x, k)
}

/// Computes bins of the DFT of signals of equal length, with one table of sines for all signals.
#[derive(Clone, Debug)]
pub struct Bins {
    /// exp(-2 pi j i / N) for i = 0 .. N - 1.
    turns: Vec<Complex<f64>>,
}

impl Bins {
    /// Makes the table for signals of `n` samples.
    pub fn new(n: usize) -> Bins {
        let angle = |i: usize| -std::f64::consts::TAU * i as f64 / n as f64;
        Bins { turns: (0..n).map(|i| Complex::cis(angle(i))).collect() }
    }

    /// Bin k of the DFT of x. Samples of x beyond the length of the table are not read.
    #[inline]
    pub fn of(&self, x: &[f64], k: usize) -> Complex<f64> {
        let [sum] = self.projections_in_lanes([x], k);
        sum
    }

    /// Bin k of the DFT of each signal. All signals have equal length.
    ///
    /// Four signals are summed in SIMD lanes in hardly more time than one signal: within one sum, each addition must wait for the
    /// previous one.
    pub fn of_each(&self, signals: &[Vec<f64>], k: usize) -> Vec<Complex<f64>> {
        let (fours, rest) = signals.as_chunks();
        let mut bins: Vec<_> =
            fours.iter().flat_map(|[a, b, c, d]| self.projections_in_lanes([a, b, c, d], k)).collect();
        match rest {
            [a, b, c] => bins.extend(self.projections_in_lanes([a, b, c], k)),
            [a, b] => bins.extend(self.projections_in_lanes([a, b], k)),
            _ => bins.extend(rest.iter().map(|x| self.of(x, k))),
        }
        bins
    }

    fn projections_in_lanes<const S: usize>(&self, signals: [&[f64]; S], k: usize) -> [Complex<f64>; S] {
        let n = self.turns.len();
        let length = signals.iter().map(|x| x.len()).min().unwrap_or(0).min(n);
        let signals = signals.map(|x| &x[..length]);
        let (mut at, k) = (0, k.checked_rem(n).unwrap_or(0));
        let mut sums = [Complex::new(0.0, 0.0); S];
        for i in 0..length {
            let turn = self.turns[at];
            for s in 0..S {
                sums[s] += turn * signals[s][i];
            }
            at += k;
            if at >= n {
                at -= n;
            }
        }
        sums
    }

    /// Computes a real signal and its first two derivatives from its Fourier coefficients c_0 ..= c_H: x_i = sum_k c_k exp(2 pi
    /// j k i / N), where negative k have the conjugate coefficients. `h`: sample time, s.
    fn synthesis(&self, coefficients: &[Complex<f64>], h: f64) -> [Vec<f64>; 3] {
        let n = self.turns.len();
        let mut out = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        for (k, c) in coefficients.iter().enumerate() {
            let w = std::f64::consts::TAU * k as f64 / (n as f64 * h);
            let c = if k == 0 { *c } else { 2.0 * c };
            let (mut at, k) = (0, k.checked_rem(n).unwrap_or(0));
            for i in 0..n {
                let e = c * self.turns[at].conj();
                out[0][i] += e.re;
                out[1][i] -= w * e.im;
                out[2][i] -= w * w * e.re;
                at += k;
                if at >= n {
                    at -= n;
                }
            }
        }
        out
    }
}

/// The operator Sp of this module: projection of a signal on a reference signal at one frequency bin. `m`, `v`: the DFT of the
/// signal and of the reference signal at this bin.
#[inline]
pub fn sp(m: Complex<f64>, v: Complex<f64>) -> f64 {
    (m * v.conj()).re / v.norm_sqr()
}

/// The mean period of x: the mean over all whole periods of `period` samples. Samples of an incomplete period are not used.
pub fn fold(x: &[f64], period: usize) -> Vec<f64> {
    let periods = x.len().checked_div(period).unwrap_or(0).max(1);
    (0..period).map(|i| x.iter().skip(i).step_by(period).take(periods).sum::<f64>() / periods as f64).collect()
}

/// Standard deviation of the samples of x about the mean period of x, the measured noise of a steady periodic motion. NaN for
/// less than two periods.
pub fn scatter(x: &[f64], period: usize) -> f64 {
    let mean = fold(x, period);
    let periods = x.len().checked_div(period).unwrap_or(0);
    let rest: f64 = x.iter().take(periods * period).enumerate().map(|(i, x)| (x - mean[i % period]).powi(2)).sum();
    (rest / ((periods as f64 - 1.0) * period as f64)).sqrt()
}

/// Standard deviation of the samples of x about the mean period of x, from the harmonics 1 to `highest` only. For white noise
/// the result equals [`scatter`], but noise at higher frequencies does not count. NaN for less than two periods and for
/// `highest` = 0.
///
/// ```text
/// sigma^2 = T / (H (R - 1)) sum_h sum_r |c_rh - mean_r c_rh|^2
/// T samples a period, R periods, H harmonics; c_rh: harmonic h of period r, its DFT divided by T
/// ```
pub fn scatter_of_harmonics(x: &[f64], period: usize, highest: usize) -> f64 {
    let mean = fold(x, period);
    let periods = x.len().checked_div(period).unwrap_or(0);
    let highest = highest.min(period.saturating_sub(1) / 2);
    let transform = crate::fft::forward(period.max(1));
    let (mut rest, mut spectrum) = (transform.make_input_vec(), transform.make_output_vec());
    let mut squares = 0.0;
    for one in x.chunks_exact(period.max(1)).take(periods) {
        rest.iter_mut().zip(one.iter().zip(&mean)).for_each(|(rest, (x, mean))| *rest = x - mean);
        if transform.process(&mut rest, &mut spectrum).is_err() {
            // This cannot fail: both buffers have the lengths that the transform requires.
            return f64::NAN;
        }
        squares += spectrum.iter().skip(1).take(highest).map(Complex::norm_sqr).sum::<f64>();
    }
    (squares / (period as f64 * highest as f64 * (periods as f64 - 1.0))).sqrt()
}

/// First and second derivative of a periodic signal by central differences: (dx, ddx). `h`: sample time, s.
///
/// The sample after the last one is the first one. One-sided differences at the ends would add an error of order noise/h^2 to
/// every bin.
pub fn circular_differences(x: &[f64], h: f64) -> (Vec<f64>, Vec<f64>) {
    let n = x.len();
    let at = |i: usize| (x[(i + n - 1) % n], x[i], x[(i + 1) % n]);
    let first = |(a, _, c): (f64, f64, f64)| (c - a) / (2.0 * h);
    let second = |(a, b, c): (f64, f64, f64)| (c - 2.0 * b + a) / (h * h);
    ((0..n).map(|i| first(at(i))).collect(), (0..n).map(|i| second(at(i))).collect())
}

/// Smooths one period x by keeping its harmonics up to `highest`, and differentiates it: [x, dx, ddx]. `h`: sample time, s.
pub fn harmonic_derivatives(x: &[f64], h: f64, highest: usize) -> [Vec<f64>; 3] {
    let bins = Bins::new(x.len());
    let highest = highest.min(x.len().saturating_sub(1) / 2);
    let coefficients: Vec<_> = (0..=highest).map(|k| bins.of(x, k) / x.len() as f64).collect();
    bins.synthesis(&coefficients, h)
}

/// The autocorrelation sums sum_i x_i x_(i-l) for the lags l = 0 ..= `lags`, by the Wiener-Khinchin theorem.
///
/// x is divided into blocks, because a block stays in the cache. For each block, the cross spectrum of two signals is computed:
/// the block, and the block with the `lags` samples before it. The sum of the cross spectra is transformed back once.
pub fn self_products(x: &[f64], lags: usize) -> Vec<f64> {
    // Each block is preceded by the last `lags` samples of the previous block. Without these samples, the circular correlation
    // would multiply the end of a block by its start.
    let n = (x.len() + lags).next_power_of_two().min(SAMPLES_PER_CORRELATION.max((4 * lags).next_power_of_two()));
    let (forward, back) = (crate::fft::forward(n), crate::fft::inverse(n));
    let (mut input, mut scratch) = (forward.make_input_vec(), forward.make_scratch_vec());
    let (mut block, mut longer) = (forward.make_output_vec(), forward.make_output_vec());
    let mut sum = forward.make_output_vec();
    for first in (0..x.len()).step_by(n - lags) {
        let own = &x[first..x.len().min(first + n - lags)];
        let before = &x[first.saturating_sub(lags)..first];
        for (before, spectrum) in [(&[][..], &mut block), (before, &mut longer)] {
            input.fill(0.0);
            input[lags - before.len()..lags].copy_from_slice(before);
            input[lags..lags + own.len()].copy_from_slice(own);
            if forward.process_with_scratch(&mut input, spectrum, &mut scratch).is_err() {
                // This cannot fail: all buffers have the lengths that the transforms require.
                return vec![];
            }
        }
        sum.iter_mut().zip(block.iter().zip(&longer)).for_each(|(sum, (a, b))| *sum += a * b.conj());
    }
    // The first and the last bin are real. Imaginary parts that rounding causes in these bins are set to zero, because the
    // inverse transform rejects them.
    for end in [0, n / 2] {
        sum[end].im = 0.0;
    }
    match back.process(&mut sum, &mut input) {
        Ok(()) => input[..=lags].iter().map(|sum| sum / n as f64).collect(),
        Err(_) => vec![],
    }
}

/// Length of a transform in [`self_products`], unless the signal is shorter or many lags need a longer transform.
const SAMPLES_PER_CORRELATION: usize = 1 << 12;

/// |X_k| / N for all bins k of the DFT of x (N samples), from frequency 0 to half the sample rate.
pub fn amplitudes(x: &[f64]) -> Vec<f64> {
    if x.is_empty() {
        return vec![];
    }
    let transform = crate::fft::forward(x.len());
    let (mut input, mut output) = (x.to_vec(), transform.make_output_vec());
    match transform.process(&mut input, &mut output) {
        Ok(()) => output.iter().map(|c| c.norm() / x.len() as f64).collect(),
        // This cannot fail: the transform has the length of x and makes the output buffer itself.
        Err(_) => vec![],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    fn noise(random: &mut Random, n: usize) -> Vec<f64> {
        (0..n).map(|_| random.normal()).collect()
    }

    #[test]
    fn algebra_of_sp() {
        let mut random = Random::new(2);
        for k in 1..20 {
            let n = 360 + 7 * k;
            let (m1, m2, v) = (noise(&mut random, n), noise(&mut random, n), noise(&mut random, n));
            let (a, b) = (random.normal(), random.normal());
            let sum: Vec<f64> = m1.iter().zip(&m2).map(|(x, y)| a * x + b * y).collect();
            let of = |m: &[f64]| sp(bin(m, k), bin(&v, k));
            // Allowed errors: rounding of sums of some 400 terms. Each bin is of the order of sqrt(n).
            assert!((of(&sum) - a * of(&m1) - b * of(&m2)).abs() < 1e-12);
            assert!((of(&v) - 1.0).abs() < 1e-12);
            let turn = |x: &[f64]| [&x[n / 3..], &x[..n / 3]].concat();
            let shifted = sp(bin(&turn(&m1), k), bin(&turn(&v), k));
            assert!((shifted - of(&m1)).abs() < 1e-12);
            let (c, d) = (bin(&m1, k), bin(&v, k));
            let by_angle = c.norm() * (c.arg() - d.arg()).cos() / d.norm();
            assert!((by_angle - of(&m1)).abs() < 1e-12);
        }
    }

    #[test]
    fn direct_bins_are_the_fft() {
        let x = noise(&mut Random::new(4), 667);
        for (k, a) in amplitudes(&x).iter().enumerate() {
            assert!((bin(&x, k).norm() / 667.0 - a).abs() < 1e-12);
        }
    }

    #[test]
    fn self_products_are_the_sums_of_their_definition() {
        // Lengths that give one block, and several blocks.
        for len in [300, 3 * SAMPLES_PER_CORRELATION] {
            let x = noise(&mut Random::new(6), len);
            for (lag, found) in self_products(&x, 40).iter().enumerate() {
                let expected: f64 = x[lag..].iter().zip(&x).map(|(a, b)| a * b).sum();
                // Allowed error: rounding of a sum of x.len() terms of order one.
                assert!((found - expected).abs() < 4e-14 * len as f64, "{lag}");
            }
        }
    }

    #[test]
    fn derivatives_of_harmonics_are_exact() {
        let (n, h) = (400, 1e-3);
        let w = std::f64::consts::TAU / (n as f64 * h);
        let x: Vec<f64> = (0..n).map(|i| 0.3 + (3.0 * w * i as f64 * h).sin()).collect();
        let [q, dq, ddq] = harmonic_derivatives(&x, h, 8);
        for i in 0..n {
            let t = i as f64 * h;
            assert!((q[i] - x[i]).abs() < 1e-13);
            assert!((dq[i] - 3.0 * w * (3.0 * w * t).cos()).abs() < 1e-11);
            assert!((ddq[i] + 9.0 * w * w * (3.0 * w * t).sin()).abs() < 1e-9);
        }
        let (d, dd) = circular_differences(&x, h);
        // The relative errors of central differences are w^2 h^2 / 6 and w^2 h^2 / 12, with w h = 0.047.
        assert!((0..n).all(|i| (d[i] - dq[i]).abs() < 0.02 && (dd[i] - ddq[i]).abs() < 0.5));
    }

    #[test]
    fn folding_keeps_the_bin_and_measures_the_noise() {
        let mut random = Random::new(9);
        let x: Vec<f64> =
            (0..4000).map(|i| (i as f64 * std::f64::consts::TAU / 500.0).cos() + 0.1 * random.normal()).collect();
        let folded = fold(&x, 500);
        for harmonic in 0..4 {
            let whole = bin(&x, 8 * harmonic) / 8.0;
            assert!((whole - bin(&folded, harmonic)).norm() < 1e-10);
        }
        // 3500 degrees of freedom: five standard errors are 6 %.
        assert!((scatter(&x, 500) / 0.1 - 1.0).abs() < 0.06);
        // 49 harmonics of eight periods have 686 degrees of freedom: five standard errors are 13 %. The added wave of amplitude
        // 1 has a higher frequency than these harmonics. The wave counts in `scatter`, but hardly in `scatter_of_harmonics`.
        assert!((scatter_of_harmonics(&x, 500, 49) / 0.1 - 1.0).abs() < 0.13);
        let chatter = |(i, x): (usize, &f64)| x + (i as f64 * std::f64::consts::TAU / 500.0 * 120.37).cos();
        let chattering: Vec<f64> = x.iter().enumerate().map(chatter).collect();
        assert!(scatter(&chattering, 500) > 0.5);
        assert!((scatter_of_harmonics(&chattering, 500, 49) / 0.1 - 1.0).abs() < 0.2);
        assert!(scatter_of_harmonics(&x[..500], 500, 49).is_nan() && scatter_of_harmonics(&x, 500, 0).is_nan());
    }
}
