//! Least squares on filtered records of a plan, as a reference for RIST-MH (the estimator in the frequency domain).
//!
//! The estimator of `rist identify` accepts any motion and may change. This one is fixed, so that benchmark results of different
//! years can be compared. The model is tau = D X plus friction. D: regressor, X: parameters. Friction has four columns per joint:
//! viscous and Coulomb friction, separately for each direction (equation (5) of [Vandanjon, Gautier, Desbats 1995]).

use experiments::plan::measured_motion::MeasuredMotion;
use identification::signals::butterworth::Butterworth;
use identification::spectrum::experiment::SpectralExperiment;
use identification::spectrum::paper::paper_rows;
use linear_model::regressor::Regressor;
use numerics::least_squares::solve;
use numerics::triangle::TriangleBuilder;

/// The usual estimator for the records of a plan: a zero-phase Butterworth filter of order 4 at 40 Hz on q; central differences;
/// a second filter at 20 Hz on columns and torque, which are then decimated by 20; the ends are removed. Friction has four
/// columns per joint (viscous and Coulomb friction in each direction). For slow sweeps, the mean of the rows is removed.
pub fn filtered_least_squares(
    experiments: &[SpectralExperiment],
    regressor: &dyn Regressor,
    gain: &[f64],
    noise: &[f64],
) -> Vec<f64> {
    const DECIMATION: usize = 20;
    const BORDER: usize = 60;
    let (n, p) = (gain.len(), regressor.parameters().len());
    let h = experiments.first().map_or(0.0, |e| e.trajectory.sample_time);
    let rate = 1.0 / h;
    let filters =
        (Butterworth::low_pass(4, 40.0, rate), Butterworth::low_pass(4, 0.4 * rate / DECIMATION as f64, rate));
    let (Some(first), Some(second)) = filters else { return vec![] };
    let mut rows = TriangleBuilder::new(p + 4 * n);
    for e in experiments {
        let mut row = vec![0.0; p + 4 * n];
        if e.period().is_none() {
            let sweep = paper_rows(e, regressor, gain, noise);
            for (i, d) in sweep.rows.iter().enumerate() {
                let w = 1.0 / sweep.deviation[i];
                row[..p].iter_mut().zip(d).for_each(|(x, d)| *x = w * d);
                rows.push(&row, w * sweep.right[i]);
            }
            continue;
        }
        let smooth: Vec<Vec<f64>> = first.zero_phase(e.q.clone());
        let motion = MeasuredMotion::by_differences(&smooth, h);
        let columns = motion.regressor_columns(regressor);
        let torque = e.torque(gain);
        for j in e.trajectory.moving() {
            let mut friction = vec![Vec::new(); 4];
            let mut four = [0.0; 4];
            for &v in &motion.dq[j] {
                friction_row(v, &mut four);
                friction.iter_mut().zip(four).for_each(|(f, x)| f.push(x));
            }
            let filter = |x: &Vec<f64>| second.zero_phase(vec![x.clone()]).remove(0);
            let (d, f): (Vec<_>, Vec<_>) =
                (columns[j].iter().map(filter).collect(), friction.iter().map(filter).collect());
            let y = second.zero_phase(vec![torque[j].clone()]).remove(0);
            let w = 1.0 / noise[j];
            row.fill(0.0);
            for i in (BORDER..motion.len().saturating_sub(BORDER)).step_by(DECIMATION) {
                (0..p).for_each(|c| row[c] = w * d[c][i]);
                (0..4).for_each(|c| row[p + 4 * j + c] = w * f[c][i]);
                rows.push(&row, w * y[i]);
            }
        }
    }
    solve(&rows.finish()).x[..p].to_vec()
}

/// The four friction columns at velocity `v`: viscous and Coulomb friction for positive velocity, then for negative velocity.
pub fn friction_row(v: f64, out: &mut [f64]) {
    let positive = f64::from(v > 0.0);
    out.copy_from_slice(&[positive * v, positive, (1.0 - positive) * v, 1.0 - positive]);
}
