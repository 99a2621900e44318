//! Seconds that the library takes for the base regressor of many Panda states: the bound of observation_matrix.py.

use std::time::Instant;

fn main() -> Result<(), rist::Error> {
    let argument = |k: usize| std::env::args().nth(k).unwrap_or_default();
    let model = rist::Model::read(argument(1))?;
    let count: usize = argument(2).parse().map_err(rist::Error::new)?;
    let (n, p) = (model.regressor().coordinates().len(), model.regressor().parameters().len());
    let states: Vec<f64> = (0..count * 3 * n).map(|k| (0.7 * k as f64).sin()).collect();
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        // Made anew each time, as by NumPy: the pages are part of the price.
        let mut y = vec![0.0; count * n * p];
        model.regressor().fill_many(&states, &mut y);
        best = best.min(start.elapsed().as_secs_f64());
        assert!(y[y.len() - 1].is_finite());
    }
    println!("{best}");
    Ok(())
}
