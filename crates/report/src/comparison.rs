//! Compares two estimates of one robot, for example from two days, two loads or two methods.
//!
//! z = (a - b) / sqrt(sigma_a^2 + sigma_b^2). a, b: the values of a parameter in the two estimates. If both are independent
//! estimates of the same value, |z| exceeds 1.96 by chance in one of twenty cases.

use identification::estimate::artefact::Estimate;
use identification::estimate::identified::{INTERVAL, Identified};
use serde::Serialize;

use crate::number::{significant, unit, with_interval};

/// The second estimate of a comparison, and the name of the file with this estimate.
#[derive(Clone, Copy, Debug)]
pub struct OtherEstimate<'a> {
    /// Name of the file of the estimate.
    pub name: &'a str,
    /// The second estimate, with which the estimate of the page is compared.
    pub estimate: &'a Estimate,
}

/// A comparison of two estimates for the page: a summary, and one row per parameter, sorted by |z|, the largest first.
#[derive(Serialize)]
pub(crate) struct Comparison {
    summary: String,
    other: String,
    rows: Vec<ComparisonRow>,
}

#[derive(Serialize)]
struct ComparisonRow {
    name: String,
    unit: String,
    value: String,
    half: String,
    other: String,
    other_half: String,
    difference: String,
    /// |z|; the next field `bar` is the length of its bar, 0 to 100.
    deviations: f64,
    bar: f64,
    is_moved: bool,
}

/// Value of |z| at which a bar is full.
const FULL_BAR_SIGMAS: f64 = 10.0;

/// Both values of a parameter, and z: the difference of the values divided by the standard deviation of this difference. `None`
/// if a value or a standard deviation is missing.
fn apart(a: &Identified, b: &Identified) -> Option<(f64, f64, f64)> {
    let (x, y) = (a.value?, b.value?);
    let z = (x - y) / a.sigma?.hypot(b.sigma?);
    z.is_finite().then_some((x, y, z))
}

/// Compares the parameters that both estimates have.
pub(crate) fn comparison(estimate: &Estimate, other: OtherEstimate) -> Comparison {
    let found = estimate.parameters.iter().filter_map(|a| {
        let b = other.estimate.parameters.iter().find(|b| b.id == a.id)?;
        let (x, y, z) = apart(a, b)?;
        let half = |p: &Identified| INTERVAL * p.sigma.unwrap_or(0.0);
        let ((value, own), (theirs, other_half)) = (with_interval(x, half(a)), with_interval(y, half(b)));
        Some(ComparisonRow {
            name: a.id.to_string(),
            unit: unit(&a.unit.to_string()),
            value,
            half: own,
            other: theirs,
            other_half,
            difference: significant(x - y, 3),
            deviations: z.abs(),
            bar: (100.0 * z.abs() / FULL_BAR_SIGMAS).min(100.0),
            is_moved: z.abs() > INTERVAL,
        })
    });
    // The rows are sorted by |z|, because z makes parameters with different units comparable.
    let mut rows: Vec<ComparisonRow> = found.collect();
    rows.sort_by(|a, b| b.deviations.total_cmp(&a.deviations));
    let moved = rows.iter().filter(|row| row.is_moved).count();
    Comparison {
        summary: format!(
            "{moved} of {} parameters differ by more than {INTERVAL:.2} sigma of their difference; of two estimates of the \
             same robot, {:.1} would by chance",
            rows.len(),
            0.05 * rows.len() as f64
        ),
        other: other.name.into(),
        rows,
    }
}

#[cfg(test)]
mod tests {
    use identification::estimate::identified::Deviations;
    use linear_model::unit::Unit;

    use super::*;

    #[test]
    fn what_differs_most_stands_first() {
        let of = |zz: f64, fv: f64| {
            let one = |name: &str, value: f64, sigma: f64| {
                Identified::new(name.parse().unwrap(), Unit::INERTIA, value, Deviations::white(sigma))
            };
            Estimate { parameters: vec![one("FV1", fv, 0.1), one("ZZR1", zz, 0.03)], ..Estimate::default() }
        };
        let (a, b) = (of(1.0, 2.0), of(0.8, 2.1));
        let found = comparison(&a, OtherEstimate { name: "b", estimate: &b });
        // Expected z: 0.2 / (0.03 sqrt 2) and 0.1 / (0.1 sqrt 2).
        let deviations: Vec<f64> = found.rows.iter().map(|row| row.deviations).collect();
        assert!(
            (deviations[0] - 4.714).abs() < 1e-3 && (deviations[1] - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-3,
            "{deviations:?}"
        );
        assert_eq!(
            (found.rows[0].name.as_str(), found.rows[0].is_moved, found.rows[1].is_moved),
            ("ZZR1", true, false)
        );
        assert!(found.summary.starts_with("1 of 2 parameters differ"), "{}", found.summary);
        assert!(comparison(&a, OtherEstimate { name: "a", estimate: &a }).rows.iter().all(|row| !row.is_moved));
    }
}
