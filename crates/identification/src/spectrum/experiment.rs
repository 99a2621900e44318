//! An experiment of a plan: the commanded motion and its record (positions and currents), cut to the samples that are used.
//! Also measures the noise of the record from its periods: the scatter of the samples about their mean period. A sweep is a
//! slow motion forward and back, without periods.

use std::ops::Range;

use experiments::motion::record::Record;
use experiments::plan::exciting_trajectory::{ExcitingTrajectory, JointMotion};
use numerics::fourier::{fold, scatter, scatter_of_harmonics};

/// A motion and its record inside the time windows of the plan: whole periods, or a sweep forward and back.
#[derive(Clone, Debug)]
pub struct SpectralExperiment {
    /// The commanded motion.
    pub trajectory: ExcitingTrajectory,
    /// Positions, rad (m), one series per coordinate.
    pub q: Vec<Vec<f64>>,
    /// Currents, A (torques, N m, if the log has torques), one series per coordinate.
    pub current: Vec<Vec<f64>>,
    /// Number of samples of each time window.
    pub windows: Vec<usize>,
    /// Contribution of a known load to the base parameters, one entry per base parameter. Empty without a load.
    pub load: Vec<f64>,
}

impl SpectralExperiment {
    /// Cuts a record to the time windows of the motion. The record must start with the motion. `None` if the record is shorter
    /// than the motion or has another number of coordinates.
    pub fn new(trajectory: ExcitingTrajectory, record: &Record) -> Option<SpectralExperiment> {
        let windows: Vec<Range<usize>> = trajectory.windows();
        let end = windows.iter().map(|w| w.end).max()?;
        let n = trajectory.centre.len();
        let series = || record.q.iter().chain(&record.current);
        if record.q.len() != n || record.current.len() != n || series().any(|s| s.len() < end) {
            return None;
        }
        let cut = record.cut(&windows);
        let windows = windows.iter().map(Range::len).collect();
        Some(SpectralExperiment { trajectory, q: cut.q, current: cut.current, windows, load: vec![] })
    }

    /// A copy with a known load. `base_parameters`: contribution of the load to the base parameters.
    pub fn loaded(mut self, base_parameters: &[f64]) -> SpectralExperiment {
        self.load = base_parameters.to_vec();
        self
    }

    /// Number of samples in all windows.
    pub fn len(&self) -> usize {
        self.windows.iter().sum()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The period of the motion in samples. `None` for a sweep.
    pub fn period(&self) -> Option<usize> {
        match self.trajectory.motion {
            JointMotion::Swing { period, .. } => Some(period),
            JointMotion::Sweep { .. } => None,
        }
    }

    /// Finds the joint with the largest relative scatter of its position. Returns the index of the joint and the relative
    /// scatter: the standard deviation of the samples about the mean period, divided by the standard deviation of the mean
    /// period. `None` for a sweep and for a single period.
    pub fn scatter(&self) -> Option<(usize, f64)> {
        let period = self.period()?;
        let of = |k: usize| {
            let mean = fold(&self.q[k], period);
            let middle = mean.iter().sum::<f64>() / period as f64;
            let swing = (mean.iter().map(|q| (q - middle).powi(2)).sum::<f64>() / period as f64).sqrt();
            (k, scatter(&self.q[k], period) / swing)
        };
        let found = self.trajectory.moving().into_iter().map(of).filter(|(_, s)| s.is_finite());
        found.reduce(|a, b| if b.1 > a.1 { b } else { a })
    }

    /// The torques, N m: currents times the drive gains.
    pub fn torque(&self, gain: &[f64]) -> Vec<Vec<f64>> {
        let times = |(c, g): (&Vec<f64>, &f64)| c.iter().map(|c| c * g).collect();
        self.current.iter().zip(gain).map(times).collect()
    }
}

/// Noise of the record of each coordinate: standard deviations of a single sample.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseLevels {
    /// Noise of the positions, rad, one per coordinate.
    pub position: Vec<f64>,
    /// Noise of the currents in the unit of the record, one per coordinate.
    pub current: Vec<f64>,
}

impl NoiseLevels {
    /// The measured noise: the scatter of the samples about their mean period, pooled over the periodic experiments. `None` if
    /// no experiment has two periods.
    pub fn measured(experiments: &[SpectralExperiment]) -> Option<NoiseLevels> {
        NoiseLevels::pooled(experiments, |x, _, period| (scatter(x, period), (x.len() - period) as f64))
    }

    /// The measured noise in the harmonics with a frequency up to `highest`, Hz. Chatter of a controller at higher frequencies
    /// is left out.
    pub fn of_band(experiments: &[SpectralExperiment], highest: f64) -> Option<NoiseLevels> {
        NoiseLevels::pooled(experiments, |x, experiment, period| {
            let harmonics = harmonics(highest, period, experiment.trajectory.sample_time);
            let periods = x.len() / period;
            (scatter_of_harmonics(x, period, harmonics), (periods.saturating_sub(1) * harmonics) as f64)
        })
    }

    /// The rms of a noise level over the experiments, weighted by degrees of freedom. `level` computes the noise level of a
    /// series and the degrees of freedom. The arguments of `level` are the series, the experiment and the period in samples.
    fn pooled(
        experiments: &[SpectralExperiment],
        level: impl Fn(&[f64], &SpectralExperiment, usize) -> (f64, f64),
    ) -> Option<NoiseLevels> {
        let n = experiments.first()?.q.len();
        let pooled = |series: &dyn Fn(&SpectralExperiment) -> &Vec<Vec<f64>>, k: usize| {
            let (mut sum, mut count) = (0.0, 0.0);
            for e in experiments {
                let Some(period) = e.period() else { continue };
                let (s, freedom) = level(&series(e)[k], e, period);
                if s.is_finite() {
                    sum += freedom * s * s;
                    count += freedom;
                }
            }
            (count > 0.0).then(|| (sum / count).sqrt())
        };
        Some(NoiseLevels {
            position: (0..n).map(|k| pooled(&|e| &e.q, k)).collect::<Option<_>>()?,
            current: (0..n).map(|k| pooled(&|e| &e.current, k)).collect::<Option<_>>()?,
        })
    }

    /// Noise of the torques with these drive gains, N m.
    pub fn torque(&self, gain: &[f64]) -> Vec<f64> {
        self.current.iter().zip(gain).map(|(c, g)| c * g).collect()
    }
}

/// Margin that is added to the product frequency times period before this product is rounded down to a number of harmonics.
/// Without the margin, rounding errors could turn an integer product into the next smaller integer.
const WHOLE_HARMONIC_MARGIN: f64 = 1e-9;

/// Number of harmonics with a frequency up to `f`, Hz, but at most the number that `period` samples can resolve. `h`: sample
/// time, s.
pub(crate) fn harmonics(f: f64, period: usize, h: f64) -> usize {
    ((f * (period as f64 * h) + WHOLE_HARMONIC_MARGIN) as usize).min(period.saturating_sub(1) / 2)
}

/// The mean period of each series: the mean over all periods of `period` samples.
pub(crate) fn folded(series: &[Vec<f64>], period: usize) -> Vec<Vec<f64>> {
    series.iter().map(|s| fold(s, period)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiments::motion::profile::Profile;
    use experiments::plan::exciting_trajectory::{MovingJoints, SwingCourse};
    use experiments::plan::motion_kind::MotionKind;
    use random::Random;

    fn noisy(count: usize) -> Record {
        let mut random = Random::new(2);
        let mut wave = |scale: f64| -> Vec<f64> {
            let angle = |i: usize| std::f64::consts::TAU * i as f64 / 400.0;
            (0..count).map(|i| angle(i).sin() + scale * random.normal()).collect()
        };
        Record { sample_time: 1e-3, q: vec![wave(1e-3)], current: vec![wave(0.2)] }
    }

    fn swing() -> ExcitingTrajectory {
        let joints = MovingJoints { kind: MotionKind::Inertial, fast: 0, slow: &[], centre: &[0.0] };
        let course = SwingCourse {
            profile: Profile::BangBang,
            period: 400,
            acceleration: 10.0,
            slow_velocity: &[0.0],
            duration: 4.0,
            sample_time: 1e-3,
        };
        ExcitingTrajectory::swing(&joints, &course)
    }

    #[test]
    fn transients_are_dropped_and_noise_is_measured() {
        let experiment = SpectralExperiment::new(swing(), &noisy(4800)).unwrap();
        assert_eq!(experiment.len(), 4000);
        let levels = NoiseLevels::measured(&[experiment]).unwrap();
        // With 3600 degrees of freedom, the relative standard error of a standard deviation is 1.2 %. The tolerance is five
        // standard errors.
        assert!((levels.position[0] / 1e-3 - 1.0).abs() < 0.06);
        assert!((levels.torque(&[2.0])[0] / 0.4 - 1.0).abs() < 0.06);
        let experiment = SpectralExperiment::new(swing(), &noisy(4800)).unwrap();
        // A sine of amplitude 1 has a standard deviation of 0.71.
        let (joint, scatter) = experiment.scatter().unwrap();
        assert!(joint == 0 && (scatter / 1.41e-3 - 1.0).abs() < 0.06, "{scatter}");
    }

    #[test]
    fn a_short_record_is_refused() {
        assert!(SpectralExperiment::new(swing(), &noisy(4799)).is_none());
        assert!(NoiseLevels::measured(&[]).is_none());
    }
}
