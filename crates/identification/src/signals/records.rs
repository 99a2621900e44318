//! The records of an identification: segments of logs as lists of states (q, dq, ddq, tau). The states are kept in memory, or
//! are computed again in every pass if there are too many.
//!
//! A log that is read in several blocks (`logs::LogStream`) gives the same states as a log in memory. The states of the first
//! blocks are kept, up to `MAX_HELD_BYTES` bytes together with the logs; the other states are computed again in every pass. Eight
//! million rows of six joints fit into memory with default decimation. The second pass also keeps the thinned samples for the
//! test of faults, which then needs no separate pass.

use linear_model::regressor::Regressor;
use linear_model::states::States;
use logs::{Error, Log, LogSource, LogStream};
use numerics::interruption::Interruption;

use crate::signals::cutoff::MotionEnergy;
use crate::signals::preparation::{Preparation, of_log, states, states_or_none};
use crate::signals::seldom::sample_period;
use crate::signals::thinned::{SecondReader, ThinnedSamples};

/// Records in a fixed order. An estimator can iterate over the records several times.
pub trait Records {
    /// Calls `take` with the states of each record in order.
    ///
    /// Fails if the states cannot be read (again), because a file is missing or a number is out of range.
    fn each(&self, take: &mut dyn FnMut(&States)) -> Result<(), Error>;

    /// Every m-th sample of all records, with the smallest m that gives at most `most` samples.
    ///
    /// Fails if `each` fails.
    fn thinned(&self, most: usize) -> Result<ThinnedSamples, Error> {
        ThinnedSamples::of(|take| self.each(take), most)
    }

    /// Number of contiguous blocks of each record. Each block has its own triangles (R of QR), for cross-validation.
    fn parts(&self) -> usize {
        BLOCKS_PER_RECORD
    }
}

/// Default number of blocks of a record.
const BLOCKS_PER_RECORD: usize = 20;

impl Records for [States] {
    fn each(&self, take: &mut dyn FnMut(&States)) -> Result<(), Error> {
        self.iter().for_each(take);
        Ok(())
    }
}

/// The records of logs, some of which may be too long for memory.
pub struct SourceRecords<'a> {
    regressor: &'a dyn Regressor,
    sources: Vec<RecordSource<'a>>,
    beside: SecondReader,
}

struct Stream<'a> {
    log: &'a LogStream,
    /// Index of the log among all logs, from 0.
    number: usize,
    preparation: Box<Preparation>,
    /// Time by which a block overlaps its neighbours, s. Within this time, the effect of the start of the filter decays.
    overlap: f64,
}

enum RecordSource<'a> {
    Held(Vec<States>),
    /// `0`: states of the first blocks. `1`: number of these blocks. `2`: stream of the log, which computes the states of the
    /// other blocks again.
    Streamed(Vec<States>, usize, Stream<'a>),
}

impl<'a> SourceRecords<'a> {
    /// Makes the records of logs.
    ///
    /// Fails if a log does not fit the robot, the transmission or the signal preparation.
    pub fn new(regressor: &'a dyn Regressor, logs: &'a [LogSource], preparation: &Preparation) -> Result<Self, Error> {
        SourceRecords::new_within(regressor, logs, preparation, MAX_HELD_BYTES)
    }

    /// Whether some states are computed again in every pass, because they do not fit into memory.
    pub fn are_made_anew(&self) -> bool {
        self.sources.iter().any(|source| matches!(source, RecordSource::Streamed(..)))
    }

    /// Makes the records of logs with limited memory. `held`: largest memory for logs of several blocks and for the states of
    /// these logs, bytes.
    fn new_within(
        regressor: &'a dyn Regressor,
        logs: &'a [LogSource],
        preparation: &Preparation,
        held: usize,
    ) -> Result<Self, Error> {
        let preparation = match preparation.signal.cutoff {
            Some(_) => preparation.clone(),
            None => with_content(logs, preparation)?,
        };
        let raw: usize = logs.iter().map(LogSource::held_bytes).sum();
        let mut left = held.saturating_sub(raw);
        let source = |(number, log): (usize, &'a LogSource)| match log {
            LogSource::Held(log) => Ok(RecordSource::Held(of_log(number, states(regressor, log, &preparation)?))),
            LogSource::Streamed(stream) => {
                let stream = Stream::new(stream, number, &preparation);
                let (mut records, mut blocks, mut is_whole) = (Vec::new(), 0, left > 0);
                if left > 0 {
                    stream.each(regressor, 0, &mut |of_block| {
                        let bytes: usize = of_block.iter().map(States::bytes).sum();
                        is_whole = bytes <= left;
                        if is_whole {
                            left -= bytes;
                            blocks += 1;
                            // The copy uses memory that the signals of this block have freed. This avoids fragmentation of the
                            // memory.
                            records.extend(of_block.iter().cloned());
                        }
                        is_whole
                    })?;
                }
                Ok(if is_whole { RecordSource::Held(records) } else { RecordSource::Streamed(records, blocks, stream) })
            }
        };
        let sources = logs.iter().enumerate().map(source).collect::<Result<_, _>>()?;
        Ok(SourceRecords { regressor, sources, beside: SecondReader::default() })
    }
}

/// Largest memory for long logs and their states, bytes. Together with the working memory, 700 MiB are used.
const MAX_HELD_BYTES: usize = 1 << 29;

/// A copy of `preparation` with the frequency content of all logs together, from which the default cut-off follows.
fn with_content(logs: &[LogSource], preparation: &Preparation) -> Result<Preparation, Error> {
    let mut energy = MotionEnergy::default();
    logs.iter().try_for_each(|log| add_motion(log, preparation, &mut energy))?;
    Ok(preparation.clone().with_content(energy.content()))
}

/// Adds the motion of a log to `energy`, from which the default cut-off follows.
///
/// Fails if the log does not fit the transmission, or cannot be read again.
pub fn add_motion(log: &LogSource, preparation: &Preparation, energy: &mut MotionEnergy) -> Result<(), Error> {
    match log {
        LogSource::Held(log) => preparation.add_motion(log, energy)?,
        LogSource::Streamed(stream) => stream.each_of_positions(&mut |block| match block.len() {
            0 | 1 => Ok(()),
            _ => preparation.add_motion(block, energy),
        })?,
    }
    energy.end_record();
    Ok(())
}

impl<'a> Stream<'a> {
    /// Prepares a log for reading in blocks. The decimation is fixed here, so that all blocks have the same decimation.
    fn new(log: &'a LogStream, number: usize, preparation: &Preparation) -> Stream<'a> {
        let mut preparation = Box::new(preparation.clone());
        let signal = &mut preparation.signal;
        let period = sample_period(log.report(), signal);
        let cutoff = if signal.order > 0 { signal.cutoff.unwrap_or(0.0) } else { 0.0 };
        signal.decimate = Some(signal.decimation(cutoff, period));
        let overlap = signal.memory(cutoff, period);
        Stream { log, number, preparation, overlap }
    }

    /// Computes the states of each block from block number `first` on, and calls `take` with them until `take` returns false.
    fn each(
        &self,
        regressor: &dyn Regressor,
        first: usize,
        take: &mut dyn FnMut(Vec<States>) -> bool,
    ) -> Result<(), Error> {
        let mut any = first > 0;
        self.log.blocks(self.overlap, first, &mut |block: Log| {
            Interruption::check().map_err(|e| Error::new(e.message()))?;
            let records = of_log(self.number, states_or_none(regressor, block, &self.preparation)?);
            any |= !records.is_empty();
            Ok(take(records))
        })?;
        match any {
            true => Ok(()),
            false => Err(Error::new("no sample of the log remains between its ends and the window")),
        }
    }
}

impl SourceRecords<'_> {
    /// Calls `take` with the states of each record, which are in memory or recomputed.
    fn each_record(&self, take: &mut dyn FnMut(&States)) -> Result<(), Error> {
        for source in &self.sources {
            Interruption::check().map_err(|e| Error::new(e.message()))?;
            match source {
                RecordSource::Held(records) => records.iter().for_each(&mut *take),
                RecordSource::Streamed(records, blocks, stream) => {
                    records.iter().for_each(&mut *take);
                    stream.each(self.regressor, *blocks, &mut |records| {
                        records.iter().for_each(&mut *take);
                        true
                    })?;
                }
            }
        }
        Ok(())
    }
}

impl Records for SourceRecords<'_> {
    fn each(&self, take: &mut dyn FnMut(&States)) -> Result<(), Error> {
        if !self.are_made_anew() {
            return self.each_record(take);
        }
        self.beside.pass(|take| self.each_record(take), take)
    }

    fn thinned(&self, most: usize) -> Result<ThinnedSamples, Error> {
        self.beside.found(most).map_or_else(|| ThinnedSamples::of(|take| self.each(take), most), Ok)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::identify::Fit;
    use crate::estimate::options::Options;
    use crate::estimators::weighted::Weights;
    use crate::test_arm::Pendulum;
    use linear_model::friction::terms::FrictionTerm;
    use logs::{Clock, ColumnNames, LogReport};
    use random::Random;
    use std::path::{Path, PathBuf};

    /// Writes a log of a pendulum with `rows` rows; `row` formats t, q and tau.
    fn write(name: &str, rows: usize, mut row: impl FnMut(usize, [f64; 3]) -> String) -> PathBuf {
        let states = Pendulum::new().states(rows);
        let mut random = Random::new(5);
        let mut text = "t,q1,tau1\n".to_string();
        for r in 0..rows {
            text += &row(r, [states.t[r], states.q[r], states.tau[r] + 0.05 * random.normal()]);
        }
        let path = std::env::temp_dir().join(format!("rist-stream-{}-{name}.csv", std::process::id()));
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Opens a log. The log is read in blocks of 2000 rows if `held` is below 20,000 rows, else as a whole.
    fn open(path: &Path, held: usize) -> LogSource {
        let block = if held < 20_000 { 2000 } else { held };
        LogSource::open_within(path, &["q1".into()], &ColumnNames::default(), held, block).unwrap().0
    }

    fn fit(path: &Path, held: usize, options: &Options) -> Fit {
        let arm = Pendulum::new();
        let logs = [open(path, held)];
        assert_eq!(matches!(logs[0], LogSource::Streamed(_)), held < 20_000);
        let records = SourceRecords::new(&arm, &logs, &options.preparation()).unwrap();
        Fit::of_records(&arm, &records, vec![logs[0].name()], options).unwrap()
    }

    fn plain(_: usize, [t, q, tau]: [f64; 3]) -> String {
        format!("{t},{q},{tau}\n")
    }

    #[test]
    fn streamed_is_held() {
        let path = write("plain", 20_000, plain);
        let mut options = Options { friction: vec![FrictionTerm::Viscous], ..Options::default() };
        options.signal.decimate = Some(1);
        for cutoff in [Some(3.0), None] {
            options.signal.cutoff = cutoff;
            let held = fit(&path, 20_000, &options).estimate;
            let streamed = fit(&path, 1000, &options).estimate;
            assert_eq!(streamed.rows, held.rows);
            // The period of a block differs from the period of the log in the last digits only.
            let (streamed_hz, held_hz) = (streamed.cutoff.unwrap(), held.cutoff.unwrap());
            assert!((streamed_hz / held_hz - 1.0).abs() < 1e-12, "{streamed_hz} {held_hz}");
            for (a, b) in streamed.parameters.iter().zip(&held.parameters) {
                // The effect of the start of the filter has decayed to 1e-12.
                assert!((a.value.unwrap() - b.value.unwrap()).abs() < 1e-9 * b.value.unwrap().abs(), "{a:?} {b:?}");
                assert!((a.white_sigma.unwrap() / b.white_sigma.unwrap() - 1.0).abs() < 1e-9);
                // A streamed log has about fifty clusters of rows instead of twenty, because each block of the stream is
                // divided. So the sigma of a streamed log differs.
                assert!((0.6..1.6).contains(&(a.sigma.unwrap() / b.sigma.unwrap())), "{a:?} {b:?}");
            }
            assert!((streamed.total.unwrap() / held.total.unwrap() - 1.0).abs() < 1e-9);
        }
        options.weights = Weights::Huber;
        let (a, b) = (fit(&path, 1000, &options).estimate, fit(&path, 20_000, &options).estimate);
        for (a, b) in a.parameters.iter().zip(&b.parameters) {
            // The iterations end when no parameter changes by more than a thousandth of a sigma.
            assert!((a.value.unwrap() - b.value.unwrap()).abs() < 2e-3 * b.sigma.unwrap());
        }
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn blocks_are_the_same_wherever_they_come_from() {
        let path = write("blocks", 20_000, |r, row| if r % 900 == 5 { "nan,,1\n".into() } else { plain(r, row) });
        let (arm, options) = (Pendulum::new(), Options { friction: vec![FrictionTerm::Viscous], ..Options::default() });
        let found = |held_rows: usize, held_states: usize| {
            let names = ColumnNames::default();
            let logs = [LogSource::open_within(&path, &["q1".into()], &names, held_rows, 2000).unwrap().0];
            assert!(matches!(logs[0], LogSource::Streamed(_)));
            let report = logs[0].report().clone();
            let held = logs[0].held_bytes().saturating_add(held_states);
            let records = SourceRecords::new_within(&arm, &logs, &options.preparation(), held).unwrap();
            match &records.sources[0] {
                RecordSource::Held(_) => assert_eq!(held_states, usize::MAX),
                RecordSource::Streamed(_, blocks, _) => {
                    assert_eq!((*blocks > 0, *blocks < 10), (held_states > 0, true))
                }
            }
            (report, Fit::of_records(&arm, &records, vec![], &options).unwrap().estimate)
        };
        let (report, estimate) = found(20_000, 0);
        assert_eq!((report.rows, report.left_out.not_finite), (20_000, 23));
        // 100 kB is enough for the states of some of the ten blocks.
        for (rows, states) in [(20_000, usize::MAX), (1000, 0), (1000, usize::MAX), (1000, 100_000), (20_000, 100_000)]
        {
            let (other, found) = found(rows, states);
            assert_eq!(other, report);
            assert_eq!(found.cutoff.map(f64::to_bits), estimate.cutoff.map(f64::to_bits));
            assert_eq!(found.total.map(f64::to_bits), estimate.total.map(f64::to_bits));
            for (a, b) in found.parameters.iter().zip(&estimate.parameters) {
                assert_eq!((a.value, a.sigma), (b.value, b.sigma), "{rows} {states}");
            }
        }
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn holes_repeats_and_rests_move_no_cutoff() {
        let mut last = String::new();
        let mut repeats = |r: usize, [t, q, tau]: [f64; 3]| {
            if r % 7 != 3 {
                last = format!("{q},{tau}");
            }
            format!("{t},{last}\n")
        };
        let whole = write("whole", 3000, plain);
        let hole = write("hole", 3000, |r, row| if (1200..1240).contains(&r) { String::new() } else { plain(r, row) });
        let repeated = write("repeated", 3000, &mut repeats);
        let mut random = Random::new(9);
        let noise: Vec<f64> = (0..3000).map(|_| 1e-3 * random.normal()).collect();
        let rest = write("rest", 3000, |r, [t, _, tau]| format!("{t},{},{tau}\n", noise[r]));
        let options = Options { friction: vec![FrictionTerm::Viscous], ..Options::default() };
        let cutoff = |paths: &[&Path]| {
            let (arm, logs) = (Pendulum::new(), paths.iter().map(|p| open(p, 20_000)).collect::<Vec<_>>());
            let records = SourceRecords::new(&arm, &logs, &options.preparation()).unwrap();
            let mut found = Vec::new();
            records.each(&mut |states| found.push(states.cutoff)).unwrap();
            assert!(found.iter().all(|f| *f == found[0]), "{found:?}");
            found[0]
        };
        let expected = cutoff(&[&whole]);
        // The default cut-off is twenty times the frequency of a bin. The bins of the whole log (30 s) are 1/30 Hz wide. The
        // bins of the segments before and after the gap are 1/12 and 1/18 Hz wide.
        for logs in [vec![&*hole], vec![&*repeated], vec![&*whole, &*rest], vec![&*rest, &*hole]] {
            assert!((cutoff(&logs) / expected - 1.0).abs() < 0.08, "{logs:?}: {} for {expected}", cutoff(&logs));
        }
        [whole, hole, repeated, rest].iter().for_each(|path| std::fs::remove_file(path).unwrap());
    }

    #[test]
    fn the_account_is_that_of_the_whole() {
        let path = write("broken", 20_000, |r, [t, q, tau]| match r {
            1999 | 2000 | 7777 => "nan,,1\n".into(),
            4000 => format!("{},{q},{tau}\n", t - 0.05),
            5999 => format!("{t},{q}\n"),
            8000..8100 => String::new(),
            12_000..14_500 => format!("{t},0.5,0.5\n"),
            _ => plain(r, [t, q, tau]),
        });
        let (held, streamed) = (open(&path, 20_000), open(&path, 1000));
        let (held, streamed) = (held.report(), streamed.report());
        // The log check searches intervals at rest in steps of 0.05 s, from the start of each block.
        let close = |a: f64, b: f64| (a - b).abs() < 0.1;
        let lengths = |r: &LogReport| [r.rest.total, r.rest.after, r.rest.before, r.clock.duration];
        let (a, b) = (lengths(streamed), lengths(held));
        assert!(a.iter().zip(b).all(|(a, b)| close(*a, b)), "{streamed}{held}");
        // A row that repeats the last row of the previous block is not detected: at most one in each of the ten blocks.
        assert!((0..10).contains(&(held.repeated - streamed.repeated)));
        let clock = Clock { period: held.clock.period, duration: held.clock.duration, ..streamed.clock.clone() };
        let (rest, repeated) = (held.rest, held.repeated);
        // The clock step of a segment differs from the clock step of the whole log in the last digits only.
        assert!((streamed.refresh.motion / held.refresh.motion - 1.0).abs() < 1e-9);
        let counts = LogReport { clock, rest, repeated, refresh: held.refresh, ..streamed.clone() };
        assert_eq!(counts, *held);
        assert_eq!((streamed.clock.gaps, streamed.left_out.clock_backwards, streamed.left_out.not_finite), (1, 1, 4));
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn a_file_that_changes_is_refused() {
        let path = write("changing", 20_000, plain);
        let logs = [open(&path, 1000)];
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() / 2]).unwrap();
        let (arm, options) = (Pendulum::new(), Options::default());
        let failed = SourceRecords::new(&arm, &logs, &options.preparation()).err().unwrap();
        assert!(failed.to_string().contains("changes while it is read"), "{failed}");
        std::fs::remove_file(path).unwrap();
    }
}
