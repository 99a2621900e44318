//! Series shared among the processor's threads. Which thread takes one changes nothing.

/// With fewer samples a second thread does not pay.
const MIN_SAMPLES_FOR_SECOND_THREAD: usize = 1 << 15;

/// The results of `work` on the series, in their order. `samples`: the number of samples of each series.
pub(crate) fn abreast<I: Send, R: Send>(samples: usize, series: Vec<I>, work: impl Fn(I) -> R + Sync) -> Vec<R> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(series.len());
    if threads < 2 || samples < MIN_SAMPLES_FOR_SECOND_THREAD {
        return series.into_iter().map(work).collect();
    }
    let work = &work;
    std::thread::scope(|scope| {
        let (count, mut rest) = (series.len(), series.into_iter());
        let share = |t: usize| (t + 1) * count / threads - t * count / threads;
        let workers: Vec<_> = (0..threads)
            .map(|t| {
                let some: Vec<I> = rest.by_ref().take(share(t)).collect();
                scope.spawn(move || some.into_iter().map(work).collect::<Vec<R>>())
            })
            .collect();
        // `work` does not fail. If it panics nevertheless, the panic goes on in the caller.
        let done = |worker: std::thread::ScopedJoinHandle<Vec<R>>| {
            worker.join().unwrap_or_else(|cause| std::panic::resume_unwind(cause))
        };
        workers.into_iter().flat_map(done).collect()
    })
}
