//! Finds clocks in two columns: whole seconds in one column, and fractions of a second in another.
//!
//! Examples: `sec` and `nanosec`, `time_stamp_sec` and `time_stamp_nano_sec`, `header.stamp.sec` and `header.stamp.nanosec`.

use crate::table::Table;

/// Words for whole seconds at the end of a header.
const SECONDS: [&str; 3] = ["seconds", "secs", "sec"];
/// Words for fractions of a second at the end of a header, each with the unit and its value in s.
const FRACTIONS: [(&str, &str, f64); 8] = [
    ("nanoseconds", "ns", 1e-9),
    ("nanosecs", "ns", 1e-9),
    ("nanosec", "ns", 1e-9),
    ("nano_sec", "ns", 1e-9),
    ("nsecs", "ns", 1e-9),
    ("nsec", "ns", 1e-9),
    ("microseconds", "us", 1e-6),
    ("usec", "us", 1e-6),
];

/// A column of fractions of a second: its index, the name of its unit, and its unit in s.
pub(crate) type Fraction = (usize, &'static str, f64);

/// The columns of whole seconds, each with the column of its fractions.
pub(crate) fn pairs(table: &Table) -> Vec<(usize, Fraction)> {
    let lower: Vec<String> = table.header.iter().map(|h| h.to_lowercase()).collect();
    let all = |column: usize, holds: &dyn Fn(f64) -> bool| {
        table.columns[column].iter().filter(|x| x.is_finite()).all(|x| holds(*x))
    };
    let is_end = |before: &str| before.is_empty() || before.ends_with(|c: char| !c.is_alphanumeric());
    let fraction = |before: &str| {
        FRACTIONS.iter().find_map(|(name, unit, factor)| {
            let at = lower.iter().position(|h| h.strip_prefix(before) == Some(name))?;
            Some((at, *unit, *factor))
        })
    };
    let pair = |(column, header): (usize, &String)| {
        let before = SECONDS.iter().find_map(|name| header.strip_suffix(name).filter(|before| is_end(before)))?;
        let fraction = fraction(before)?;
        // Excludes two columns with the same time, one in seconds with decimals and one in nanoseconds.
        let are_parts =
            all(column, &|x| x.fract() == 0.0) && all(fraction.0, &|x| (0.0..1.0).contains(&(x * fraction.2)));
        are_parts.then_some((column, fraction))
    };
    lower.iter().enumerate().filter_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, numbers: &[f64]) -> Vec<(usize, Fraction)> {
        let header: Vec<String> = text.split(' ').map(str::to_string).collect();
        let columns = header.iter().zip(numbers).map(|(_, x)| vec![*x]).collect();
        pairs(&Table { header, columns, ..Table::default() })
    }

    #[test]
    fn seconds_have_their_fractions_beside_them() {
        assert_eq!(of("q time_stamp_sec time_stamp_nano_sec", &[0.5, 7.0, 5e8]), [(1, (2, "ns", 1e-9))]);
        assert_eq!(of("header.stamp.nanosec header.stamp.sec", &[5e8, 7.0]), [(1, (0, "ns", 1e-9))]);
        assert_eq!(of("sec usec", &[0.0, 1.0]), [(0, (1, "us", 1e-6))]);
        for (header, numbers) in [
            ("a_sec b_nanosec", [1.0, 5e8]),
            ("t q", [1.0, 1.0]),
            // Both columns contain the same time, so they are no pair.
            ("t_sec t_nanosec", [1.5, 1.5e9]),
            ("t_sec t_nanosec", [1.0, 1e9]),
        ] {
            assert!(of(header, &numbers).is_empty(), "{header}");
        }
    }
}
