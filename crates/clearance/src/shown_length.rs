//! A length as a sentence shows it.

/// Decimals that a robot's lengths are shown with: a tenth of a millimetre.
const DECIMALS: usize = 4;
/// A length below this would be shown with a digit or none, m.
const SMALL_M: f64 = 1e-3;

/// With four decimals, without a unit; one below a millimetre with two digits and its power of ten, so that only zero is shown as zero.
pub fn shown_length(metres: f64) -> String {
    if metres == 0.0 || metres.abs() >= SMALL_M { format!("{metres:.DECIMALS$}") } else { format!("{metres:.1e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_zero_is_shown_as_zero() {
        for (metres, shown) in [
            (0.05, "0.0500"),
            (-1.25, "-1.2500"),
            (4.2e-4, "4.2e-4"),
            (1e-46, "1.0e-46"),
            (-3e-9, "-3.0e-9"),
            (0.0, "0.0000"),
        ] {
            assert_eq!(shown_length(metres), shown);
        }
    }
}
