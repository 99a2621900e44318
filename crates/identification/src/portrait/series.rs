//! Measured and predicted torques sample by sample, as CSV.
//!
//! A row is one instant after the filter and the decimation of the fit: `log`, `t` (s of the log's clock), and for each
//! coordinate `measured_`, `predicted_` (N m, N) and `counts_` (0 where the joint stands still and the row was left out).

use std::fmt::Write;

use logs::{Error, LogSource};

use crate::estimate::options::Options;
use crate::model::linear_model::Model;
use crate::portrait::split::split;
use crate::signals::records::{Records, SourceRecords};

/// The text of the file for logs under parameters `x`.
///
/// Fails when a log cannot be read.
pub fn series(model: &Model, x: &[f64], options: &Options, logs: &[LogSource]) -> Result<String, Error> {
    let mut text = "log,t".to_string();
    // A String never fails to grow.
    for name in model.regressor.coordinates() {
        let _ = write!(text, ",measured_{name},predicted_{name},counts_{name}");
    }
    text.push('\n');
    for log in logs {
        let name = quoted(&log.name());
        let records = SourceRecords::new(model.regressor, std::slice::from_ref(log), &options.preparation())?;
        records.each(&mut |states| {
            split(model, x, states, |r, torques| {
                let _ = write!(text, "{name},{:.6}", states.t[r]);
                for torque in torques {
                    let counts = u8::from(torque.counts);
                    let _ = write!(text, ",{:.6e},{:.6e},{counts}", torque.measured, torque.predicted());
                }
                text.push('\n');
            });
        })?;
    }
    Ok(text)
}

/// A field of CSV.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_commas_stay_one_field() {
        assert_eq!((quoted("a.csv"), quoted("a,\"b\"")), ("a.csv".into(), "\"a,\"\"b\"\"\"".into()));
    }
}
