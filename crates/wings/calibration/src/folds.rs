//! Computes the error of a fit on postures that were left out of it (folds, left out in turn), and chooses the prior with the
//! smallest such error.
//!
//! The postures are divided into folds. Each fold is left out of the fit once and predicted. A prior is a standard deviation
//! that the errors of the geometry are assumed to have; without one, they are free.

use claims::Figure;

use crate::base_geometry::GeometricBase;
use crate::fit::{Fit, Fitter, Noise, Prior};
use crate::measurement::{Problem, ResidualKind, Unknowns};

/// Number of folds that are left out in turn.
pub(crate) const FOLDS: usize = 5;
/// Standard deviations of the errors of the geometry that are tried, m and rad.
const DEVIATIONS: [f64; 9] = [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2];
/// A left-out residual counts at most as this multiple of the noise, so that an outlier does not choose the prior.
const MOST: f64 = 5.0;

/// Root mean square errors of predictions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PredictionError {
    /// Distance of a point (or error of a distance), m. `None` if no length was measured.
    pub length: Option<f64>,
    /// Angle of an orientation, rad. `None` if no orientation was measured.
    pub angle: Option<f64>,
}

impl PredictionError {
    /// One number for the comparison with another fit: the geometric mean of two ratios, of the length errors and of the angle
    /// errors of both fits.
    pub(crate) fn relative(&self, to: &PredictionError) -> f64 {
        let ratio = |a: Option<f64>, b: Option<f64>| Some(a? / b?.max(f64::MIN_POSITIVE));
        let ratios = [ratio(self.length, to.length), ratio(self.angle, to.angle)];
        let ratios: Vec<f64> = ratios.into_iter().flatten().collect();
        ratios.iter().product::<f64>().powf(1.0 / ratios.len().max(1) as f64)
    }

    /// This error and another error as two numbers with a unit. Of lengths and angles, the kind in which the two errors differ
    /// more is taken.
    pub(crate) fn compared(&self, other: &PredictionError) -> (Figure, Figure) {
        let kinds = [(self.length, other.length, "mm"), (self.angle, other.angle, "mrad")];
        let of = |(a, b, unit): &(Option<f64>, Option<f64>, &'static str)| {
            let (a, b) = ((*a)?, (*b)?);
            Some(((b / a.max(f64::MIN_POSITIVE)).ln().abs(), Figure::new(1e3 * a, *unit), Figure::new(1e3 * b, *unit)))
        };
        let most = kinds.iter().filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0));
        most.map_or_else(|| (Figure::new(f64::NAN, "mm"), Figure::new(f64::NAN, "mm")), |(_, a, b)| (a, b))
    }
}

/// Sums of squared errors.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ErrorSums {
    length: (f64, f64),
    angle: (f64, f64),
    /// Sum of squared residuals, each divided by the noise and limited to [`MOST`] squared.
    robust: f64,
}

impl ErrorSums {
    /// Adds the errors of the postures `of`.
    pub(crate) fn add(&mut self, problem: &Problem, at: &Unknowns, of: &[usize], noise: &Noise) {
        for (x, kind, _) in &problem.residuals_of(at, of) {
            let (sums, noise) = match kind {
                ResidualKind::Length => (&mut self.length, noise.length),
                ResidualKind::Angle => (&mut self.angle, noise.angle),
            };
            sums.0 += x * x;
            sums.1 += 1.0;
            self.robust += (x / noise).powi(2).min(MOST * MOST);
        }
    }

    /// Root mean square errors. `per_length`: number of components of a point.
    pub(crate) fn error(&self, per_length: f64) -> PredictionError {
        let rms = |(squares, count): (f64, f64), each: f64| (count > 0.0).then(|| (each * squares / count).sqrt());
        PredictionError { length: rms(self.length, per_length), angle: rms(self.angle, 3.0) }
    }
}

impl ErrorSums {
    /// Squared error of lengths divided by the mean square of `to.length`, plus squared error of angles divided by the mean
    /// square of `to.angle`.
    fn normalised(&self, to: &ErrorSums) -> f64 {
        let ratio = |own: (f64, f64), to: (f64, f64)| if to.0 > 0.0 { own.0 * to.1 / to.0 } else { 0.0 };
        ratio(self.length, to.length) + ratio(self.angle, to.angle)
    }
}

/// Compares the squared errors of two fits posture by posture (paired test), over the `used` postures. Returns the mean
/// difference of the squared errors, divided by the standard deviation of this mean. It is positive if the errors `own` are
/// larger.
pub(crate) fn paired(own: &[ErrorSums], other: &[ErrorSums], used: &[bool]) -> f64 {
    let rows: Vec<usize> = (0..used.len()).filter(|r| used[*r]).collect();
    let mut scale = ErrorSums::default();
    for one in rows.iter().map(|r| &other[*r]) {
        scale.length = (scale.length.0 + one.length.0, scale.length.1 + one.length.1);
        scale.angle = (scale.angle.0 + one.angle.0, scale.angle.1 + one.angle.1);
    }
    let differences: Vec<f64> =
        rows.iter().map(|r| own[*r].normalised(&scale) - other[*r].normalised(&scale)).collect();
    let count = differences.len().max(1) as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let variance = differences.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    if variance > 0.0 { mean / (variance / count).sqrt() } else { 0.0 }
}

/// Number of measured components of a point: 3, fewer if some are not measured, 1 for a distance.
pub(crate) fn components(problem: &Problem) -> f64 {
    if problem.kind.is_distance() {
        return 1.0;
    }
    let points: Vec<_> = problem.postures.iter().flat_map(|p| &p.points).collect();
    let measured = points.iter().flat_map(|p| p.iter()).filter(|x| x.is_finite()).count();
    measured as f64 / points.len().max(1) as f64
}

/// The errors of a fit on the postures `of`.
pub(crate) fn error_on(problem: &Problem, at: &Unknowns, of: &[usize]) -> PredictionError {
    let mut sums = ErrorSums::default();
    sums.add(problem, at, of, &Noise { length: 1.0, angle: 1.0 });
    sums.error(components(problem))
}

/// A model that is fitted: its parameters, and how its prior is chosen.
pub(crate) struct Candidate<'a> {
    /// The postures.
    pub problem: &'a Problem,
    /// The base parameters, for the prior.
    pub base: &'a GeometricBase,
    /// The fitted parameters.
    pub active: &'a [usize],
    /// Whether the errors of the geometry may have a prior.
    pub may_hold: bool,
    /// Whether there are enough rows for a fit without a prior.
    pub may_be_free: bool,
}

/// The rows of the fold k, and all others of `rows`.
fn split(rows: &[usize], k: usize) -> (Vec<usize>, Vec<usize>) {
    let of_fold = |place: &usize| place % FOLDS == k;
    let pick = |is: bool| (0..rows.len()).filter(|p| of_fold(p) == is).map(|p| rows[p]).collect();
    (pick(true), pick(false))
}

impl Candidate<'_> {
    fn prior(&self, deviation: Option<f64>) -> Option<Prior> {
        deviation.map(|deviation| Prior::new(self.problem, self.base, self.active, deviation))
    }

    /// Fits the postures `rows` with the prior that predicts best. If the noise is large, the error on postures left out is
    /// nearly the same for all narrow priors. But a prior that is too narrow makes the intervals too small. So the prior is
    /// then widened as long as its marginal likelihood grows. Also returns the standard deviation of the prior.
    fn fit(&self, rows: &[usize], start: &Unknowns, noise: Noise) -> (Fit, Option<f64>) {
        let mut deviation = self.deviation(rows, start, noise);
        let mut start = start.clone();
        loop {
            let prior = self.prior(deviation);
            let fitter = Fitter { problem: self.problem, active: self.active, prior: prior.as_ref(), rows };
            let fit = fitter.fit(&start, noise);
            let wider = DEVIATIONS.into_iter().find(|next| deviation.is_some_and(|deviation| *next > deviation));
            match (&prior, wider) {
                (Some(prior), Some(wider)) if prior.is_narrow(self.problem, &fit) => {
                    (deviation, start) = (Some(wider), fit.unknowns);
                }
                _ => return (fit, deviation),
            }
        }
    }

    /// The prior with the smallest error on folds of `rows` that are left out in turn; `None`: no prior.
    fn deviation(&self, rows: &[usize], start: &Unknowns, noise: Noise) -> Option<f64> {
        if !self.may_hold {
            return None;
        }
        let folds: Vec<_> = (0..FOLDS).map(|k| split(rows, k)).collect();
        let mut starts = vec![start.clone(); FOLDS];
        let mut best = (f64::INFINITY, None);
        for deviation in DEVIATIONS.into_iter().map(Some).chain(self.may_be_free.then_some(None)) {
            let mut sums = ErrorSums::default();
            for ((out, kept), at) in folds.iter().zip(&mut starts) {
                // The search with each prior starts at the result of the previous, narrower prior.
                let prior = self.prior(deviation);
                let fitter = Fitter { problem: self.problem, active: self.active, prior: prior.as_ref(), rows: kept };
                *at = fitter.quick(at, noise);
                sums.add(self.problem, at, out, &noise);
            }
            if sums.robust < best.0 {
                best = (sums.robust, deviation);
            }
        }
        best.1
    }

    /// Fits all postures, with the prior that predicts best.
    pub(crate) fn chosen(&self, start: &Unknowns, noise: Noise) -> (Fit, Option<f64>) {
        let rows: Vec<usize> = (0..self.problem.postures.len()).collect();
        self.fit(&rows, start, noise)
    }

    /// The error of each posture when it was left out, fold by fold. The prior is chosen without the postures of the fold.
    pub(crate) fn left_out(&self, start: &Unknowns, noise: Noise) -> Vec<ErrorSums> {
        let rows: Vec<usize> = (0..self.problem.postures.len()).collect();
        let mut each = vec![ErrorSums::default(); rows.len()];
        for k in 0..FOLDS {
            let (out, kept) = split(&rows, k);
            let fit = self.fit(&kept, start, noise).0;
            out.iter().for_each(|r| each[*r].add(self.problem, &fit.unknowns, &[*r], &noise));
        }
        each
    }
}

/// The error of the postures that are `used`, from the error of each.
pub(crate) fn error_of(problem: &Problem, each: &[ErrorSums], used: impl Fn(usize) -> bool) -> PredictionError {
    let mut sums = ErrorSums::default();
    for one in (0..each.len()).filter(|r| used(*r)).map(|r| &each[r]) {
        sums.length = (sums.length.0 + one.length.0, sums.length.1 + one.length.1);
        sums.angle = (sums.angle.0 + one.angle.0, sums.angle.1 + one.angle.1);
    }
    sums.error(components(problem))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use logs::Table;

    use crate::calibrate::calibrate_table;
    use crate::request::{CalibrateRequest, Calibrated};

    /// The baseline (an independent program) predicts the UR10 with fitted zeros to 12.1 mm and 10.8 mrad. The folds of the
    /// baseline consist of neighbouring postures; with such folds, this program has the same error.
    #[test]
    fn folds_explain_the_difference_to_the_baseline() {
        let folder = Path::new("/work/shared/data/calibration/ur10_camera");
        if !folder.exists() {
            eprintln!("skipped: {} is not there", folder.display());
            return;
        }
        let robot = rist::read_robot(&folder.join("ur10.urdf"), &rist::ModelOptions::default()).unwrap();
        let mut table = Table::read(&folder.join("poses.csv")).unwrap();
        let count = table.rows();
        // The program takes every fifth row as a fold. So neighbouring postures are put five rows apart, to be in one fold.
        let mut groups: Vec<Vec<usize>> = (0..5).map(|f| (0..count).filter(|k| k * 5 / count == f).collect()).collect();
        let order: Vec<usize> = (0..5 * count).filter_map(|place| groups[place % 5].pop()).collect();
        for column in &mut table.columns {
            *column = order.iter().map(|k| column[*k]).collect();
        }
        let request = CalibrateRequest { what: Calibrated::Zeros, ..CalibrateRequest::default() };
        let found = calibrate_table(&robot, &table, &request, None).unwrap().levels[1].left_out;
        // The limits are the results of the baseline plus half of their last printed digit.
        assert!(found.length.unwrap() <= 12.15e-3 && found.angle.unwrap() <= 10.85e-3, "{found:?}");
    }
}
