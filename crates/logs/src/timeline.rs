//! The time of a log, which continues from one block of a file to the next.
//!
//! A file may contain several episodes, each with its own clock. An episode begins if the episode number changes, or if the clock
//! jumps back and continues from there. The time of the log always increases: a pause follows each episode. The pause counts as a
//! gap, so each episode is filtered separately.

use crate::cleaning::account::LeftOutRows;
use crate::cleaning::clock::{GAP_PERIODS, MIN_ROWS};
use crate::columns::mapping::Columns;
use crate::table::Table;

/// Shortest pause between two episodes, s.
const MIN_PAUSE_S: f64 = 1.0;

/// The state of the clock after the rows that were read.
#[derive(Clone, Debug)]
pub(crate) struct Timeline {
    /// Time of the last sample, in the time of the log, s.
    after: f64,
    /// Difference between the time of the log and the clock of the file, s.
    offset: f64,
    /// For a clock in two columns: the first whole second, which is subtracted, s.
    origin: Option<f64>,
    /// Clock of the file in the previous row, s.
    before: f64,
    /// Time of the first sample of the episode, in the time of the log, s.
    start: f64,
    /// Number of samples of the episode so far.
    samples: usize,
    /// Clock of the previous row (s) if it was before the last sample; otherwise `None`.
    behind: Option<f64>,
    /// The current episode number; `None` if there is none.
    episode: Option<f64>,
}

impl Default for Timeline {
    fn default() -> Timeline {
        Timeline {
            after: f64::NEG_INFINITY,
            offset: 0.0,
            origin: None,
            before: f64::NEG_INFINITY,
            start: 0.0,
            samples: 0,
            behind: None,
            episode: None,
        }
    }
}

impl Timeline {
    /// The time of a row in the time of the log, s. `None` if the row is not usable; it is then counted in `left`.
    pub(crate) fn time(&mut self, table: &Table, columns: &Columns, row: usize, left: &mut LeftOutRows) -> Option<f64> {
        let clock = self.clock(table, columns, row);
        if !clock.is_finite() {
            left.not_finite += 1;
            left.first_not_finite.get_or_insert(table.line(row));
            return None;
        }
        let episode = columns.episode.as_ref().map(|source| table.columns[source.column][row]);
        let is_next = self.samples > 0 && self.episode.zip(episode).is_some_and(|(before, now)| now != before);
        let is_back = clock < self.before;
        self.before = clock;
        self.episode = episode.or(self.episode);
        if is_next {
            left.episodes_by_column += 1;
            return Some(self.begin(clock));
        }
        let now = clock + self.offset;
        if now > self.after {
            self.start = if self.samples == 0 { now } else { self.start };
            (self.after, self.behind) = (now, None);
            self.samples += 1;
            return Some(now);
        }
        if now == self.after {
            left.clock_repeated += 1;
            return None;
        }
        // If a single row is before the last sample, its time is wrong. If a second row continues from there, a new episode
        // begins.
        if self.behind.is_some_and(|behind| clock > behind) && self.is_far_behind(now) {
            left.episodes_by_clock += 1;
            return Some(self.begin(clock));
        }
        left.clock_steps_back += usize::from(is_back);
        left.clock_backwards += 1;
        left.first_backwards.get_or_insert(table.line(row));
        self.behind = Some(clock);
        None
    }

    /// The clock of the file at a row, s.
    fn clock(&mut self, table: &Table, columns: &Columns, row: usize) -> f64 {
        if let Some(rate) = columns.rate {
            return (table.skipped + row) as f64 / rate;
        }
        let clock = columns.time.si(table.columns[columns.time.column][row]);
        let Some(fraction) = &columns.time_fraction else { return clock };
        // The first whole second is subtracted, because nanoseconds since 1970 have more digits than an f64.
        let origin = if clock.is_finite() { *self.origin.get_or_insert(clock) } else { clock };
        (clock - origin) + fraction.si(table.columns[fraction.column][row])
    }

    /// The mean time step of the episode, s.
    fn step(&self) -> f64 {
        (self.after - self.start) / self.samples.saturating_sub(1).max(1) as f64
    }

    fn is_far_behind(&self, now: f64) -> bool {
        self.samples >= MIN_ROWS && self.after - now > GAP_PERIODS * self.step()
    }

    /// Begins a new episode with this row. Returns its time in the time of the log, s.
    fn begin(&mut self, clock: f64) -> f64 {
        let earliest = self.after + MIN_PAUSE_S.max(2.0 * GAP_PERIODS * self.step());
        self.offset = self.offset.max(earliest - clock);
        let now = clock + self.offset;
        (self.after, self.start, self.samples, self.behind) = (now, now, 1, None);
        now
    }
}

#[cfg(test)]
mod tests {
    use crate::columns::names::ColumnNames;
    use crate::{Error, Log, LogSource, Table};
    use std::fmt::Write as _;

    /// Without a clock, row r is at the time r / rate, also in later blocks. Rows that are not usable are counted too.
    #[test]
    fn a_rate_is_a_clock() {
        let rows = |with_clock: bool| -> String {
            let clock = |r: usize| if with_clock { format!("{},", r as f64 / 250.0) } else { String::new() };
            let q = |r: usize| if r == 70 { "nan".into() } else { format!("{:.6}", (0.05 * r as f64).sin()) };
            let head = if with_clock { "t,q1,tau1\n" } else { "q1,tau1\n" };
            head.to_string() + &(0..200).map(|r| format!("{}{},{r}\n", clock(r), q(r))).collect::<String>()
        };
        let names = ColumnNames { rate: Some(250.0), ..ColumnNames::default() };
        let expected = read(&rows(true), &ColumnNames::default()).unwrap();
        let found = read(&rows(false), &names).unwrap();
        assert_eq!((&found.t, &found.q), (&expected.t, &expected.q));
        assert_eq!(found.t.len(), 199);
        let path = std::env::temp_dir().join(format!("rist-rate-{}.csv", std::process::id()));
        std::fs::write(&path, rows(false)).unwrap();
        for held in [0, 1_000_000] {
            let (opened, columns) = LogSource::open_within(&path, &["q1".into()], &names, held, 64).unwrap();
            assert_eq!(opened.report().clock.duration, expected.t[198] - expected.t[0]);
            assert!(columns.to_string().starts_with("time: 250 rows per second, as given\n"), "{columns}");
        }
        std::fs::remove_file(&path).unwrap();
        let message = |names: &ColumnNames| read(&rows(false), names).err().unwrap().to_string();
        assert!(message(&ColumnNames::default()).contains("[rate=HZ]"), "{}", message(&ColumnNames::default()));
        let clock = Some("q1".to_string());
        assert!(message(&ColumnNames { time: clock, ..names.clone() }).contains("both given"));
        assert!(message(&ColumnNames { rate: Some(f64::NAN), ..names }).contains("a positive number of Hz"));
    }

    fn read(text: &str, names: &ColumnNames) -> Result<Log, Error> {
        let table = Table::from_bytes("log.csv", text.as_bytes())?;
        match LogSource::from_table(table, &["q1".into()], names)?.0 {
            LogSource::Held(log) => Ok(log),
            LogSource::Streamed(_) => Err(Error::new("it is long")),
        }
    }

    /// Three runs of 100 rows at 100 Hz. The clock of each run starts at its entry of `starts`.
    fn runs(starts: [f64; 3], header: &str) -> String {
        let mut text = format!("{header}\n");
        for (run, start) in starts.into_iter().enumerate() {
            for k in 0..100 {
                let t = start + 0.01 * f64::from(k);
                let _ = writeln!(text, "{t:.2},{},{},{run}", (3.0 * t).sin(), t.cos());
            }
        }
        text
    }

    #[test]
    fn a_clock_that_begins_anew_makes_episodes() {
        let log = read(&runs([0.0, 0.0, 0.2], "t,q1,tau1,run"), &ColumnNames::default()).unwrap();
        // The first row of each later episode is lost, because a single row with an earlier time does not start an episode.
        assert_eq!((log.len(), log.report.left_out.episodes_by_clock, log.report.clock.gaps), (298, 2, 2));
        assert_eq!(log.segments().iter().map(Log::len).collect::<Vec<_>>(), [100, 99, 99]);
        assert!(log.report.to_string().contains("3 episodes: the clock begins anew"), "{}", log.report);
        // The values of the signals do not depend on the restarts of the clock.
        assert_eq!(log.q[0][100], (0.03f64).sin());
    }

    #[test]
    fn a_column_that_numbers_episodes_splits_them() {
        for starts in [[0.0; 3], [0.0, 1.0, 2.0]] {
            for (header, name) in [("t,q1,tau1,episode_index", None), ("t,q1,tau1,run", Some("run"))] {
                let names = ColumnNames { episode: name.map(str::to_string), ..ColumnNames::default() };
                let log = read(&runs(starts, header), &names).unwrap();
                let report = &log.report;
                assert_eq!((log.len(), report.left_out.episodes_by_column, report.clock.gaps), (300, 2, 2), "{header}");
            }
        }
        let names = ColumnNames { episode: Some("rnu".into()), ..ColumnNames::default() };
        let message = read(&runs([0.0; 3], "t,q1,tau1,run"), &names).unwrap_err().to_string();
        assert!(message.contains("no column `rnu` (did you mean `run`?)"), "{message}");
    }

    #[test]
    fn what_goes_back_and_forth_is_no_episode() {
        let of = |clock: fn(i32) -> f64| {
            let rows = (0..400).map(clock).map(|t| format!("{t:.2},{},{}\n", t.sin(), t.cos()));
            read(&format!("t,q1,tau1\n{}", rows.collect::<String>()), &ColumnNames::default())
        };
        let message = of(|k| 0.01 * f64::from(k) + if k % 2 == 1 { 0.0 } else { 3.0 }).unwrap_err().to_string();
        assert!(message.contains("back and forth"), "{message}");
        let log = of(|k| if k == 200 { 0.0 } else { 0.01 * f64::from(k) }).unwrap();
        let out = &log.report.left_out;
        assert_eq!((log.len(), out.episodes_by_clock, out.clock_backwards), (399, 0, 1));
    }

    #[test]
    fn episodes_do_not_hang_on_the_parts() {
        let text = runs([0.0; 3], "t,q1,tau1,run");
        let whole = read(&text, &ColumnNames::default()).unwrap();
        let path = std::env::temp_dir().join(format!("rist-episodes-{}.csv", std::process::id()));
        std::fs::write(&path, &text).unwrap();
        for held in [usize::MAX, 10] {
            let opened = LogSource::open_within(&path, &["q1".into()], &ColumnNames::default(), held, 64).unwrap().0;
            let LogSource::Streamed(stream) = opened else { panic!("it is of one block") };
            let mut times = Vec::new();
            stream
                .each(&mut |log| {
                    times.extend_from_slice(&log.t);
                    Ok(())
                })
                .unwrap();
            assert_eq!(times, whole.t, "{held}");
            assert_eq!(stream.report().left_out.episodes_by_clock, 2);
        }
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn seconds_and_nanoseconds_are_one_clock() {
        let mut text = "time_stamp_sec,time_stamp_nano_sec,q1,tau1\n".to_string();
        for k in 0..400u32 {
            let _ =
                writeln!(text, "{},{},{},{}", 1_700_000_000 + k / 100, (k % 100) * 10_000_000, k.pow(2) % 7, k % 11);
        }
        let log = read(&text, &ColumnNames::default()).unwrap();
        assert_eq!((log.len(), log.t[0]), (400, 0.0));
        assert!(log.t.iter().enumerate().all(|(k, t)| (t - 0.01 * k as f64).abs() < 1e-12));
    }
}
