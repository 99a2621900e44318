//! dx/dt of a sampled signal: central differences, one-sided at the two ends.
//!
//! Of fourth order where the clock is even,
//!   (8 (x_1 - x_-1) - (x_2 - x_-2)) / 12 h:
//! at 100 Hz, second order takes 0.5 % off the acceleration of a motion of 2 Hz, and so adds it to every inertia. Of second
//! order on any other clock, with steps a before and b after, as `numpy.gradient(x, t)`:
//!   (a^2 x_1 + (b^2 - a^2) x - b^2 x_-1) / (a b (a + b)).

/// dx/dt at every sample.
pub fn gradient(x: &[f64], t: &[f64]) -> Vec<f64> {
    (0..x.len()).map(|i| slope(x, t, i)).collect()
}

/// Steps that differ by less than this are even: a clock is written in rounded numbers.
const EVEN: f64 = 1e-3;

/// dx/dt at sample i.
pub fn slope(x: &[f64], t: &[f64], i: usize) -> f64 {
    let last = x.len() - 1;
    if i == 0 || i == last {
        let (i, j) = if i == 0 { (0, 1.min(last)) } else { (last - 1, last) };
        return if i < j { (x[j] - x[i]) / (t[j] - t[i]) } else { 0.0 };
    }
    if i >= 2 && i + 2 <= last {
        let h = (t[i + 2] - t[i - 2]) / 4.0;
        if t[i - 2..=i + 2].windows(2).all(|t| (t[1] - t[0] - h).abs() <= EVEN * h) {
            return (8.0 * (x[i + 1] - x[i - 1]) - (x[i + 2] - x[i - 2])) / (12.0 * h);
        }
    }
    let (a, b) = (t[i] - t[i - 1], t[i + 1] - t[i]);
    (a * a * x[i + 1] + (b * b - a * a) * x[i] - b * b * x[i - 1]) / (a * b * (a + b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures of `numpy.gradient(z, t)`, NumPy 2.4.6.
    #[test]
    fn gradient_agrees_with_numpy() {
        let d = gradient(&[1.0, 2.0, 0.0, 5.0, 3.0], &[0.0, 0.1, 0.25, 0.3, 0.5]);
        for (d, e) in d.into_iter().zip([10.0, 0.6666666666666661, 71.66666666666669, 78.00000000000003, -10.0]) {
            assert!((d - e).abs() < 1e-12, "{d} {e}");
        }
    }

    #[test]
    fn on_an_even_clock_it_is_exact_to_the_fourth_power() {
        let t: Vec<f64> = (0..9).map(|i| 0.01 * i as f64).collect();
        let x: Vec<f64> = t.iter().map(|t| t.powi(4) - t).collect();
        for (i, d) in gradient(&x, &t).into_iter().enumerate().take(7).skip(2) {
            assert!((d - (4.0 * t[i].powi(3) - 1.0)).abs() < 1e-13, "{i} {d}");
        }
    }

    #[test]
    fn gradient_of_a_parabola_is_exact_inside() {
        let t: Vec<f64> = (0..30).map(|i| (i as f64).powf(1.2)).collect();
        let x: Vec<f64> = t.iter().map(|t| 3.0 * t * t - t).collect();
        for (i, d) in gradient(&x, &t).into_iter().enumerate().take(29).skip(1) {
            assert!((d - (6.0 * t[i] - 1.0)).abs() < 1e-9);
        }
    }
}
