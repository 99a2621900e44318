//! Formats numbers with significant digits.

/// The text of `x` with `digits` significant digits. Very small and very large numbers have an exponent.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".into() } else { "-".into() };
    }
    let power = x.abs().log10().floor() as i32;
    if !(-5..7).contains(&power) {
        return format!("{x:.*e}", digits.saturating_sub(1));
    }
    let decimals = (digits as i32 - 1 - power).max(0) as usize;
    format!("{x:.decimals$}")
}

/// A value and half of its interval as texts. Both are rounded to the second significant digit of the half interval.
pub(crate) fn with_interval(value: f64, half: f64) -> (String, String) {
    if !(half > 0.0 && half.is_finite()) {
        return (significant(value, 4), String::new());
    }
    let power = half.log10().floor() as i32;
    if !(-9..7).contains(&power) {
        return (format!("{value:.3e}"), format!("{half:.1e}"));
    }
    let decimals = (1 - power).max(0) as usize;
    (format!("{value:.decimals$}"), format!("{half:.decimals$}"))
}

/// The per cent sign, after a narrow no-break space.
const PERCENT_SIGN: &str = "\u{202f}%";

/// A share as text in per cent: `0.53 %`, `14.5 %`.
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        x if !x.is_finite() => "-".into(),
        x if x >= 99.95 => format!("{x:.0}{PERCENT_SIGN}"),
        x if x >= 9.995 => format!("{x:.1}{PERCENT_SIGN}"),
        x => format!("{x:.2}{PERCENT_SIGN}"),
    }
}

/// The text of a unit with raised exponents: `kg m²`.
pub fn unit(text: &str) -> String {
    text.replace("^2", "²").replace("^3", "³")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_that_count() {
        let all = [(0.0, "0"), (1234.56, "1235"), (0.012345, "0.0123"), (1.5e-7, "1.50e-7"), (-2.0, "-2.00")];
        for (x, text) in all {
            let digits = if x > 1000.0 { 4 } else { 3 };
            assert_eq!(significant(x, digits), text);
        }
        assert_eq!(with_interval(0.94977, 0.000294), ("0.94977".into(), "0.00029".into()));
        assert_eq!(with_interval(1.2e-5, 3.4e-7), ("0.00001200".into(), "0.00000034".into()));
        assert_eq!(with_interval(52.3, 120.0), ("52".into(), "120".into()));
        assert_eq!((percent(0.0053), percent(0.145)), ("0.53\u{202f}%".into(), "14.5\u{202f}%".into()));
        assert_eq!(unit("kg m^2"), "kg m²");
    }
}
