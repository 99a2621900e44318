//! Converts records to logs and back, so that a simulation writes the same files as a real machine.
//!
//! The CSV has the columns `t, q_<coordinate>.., i_<coordinate>..` (s, rad, A). If the values are torques (N m), the last
//! columns are `tau_<coordinate>..` instead.

use std::fmt::Write;

use logs::{Effort, Error, Log, LogReport};

use crate::motion::record::Record;
use crate::motion::trajectory_file::csv_header;

impl Record {
    /// The record as the text of a CSV log. `effort`: whether the record has currents or torques.
    pub fn to_csv(&self, coordinates: &[String], effort: Effort) -> String {
        let letter = match effort {
            Effort::Current | Effort::PositionError => "i",
            Effort::Torque => "tau",
        };
        let mut text = csv_header(&["q", letter], coordinates);
        for i in 0..self.q.first().map_or(0, Vec::len) {
            // Writing to a String cannot fail. Seven decimals suffice: 1e-7 rad and A are below the resolution of every sensor.
            let _ = write!(text, "{:.6}", i as f64 * self.sample_time);
            for x in self.q.iter().chain(&self.current) {
                let _ = write!(text, ",{:.7}", x[i]);
            }
            text.push('\n');
        }
        text
    }

    /// The record as a log of torques that starts at 0 s. `gain`: torque per unit of the recorded current, N m/A, one per
    /// coordinate.
    pub fn to_log(&self, name: &str, coordinates: &[String], gain: &[f64]) -> Log {
        let rows = self.q.first().map_or(0, Vec::len);
        let period = self.sample_time;
        let torque = |(current, gain): (&Vec<f64>, &f64)| current.iter().map(|c| c * gain).collect();
        Log {
            name: name.into(),
            coordinates: coordinates.to_vec(),
            t: (0..rows).map(|i| i as f64 * period).collect(),
            q: self.q.clone(),
            dq: None,
            ddq: None,
            effort: self.current.iter().zip(gain).map(torque).collect(),
            effort_is: Effort::Torque,
            rows: (1..=rows).collect(),
            window: None,
            report: LogReport::uniform(rows, period),
        }
    }

    /// The record of a log that starts with the motion. Fails if the time steps of the log are not uniform.
    pub fn from_log(log: &Log) -> Result<Record, Error> {
        if !log.report.clock.uniform {
            let message = format!(
                "the steps of the clock are uneven (median {:.6} s, longest {:.6} s); whole periods need even ones: \
                 resample the log",
                log.report.clock.period, log.report.clock.longest_step
            );
            return Err(Error::at(&log.name, 0, message));
        }
        let steps = log.t.len().saturating_sub(1).max(1) as f64;
        let sample_time = (log.t.last().copied().unwrap_or(0.0) - log.t.first().copied().unwrap_or(0.0)) / steps;
        Ok(Record { sample_time, q: log.q.clone(), current: log.effort.clone() })
    }
}
