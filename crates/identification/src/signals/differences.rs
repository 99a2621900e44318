//! Computes the derivative dx/dt of a sampled signal by central differences, and by one-sided differences at both ends.
//!
//! On a uniform clock with period h the central differences are of fourth order,
//!   (8 (x_1 - x_-1) - (x_2 - x_-2)) / 12 h.
//! At 100 Hz, second order would reduce the acceleration of a motion of 2 Hz by 0.5 %, and so raise every estimated inertia by
//! 0.5 %. On other clocks the central differences are of second order. With the step a before the sample and the step b after
//! it, they equal `numpy.gradient(x, t)`:
//!   (a^2 x_1 + (b^2 - a^2) x - b^2 x_-1) / (a b (a + b)).

/// Clock steps with at most this relative difference are equal. Times in logs are rounded.
const EVEN_STEP_TOLERANCE: f64 = 1e-3;

/// Computes derivatives of signals on one clock. The clock is examined once for all signals.
pub struct Differences<'a> {
    t: &'a [f64],
    /// The denominator 12 h, s, of each sample from the third to the third last. h: mean clock step of the five samples around
    /// this sample.
    twelve_steps: Vec<f64>,
    /// Indices of samples whose derivative is of second order: two samples at each end, and the samples with unevenly spaced
    /// neighbours.
    uneven: Vec<usize>,
}

impl<'a> Differences<'a> {
    /// Prepares differences on the clock `t`, s, ascending.
    pub fn new(t: &'a [f64]) -> Differences<'a> {
        let step = |t: &[f64]| (t[4] - t[0]) / 4.0;
        let is_even =
            |t: &[f64]| t.windows(2).all(|pair| (pair[1] - pair[0] - step(t)).abs() <= EVEN_STEP_TOLERANCE * step(t));
        let ends = [0, 1, t.len().saturating_sub(2), t.len().saturating_sub(1)];
        let mut uneven: Vec<usize> = ends.into_iter().filter(|&i| i < t.len()).collect();
        uneven.extend(t.windows(5).enumerate().filter(|(_, t)| !is_even(t)).map(|(i, _)| i + 2));
        uneven.sort_unstable();
        uneven.dedup();
        Differences { t, twelve_steps: t.windows(5).map(|t| 12.0 * step(t)).collect(), uneven }
    }

    /// dx/dt at every sample, in the unit of x per s.
    pub fn of(&self, x: &[f64]) -> Vec<f64> {
        let two = || std::iter::repeat_n(0.0, 2.min(x.len()));
        let even = x.windows(5).zip(&self.twelve_steps).map(|(x, h)| fourth_order(x, *h));
        let mut slopes: Vec<f64> = two().chain(even).chain(two()).take(x.len()).collect();
        self.uneven.iter().for_each(|&i| slopes[i] = second_order(x, self.t, i));
        slopes
    }

    /// dx/dt at sample i, in the unit of x per s.
    pub fn at(&self, x: &[f64], i: usize) -> f64 {
        match self.uneven.binary_search(&i) {
            Ok(_) => second_order(x, self.t, i),
            Err(_) => fourth_order(&x[i - 2..=i + 2], self.twelve_steps[i - 2]),
        }
    }
}

/// dx/dt at the middle of five samples, of fourth order. `h`: twelve clock steps, s.
fn fourth_order(x: &[f64], h: f64) -> f64 {
    (8.0 * (x[3] - x[1]) - (x[4] - x[0])) / h
}

/// dx/dt at sample i, of second order; one-sided at the ends.
fn second_order(x: &[f64], t: &[f64], i: usize) -> f64 {
    let last = x.len() - 1;
    if i == 0 || i == last {
        let (i, j) = if i == 0 { (0, 1.min(last)) } else { (last - 1, last) };
        return if i < j { (x[j] - x[i]) / (t[j] - t[i]) } else { 0.0 };
    }
    let (a, b) = (t[i] - t[i - 1], t[i + 1] - t[i]);
    (a * a * x[i + 1] + (b * b - a * a) * x[i] - b * b * x[i - 1]) / (a * b * (a + b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Results of `numpy.gradient(z, t)`, NumPy 2.4.6.
    #[test]
    fn gradient_agrees_with_numpy() {
        let d = Differences::new(&[0.0, 0.1, 0.25, 0.3, 0.5]).of(&[1.0, 2.0, 0.0, 5.0, 3.0]);
        for (d, e) in d.into_iter().zip([10.0, 0.6666666666666661, 71.66666666666669, 78.00000000000003, -10.0]) {
            assert!((d - e).abs() < 1e-12, "{d} {e}");
        }
    }

    #[test]
    fn on_an_even_clock_it_is_exact_to_the_fourth_power() {
        let t: Vec<f64> = (0..9).map(|i| 0.01 * i as f64).collect();
        let x: Vec<f64> = t.iter().map(|t| t.powi(4) - t).collect();
        for (i, d) in Differences::new(&t).of(&x).into_iter().enumerate().take(7).skip(2) {
            assert!((d - (4.0 * t[i].powi(3) - 1.0)).abs() < 1e-13, "{i} {d}");
        }
    }

    #[test]
    fn gradient_of_a_parabola_is_exact_inside() {
        let t: Vec<f64> = (0..30).map(|i| (i as f64).powf(1.2)).collect();
        let x: Vec<f64> = t.iter().map(|t| 3.0 * t * t - t).collect();
        for (i, d) in Differences::new(&t).of(&x).into_iter().enumerate().take(29).skip(1) {
            assert!((d - (6.0 * t[i] - 1.0)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_sample_alone_has_the_slope_it_has_among_all() {
        let uneven: Vec<f64> = (0..40).map(|i| 0.01 * f64::from(i) + if i % 13 == 7 { 0.002 } else { 0.0 }).collect();
        for t in (0..7).map(|count| &uneven[..count]).chain([&uneven[..]]) {
            let x: Vec<f64> = t.iter().map(|t| (9.0 * t).sin()).collect();
            let differences = Differences::new(t);
            let all = differences.of(&x);
            assert_eq!(all.len(), t.len());
            assert!(all.iter().enumerate().all(|(i, slope)| differences.at(&x, i) == *slope), "{}", t.len());
        }
    }
}
