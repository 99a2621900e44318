//! Measures the processor time, s, that the library needs for the base regressor at many states of a Panda.
//! observation_matrix.py compares its own time with this. Linux only: wall-clock time would depend on other processes.

/// Processor time of this thread so far, s.
fn on_processor() -> Result<f64, rist::Error> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").map_err(rist::Error::new)?;
    let nanoseconds = text.split(' ').next().unwrap_or_default().parse::<f64>().map_err(rist::Error::new)?;
    Ok(1e-9 * nanoseconds)
}

fn main() -> Result<(), rist::Error> {
    let argument = |k: usize| std::env::args().nth(k).unwrap_or_default();
    let model = rist::Model::read(argument(1))?;
    let count: usize = argument(2).parse().map_err(rist::Error::new)?;
    let (n, p) = (model.regressor().coordinates().len(), model.regressor().parameters().len());
    let states: Vec<f64> = (0..count * 3 * n).map(|k| (0.7 * k as f64).sin()).collect();
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = on_processor()?;
        // Allocated again in each repetition, as NumPy does, because the time for memory pages counts.
        let mut y = vec![0.0; count * n * p];
        model.regressor().fill_many(&states, &mut y);
        best = best.min(on_processor()? - start);
        assert!(y[y.len() - 1].is_finite());
    }
    println!("{best}");
    Ok(())
}
