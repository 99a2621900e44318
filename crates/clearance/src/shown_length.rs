//! Formats a length as text in a sentence.

/// Number of decimals of a length in m: the last one is a tenth of a millimetre.
const DECIMALS: usize = 4;
/// Lengths below this value (m) are printed with a power of ten, because four decimals would show one digit or none.
const FOUR_DECIMALS_FROM_M: f64 = 1e-3;

/// A length in m as text with four decimals, without a unit. A length below a millimetre has two digits and a power of ten,
/// so that only the length zero is shown as zero.
pub fn shown_length(metres: f64) -> String {
    if metres == 0.0 || metres.abs() >= FOUR_DECIMALS_FROM_M {
        format!("{metres:.DECIMALS$}")
    } else {
        format!("{metres:.1e}")
    }
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
