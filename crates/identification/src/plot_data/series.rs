//! Computes the measured torques of logs and the torques that an estimate predicts for them, sample by sample, and writes both
//! as CSV or Parquet.

use std::fmt::Write;

use gate::shown::csv_cell;
use linear_model::linear_model::Model;
use logs::{Cells, Error, LogSource};

use crate::estimate::options::Options;
use crate::signals::records::{Records, SourceRecords};

/// The torques of a log over time, filtered and decimated as for the fit: rows of n joints, N m (N).
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueSeries {
    /// Name of the log, as the user gave it.
    pub name: String,
    /// Time by the clock of the log, s, one per sample.
    pub t: Vec<f64>,
    /// Measured torques tau, n values per sample.
    pub measured: Vec<f64>,
    /// Predicted torques W X, n values per sample. NaN in unused rows, that is, if the joint is at standstill.
    pub predicted: Vec<f64>,
}

/// Makes the torque series of logs, one per log, predicted with parameters `x`.
///
/// Fails if a log cannot be read.
pub fn series(model: &Model, x: &[f64], options: &Options, logs: &[LogSource]) -> Result<Vec<TorqueSeries>, Error> {
    let of_log = |log: &LogSource| {
        let mut series = TorqueSeries { name: log.name(), t: Vec::new(), measured: Vec::new(), predicted: Vec::new() };
        let records = SourceRecords::new(model.regressor, std::slice::from_ref(log), &options.preparation())?;
        records.each(&mut |states| {
            let before = series.measured.len();
            series.t.extend(&states.t);
            let measured = |i: usize| {
                model.scale(i % states.n) * (states.tau[i] + model.spring(states, i / states.n, i % states.n))
            };
            series.measured.extend((0..states.tau.len()).map(measured));
            series.predicted.resize(before + states.tau.len(), f64::NAN);
            model.residuals(states, x, |r, j, residual| {
                let entry = r * states.n + j;
                series.predicted[before + entry] = measured(entry) - model.scale(j) * residual;
            });
        })?;
        Ok(series)
    };
    logs.iter().map(of_log).collect()
}

/// Writes the series as CSV with the columns `log`, `t`, and `measured_..` and `predicted_..` for each coordinate. The
/// prediction of unused rows is empty.
pub fn series_to_csv(series: &[TorqueSeries], coordinates: &[String]) -> String {
    let mut text = "log,t".to_string();
    // Writing to a String never fails.
    coordinates.iter().for_each(|name| {
        let [measured, predicted] = ["measured", "predicted"].map(|what| format!("{what}_{name}"));
        write!(text, ",{},{}", csv_cell(&measured), csv_cell(&predicted)).unwrap_or_default();
    });
    text.push('\n');
    for one in series {
        let (name, n) = (csv_cell(&one.name), coordinates.len());
        let rows = one.t.iter().zip(one.measured.chunks(n).zip(one.predicted.chunks(n)));
        for (t, (measured, predicted)) in rows {
            let _ = write!(text, "{name},{t:.6}");
            for (measured, predicted) in measured.iter().zip(predicted) {
                let _ = write!(text, ",{measured:.6e},");
                if predicted.is_finite() {
                    let _ = write!(text, "{predicted:.6e}");
                }
            }
            text.push('\n');
        }
    }
    text
}

/// Writes the series as Parquet with the columns of [`series_to_csv`], in full precision. Predictions of unused rows are
/// absent.
///
/// Fails if two coordinates have equal names.
pub fn series_to_parquet(series: &[TorqueSeries], coordinates: &[String]) -> Result<Vec<u8>, Error> {
    let names = series.iter().flat_map(|one| std::iter::repeat_n(one.name.as_str(), one.t.len())).collect();
    let times = series.iter().flat_map(|one| one.t.iter().copied()).collect();
    let mut columns = vec![("log".to_string(), Cells::Texts(names)), ("t".to_string(), Cells::Numbers(times))];
    for (j, coordinate) in coordinates.iter().enumerate() {
        let of_joint = |rows: fn(&TorqueSeries) -> &[f64]| {
            Cells::Numbers(
                series.iter().flat_map(|one| rows(one).iter().skip(j).step_by(coordinates.len()).copied()).collect(),
            )
        };
        columns.push((format!("measured_{coordinate}"), of_joint(|one| &one.measured)));
        columns.push((format!("predicted_{coordinate}"), of_joint(|one| &one.predicted)));
    }
    logs::parquet_bytes(&columns)
}

#[cfg(test)]
mod tests {
    use logs::Table;

    use super::*;

    #[test]
    fn rows_have_their_fields() {
        let (measured, predicted) = (vec![1.0, 2.0, 3.0, 4.0], vec![1.5, f64::NAN, 2.5, 4.5]);
        let one = TorqueSeries { name: "a,\"b\"".into(), t: vec![0.0, 0.1], measured, predicted };
        let (series, coordinates) = ([one], ["q1".to_string(), "q2".to_string()]);
        let text = series_to_csv(&series, &coordinates);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "log,t,measured_q1,predicted_q1,measured_q2,predicted_q2");
        assert_eq!(lines[1], "\"a,\"\"b\"\"\",0.000000,1.000000e0,1.500000e0,2.000000e0,");
        assert_eq!(lines.len(), 3);
        let bytes = series_to_parquet(&series, &coordinates).unwrap();
        let table = Table::from_bytes("series.parquet", &bytes).unwrap();
        assert_eq!(table.header, lines[0].split(',').collect::<Vec<_>>());
        assert_eq!((&table.columns[1], &table.columns[4]), (&vec![0.0, 0.1], &vec![2.0, 4.0]));
        assert!(table.columns[5][0].is_nan() && table.columns[5][1] == 4.5);
    }
}
