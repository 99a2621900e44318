//! The scale of an axis: converts values into positions, and finds ticks at round numbers.
//!
//! A decade is a factor of ten on a logarithmic axis.

/// The scale of an axis. The two ends of the axis are never equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
    is_logarithmic: bool,
}

impl Scale {
    /// A linear axis that includes all finite values. `margin`: share of the range of the values that is added at both ends.
    pub fn linear(values: impl Iterator<Item = f64>, margin: f64) -> Scale {
        let (low, high) = ends(values);
        let (low, high) = match high - low {
            d if d > 0.0 && d.is_finite() => (low - margin * d, high + margin * d),
            _ if low.is_finite() => (low - 0.5, low + 0.5),
            _ => (0.0, 1.0),
        };
        Scale { low, high, is_logarithmic: false }
    }

    /// A logarithmic axis that includes all positive values. With `round` it ends at powers of ten.
    pub fn logarithmic(values: impl Iterator<Item = f64>, round: bool) -> Scale {
        let (low, high) = ends(values.filter(|x| *x > 0.0).map(f64::log10));
        let (low, high) = if round { (low.floor(), high.ceil()) } else { (low, high) };
        let (low, high) = if high > low { (low, high) } else { (0.0, 1.0) };
        Scale { low, high, is_logarithmic: true }
    }

    /// The length of the axis, in units of the values; for a logarithmic axis in decades.
    pub fn length(&self) -> f64 {
        self.high - self.low
    }

    /// The lower and the upper end of the axis; exponents of ten for a logarithmic axis.
    pub(crate) fn ends(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// The axis with another length and the same middle.
    pub(crate) fn of_length(self, length: f64) -> Scale {
        let middle = 0.5 * (self.low + self.high);
        Scale { low: middle - 0.5 * length, high: middle + 0.5 * length, ..self }
    }

    /// The position of a value on the axis: 0 at the lower end, 1 at the upper end. A value outside has a position below 0
    /// or above 1.
    pub fn place(&self, value: f64) -> f64 {
        let value = if self.is_logarithmic { value.max(f64::MIN_POSITIVE).log10() } else { value };
        (value - self.low) / (self.high - self.low)
    }

    /// Ticks at round numbers on the axis, with their labels.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        if self.is_logarithmic {
            return self.decades();
        }
        let rough = (self.high - self.low) / 5.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0].into_iter().map(|f| f * power).find(|s| *s >= rough).unwrap_or(10.0 * power);
        let first = (self.low / step).ceil();
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let tick = |i: usize| (first + i as f64) * step;
        let text = |x: f64| match (x == 0.0, decimals) {
            (true, _) => "0".to_string(),
            (_, 0..=4) if x.abs() < 1e5 => format!("{x:.decimals$}"),
            _ => format!("{x:.0e}"),
        };
        (0..12).map(tick).take_while(|x| *x <= self.high + 1e-9 * step).map(|x| (x, text(x))).collect()
    }

    /// Ticks at powers of ten; on a short axis also at two and five times these powers.
    fn decades(&self) -> Vec<(f64, String)> {
        let factors: &[f64] = if self.high - self.low > 1.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let between = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = between.flat_map(|k| factors.iter().map(move |f| f * 10f64.powi(k)));
        let inside = |x: &f64| (-1e-9..=1.0 + 1e-9).contains(&self.place(*x));
        let mut ticks: Vec<f64> = all.filter(inside).collect();
        // If there are many decades, only every second or third is labelled.
        let step = ticks.len().div_ceil(6).max(1);
        ticks = ticks.into_iter().step_by(step).collect();
        let text = |x: f64| if (0.001..10_000.0).contains(&x) { format!("{}", trimmed(x)) } else { format!("{x:.0e}") };
        ticks.into_iter().map(|x| (x, text(x))).collect()
    }
}

/// Removes rounding errors from a power of ten times one, two or five.
fn trimmed(x: f64) -> f64 {
    format!("{x:.0e}").parse().unwrap_or(x)
}

fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.filter(|x| x.is_finite()).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(scale: Scale) -> Vec<String> {
        scale.ticks().into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let scale = Scale::linear([0.0, 1.0].into_iter(), 0.0);
        assert_eq!(texts(scale), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(texts(Scale::linear([-7.3, 12.9].into_iter(), 0.0)), ["-5", "0", "5", "10"]);
        assert!(texts(Scale::linear([1e-7, 3e-7].into_iter(), 0.0)).iter().all(|t| t.contains("e-7")));
        assert_eq!(texts(Scale::logarithmic([0.03, 20.0].into_iter(), true)), ["0.01", "0.1", "1", "10", "100"]);
    }

    #[test]
    fn no_value_and_one_value_have_an_axis() {
        for scale in [
            Scale::linear(std::iter::empty(), 0.1),
            Scale::linear([3.0, f64::NAN].into_iter(), 0.1),
            Scale::logarithmic([0.0].into_iter(), true),
        ] {
            assert!(scale.place(0.3).is_finite() && !scale.ticks().is_empty(), "{scale:?}");
        }
    }
}
