//! The discrete Fourier transform of real signals, by the crate `realfft`.
//!
//! X_k = sum_i x_i exp(-2 pi j k i / N) for k = 0 .. N/2, of a signal x of N samples. The inverse transform gives N x_i.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use realfft::RealFftPlanner;
pub use realfft::num_complex::Complex;
pub use realfft::{ComplexToReal, RealToComplex};

/// Makes the Fourier transform of real signals of `n` samples. The result of the transform has n/2 + 1 bins.
pub fn forward(n: usize) -> Arc<dyn RealToComplex<f64>> {
    RealFftPlanner::new().plan_fft_forward(n)
}

/// Makes the inverse transform: from the spectrum of a signal of `n` samples to `n` times the signal.
pub fn inverse(n: usize) -> Arc<dyn ComplexToReal<f64>> {
    RealFftPlanner::new().plan_fft_inverse(n)
}

/// Transforms for signals of several lengths. The plan of each length is kept, because making a plan takes as long as a
/// transform.
#[derive(Clone, Default)]
pub struct Plans(BTreeMap<usize, Arc<dyn RealToComplex<f64>>>);

impl Plans {
    /// The transform of signals of `n` samples.
    pub fn forward(&mut self, n: usize) -> Arc<dyn RealToComplex<f64>> {
        self.0.entry(n).or_insert_with(|| forward(n)).clone()
    }
}

impl fmt::Debug for Plans {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_set().entries(self.0.keys()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spectrum_is_the_sum_over_the_samples_and_leads_back() {
        // Lengths: even, odd, and a prime for which the library has no special algorithm.
        for n in [12, 15, 37] {
            let x: Vec<f64> = (0..n).map(|i| ((i * i) % 7) as f64 - 2.5).collect();
            let transform = forward(n);
            let (mut input, mut spectrum) = (x.clone(), transform.make_output_vec());
            transform.process(&mut input, &mut spectrum).unwrap();
            assert_eq!(spectrum.len(), n / 2 + 1);
            for (k, found) in spectrum.iter().enumerate() {
                let turn = |i: usize| Complex::cis(-std::f64::consts::TAU * (k * i % n) as f64 / n as f64);
                let sum: Complex<f64> = x.iter().enumerate().map(|(i, x)| turn(i) * x).sum();
                // Allowed error: rounding of a sum of n terms of magnitude 3.
                assert!((found - sum).norm() < 1e-13 * n as f64, "{n} {k}: {found} {sum}");
            }
            let mut back = vec![0.0; n];
            inverse(n).process(&mut spectrum, &mut back).unwrap();
            assert!(back.iter().zip(&x).all(|(b, x)| (b / n as f64 - x).abs() < 1e-13), "{n}: {back:?}");
        }
    }
}
