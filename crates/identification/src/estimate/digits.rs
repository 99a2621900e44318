//! Prints numbers as text for sentences in reports: plain numbers with few digits, and shares in percent.

/// Prints x without decimals from 100 on, with one decimal from 10, two from 0.1 and four below. Numbers below 1e-3, and from
/// 1e5 on, have an exponent.
pub fn significant(x: f64) -> String {
    let size = x.abs();
    match size {
        _ if size == 0.0 => "0".into(),
        _ if !(1e-3..1e5).contains(&size) => format!("{x:.2e}"),
        _ if size >= 100.0 => format!("{x:.0}"),
        _ if size >= 10.0 => format!("{x:.1}"),
        _ if size >= 0.1 => format!("{x:.2}"),
        _ => format!("{x:.4}"),
    }
}

/// Prints a share x in percent, with two decimals below 10 % and one decimal above: `0.53 %`.
pub fn percent(x: f64) -> String {
    let x = 100.0 * x;
    if x.abs() >= 10.0 { format!("{x:.1} %") } else { format!("{x:.2} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_that_count() {
        assert_eq!((percent(0.00532), percent(0.145)), ("0.53 %".into(), "14.5 %".into()));
        assert_eq!(percent(-0.6), "-60.0 %");
    }
}
