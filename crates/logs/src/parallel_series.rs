//! Processes the series of a log in parallel threads.
//!
//! A series is one signal of one coordinate, with one number per sample.

use processor::{in_parallel, threads};

/// With fewer samples per series, a second thread saves no time.
const MIN_SAMPLES_FOR_SECOND_THREAD: usize = 1 << 15;

/// Applies `work` to each series; the results have the order of the series. `samples`: number of samples of each series.
pub(crate) fn in_parallel_series<I: Send, R: Send>(
    samples: usize,
    series: Vec<I>,
    work: impl Fn(I) -> R + Sync,
) -> Vec<R> {
    in_parallel(series, if samples < MIN_SAMPLES_FOR_SECOND_THREAD { 1 } else { threads() }, work)
}
