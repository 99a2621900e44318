//! The records of an identification: states held in memory, or made anew at every pass over a file.

use crate::identify::{Options, states, states_or_none};
use crate::log::Log;
use crate::log_stream::{LogSource, LogStream};
use crate::signal::States;
use crate::{Error, Regressor};

/// Records in a fixed order, to be gone through as often as an estimator needs.
pub trait Records {
    /// Hands over the states of one record after the other.
    ///
    /// Fails when they cannot be had (again): a file that has gone, a number out of range.
    fn each(&self, take: &mut dyn FnMut(&States)) -> Result<(), Error>;

    /// Contiguous parts that a record is kept in, for leaving parts out.
    fn parts(&self) -> usize {
        10
    }
}

impl Records for [States] {
    fn each(&self, take: &mut dyn FnMut(&States)) -> Result<(), Error> {
        self.iter().for_each(take);
        Ok(())
    }
}

/// The records of logs, of which some may be too long to be held.
pub struct SourceRecords<'a> {
    regressor: &'a dyn Regressor,
    sources: Vec<Source<'a>>,
}

enum Source<'a> {
    Held(Box<States>),
    Streamed { stream: &'a LogStream, options: Box<Options>, overlap: f64 },
}

impl<'a> SourceRecords<'a> {
    /// Fails when a log does not fit the robot, the transmission or the signal options.
    pub fn new(regressor: &'a dyn Regressor, logs: &'a [LogSource], options: &Options) -> Result<Self, Error> {
        let source = |log: &'a LogSource| match log {
            LogSource::Held(log) => states(regressor, log, options).map(Box::new).map(Source::Held),
            LogSource::Streamed(stream) => streamed(stream, options),
        };
        Ok(SourceRecords { regressor, sources: logs.iter().map(source).collect::<Result<_, _>>()? })
    }
}

/// A stream with the cut-off and the decimation of the whole log settled.
fn streamed<'a>(stream: &'a LogStream, options: &Options) -> Result<Source<'a>, Error> {
    let mut options = Box::new(options.clone());
    let mut period = options.signal.rate.map_or(stream.report().period, |rate| 1.0 / rate);
    if options.signal.order > 0 && options.signal.cutoff.is_none() {
        let mut content = None;
        stream.blocks(0.0, &mut |block| {
            if block.len() > 1 {
                let (found, step) = options.transmission.apply(&block)?.content(&options.signal)?;
                period = step;
                content = Some(match content.take() {
                    None => found,
                    Some(content) => found.faster(content, step),
                });
            }
            Ok(())
        })?;
        options.signal.cutoff = content.map(|c| c.cutoff);
    }
    let signal = &mut options.signal;
    let cutoff = if signal.order > 0 { signal.cutoff.unwrap_or(0.0) } else { 0.0 };
    signal.decimate = Some(signal.decimation(cutoff, period));
    let overlap = signal.memory(cutoff, period);
    Ok(Source::Streamed { stream, options, overlap })
}

impl Records for SourceRecords<'_> {
    fn each(&self, take: &mut dyn FnMut(&States)) -> Result<(), Error> {
        for source in &self.sources {
            match source {
                Source::Held(states) => take(states),
                Source::Streamed { stream, options, overlap } => {
                    let mut any = false;
                    stream.blocks(*overlap, &mut |block: Log| {
                        let states = states_or_none(self.regressor, &block, options)?;
                        if !states.is_empty() {
                            any = true;
                            take(&states);
                        }
                        Ok(())
                    })?;
                    if !any {
                        return Err(Error::new("no sample is left of the log between its ends and the window"));
                    }
                }
            }
        }
        Ok(())
    }
}
