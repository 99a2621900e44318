//! Writes a certificate, and the parameters that a motion identifies, as tables for users, with units and significant digits.

use claims::significant;

use crate::excitation::limit_kind::LimitKind;
use crate::excitation::proof::{CertificateRow, LimitProof};
use crate::excitation::visibility::VisibleParameter;

/// Summary of all certificate rows of one kind of limit, such as velocity.
pub struct LimitSummary<'a> {
    /// The kind of limit.
    pub limit: LimitKind,
    /// Number of rows of this kind.
    pub count: usize,
    /// Number of proven rows of this kind.
    pub proven: usize,
    /// The proven row with the least distance to its bound, relative to the bound. `None`: no row is proven.
    pub nearest: Option<&'a CertificateRow>,
    /// The rows of this kind that are not proven.
    pub faults: Vec<&'a CertificateRow>,
}

/// Summarises a certificate, one entry per kind of limit. Kinds without rows are omitted.
pub fn certificate_summary(rows: &[CertificateRow]) -> Vec<LimitSummary<'_>> {
    let share = |r: &CertificateRow| r.room() / r.bound.abs().max(f64::MIN_POSITIVE);
    let of_kind = |limit: LimitKind| {
        let own = rows.iter().filter(move |r| r.limit == limit);
        let (proven, faults): (Vec<&CertificateRow>, Vec<_>) = own.partition(|r| r.kept == LimitProof::Proven);
        let nearest = proven.iter().copied().min_by(|a, b| share(a).total_cmp(&share(b)));
        LimitSummary { limit, count: proven.len() + faults.len(), proven: proven.len(), nearest, faults }
    };
    LimitKind::ALL.map(of_kind).into_iter().filter(|summary| summary.count > 0).collect()
}

impl CertificateRow {
    /// Describes the certificate row in words. `is_prismatic`: whether the joint slides; `None`: unknown, so both units are
    /// given.
    pub fn in_words(&self, is_prismatic: Option<bool>) -> String {
        let CertificateRow { limit, subject, .. } = self;
        let unit = limit.unit_of(is_prismatic);
        let (value, bound) = self.digits();
        let time = significant(self.time_s, TIME_DIGITS);
        let start = format!("{limit} of {subject}: {value} {unit} at {time} s");
        match self.kept {
            LimitProof::Proven => format!("{start}, bound {bound} {unit}, proven"),
            LimitProof::Violated => {
                let beyond = significant((self.value - self.bound).abs(), 3);
                format!("{start} is beyond {bound} {unit} by {beyond} {unit}")
            }
            LimitProof::Open => {
                let nowhere = significant(self.nowhere_beyond, MAX_DIGITS);
                format!("{start}, bound {bound} {unit}, not proven: nowhere beyond {nowhere} {unit}")
            }
        }
    }

    /// Value and bound of the row as text, with at least four digits, and with more digits if the two texts would be equal.
    fn digits(&self) -> (String, String) {
        let both = |digits| (significant(self.value, digits), significant(self.bound, digits));
        (MIN_DIGITS..MAX_DIGITS).map(both).find(|(value, bound)| value != bound).unwrap_or_else(|| both(MAX_DIGITS))
    }
}

/// Least number of digits with which a value and its bound are printed.
const MIN_DIGITS: usize = 4;
/// Greatest number of printed digits, because a proof is not more accurate than that.
const MAX_DIGITS: usize = 7;
/// Digits of a printed time: they resolve a tenth of a millisecond in a time of ten seconds.
const TIME_DIGITS: usize = 6;

/// A certificate as text: each violated or unproven row, then the nearest proven row of each kind of limit. `is_prismatic` says
/// whether the coordinate of a name slides; `None` if the name is not a coordinate.
pub fn certificate_text(rows: &[CertificateRow], is_prismatic: &dyn Fn(&str) -> Option<bool>) -> String {
    let summaries = certificate_summary(rows);
    let nearest = summaries.iter().filter_map(|summary| summary.nearest);
    let width = nearest.map(|row| row.subject.chars().count()).max().unwrap_or(0).max("nearest".len());
    let mut text = String::new();
    if summaries.iter().any(|summary| summary.nearest.is_some()) {
        let head = ("limit", "proven", "nearest", "value", "bound", "at, s");
        text = format!(
            "{:<13} {:>8}  {:<width$} {:>10} {:>10} {:>8}  unit\n",
            head.0, head.1, head.2, head.3, head.4, head.5
        );
    }
    for LimitSummary { limit, count, proven, nearest, faults } in summaries {
        if let Some(row) = nearest {
            let (share, (value, bound)) = (format!("{proven} of {count}"), row.digits());
            let (time, unit) = (significant(row.time_s, TIME_DIGITS), limit.unit_of(is_prismatic(&row.subject)));
            let subject = &row.subject;
            text += &format!("{limit:<13} {share:>8}  {subject:<width$} {value:>10} {bound:>10} {time:>8}  {unit}\n");
        }
        faults.iter().for_each(|row| text += &format!("{}\n", row.in_words(is_prismatic(&row.subject))));
    }
    text
}

/// Table of all parameters of a model with the standard deviations that a motion gives them. Standard deviations have two digits;
/// nominal values have as many decimals as their standard deviations.
pub fn parameters_text(parameters: &[VisibleParameter]) -> String {
    let width = parameters.iter().map(|p| p.id.to_string().chars().count()).max().unwrap_or(0).max("parameter".len());
    let mut text = format!("{:<width$}  {:>11} {:>11} {:>10}  unit\n", "parameter", "nominal", "sigma", "relative");
    for p in parameters {
        // Number of decimals up to the second digit of the standard deviation.
        let decimals = |deviation: f64| (1.0 - deviation.abs().log10().floor()).clamp(0.0, 9.0) as usize;
        let described = match (p.described, p.deviation.filter(|x| *x > 0.0)) {
            (None, _) => "-".into(),
            (Some(x), None) => significant(x, 4),
            (Some(x), Some(deviation)) => {
                let shown = format!("{x:.0$}", decimals(deviation));
                if shown.parse() == Ok(0.0) { "0".into() } else { shown }
            }
        };
        let deviation = p.deviation.map_or("-".into(), |x| significant(x, 2));
        let relative = p.relative_deviation.map_or("-".into(), |r| format!("{} %", significant(100.0 * r, 2)));
        let remark = p.remark().map_or(String::new(), |remark| format!("  {remark}"));
        let (id, unit) = (p.id.to_string(), p.unit);
        text += &format!("{id:<width$}  {described:>11} {deviation:>11} {relative:>10}  {unit}{remark}\n");
    }
    text
}
