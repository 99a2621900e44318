//! The record of an experiment: sampled positions and currents (or torques).

/// The record of an experiment: `q[k][i]` in rad (m) and `current[k][i]` in A, of coordinate k at sample i.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time between samples, s.
    pub sample_time: f64,
    /// Measured positions, rad (m), one series per coordinate.
    pub q: Vec<Vec<f64>>,
    /// Motor currents, A, one series per coordinate. If torques were recorded: torques, N m (N).
    pub current: Vec<Vec<f64>>,
}

impl Record {
    /// The samples of the record in these windows (ranges of sample indices), one window after the other.
    pub fn cut(&self, windows: &[std::ops::Range<usize>]) -> Record {
        let take = |x: &Vec<f64>| {
            windows.iter().flat_map(|w| x.get(w.clone()).unwrap_or_default().iter().copied()).collect::<Vec<f64>>()
        };
        Record {
            sample_time: self.sample_time,
            q: self.q.iter().map(take).collect(),
            current: self.current.iter().map(take).collect(),
        }
    }

    /// Keeps every `parts`-th sample: its position, and the mean of the current over the new sample time centred on the sample.
    ///
    /// A drive that logs at a lower rate than it controls gives such a record. At both ends the mean uses only the existing
    /// samples.
    pub fn thinned(&self, parts: usize) -> Record {
        let parts = parts.max(1);
        // Mean by the trapezoidal rule: if `parts` is even, the two end samples have weight one half.
        let (half, ends) = (parts / 2, if parts.is_multiple_of(2) { 0.5 } else { 1.0 });
        let mean = |x: &Vec<f64>, i: usize| {
            let about = i.saturating_sub(half)..(i + half + 1).min(x.len());
            let weight = |k: usize| if k.abs_diff(i) == half && half > 0 { ends } else { 1.0 };
            let (sum, all) = about.fold((0.0, 0.0), |(sum, all), k| (sum + weight(k) * x[k], all + weight(k)));
            sum / all
        };
        Record {
            sample_time: self.sample_time * parts as f64,
            q: self.q.iter().map(|q| q.iter().copied().step_by(parts).collect()).collect(),
            current: self.current.iter().map(|x| (0..x.len()).step_by(parts).map(|i| mean(x, i)).collect()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_record_holds_means_of_the_current() {
        let record = |n: usize| Record {
            sample_time: 1e-3,
            q: vec![(0..n).map(|i| i as f64).collect()],
            current: vec![(0..n).map(|i| if i % 3 == 0 { 3.0 } else { 0.0 }).collect()],
        };
        let thinned = record(13).thinned(3);
        assert_eq!(thinned.q, vec![vec![0.0, 3.0, 6.0, 9.0, 12.0]]);
        // Every third sample is 3 and the others are 0, so a mean over three samples is 1. At both ends of the record the mean
        // covers only two samples, of which one is 3, so it is 1.5.
        assert_eq!(thinned.current, vec![vec![1.5, 1.0, 1.0, 1.0, 1.5]]);
        // Each mean over the sample time of two samples contains one 3 at an end, with weight one half: 0.5 * 3 / 2 = 0.75.
        assert_eq!(record(7).thinned(2).current[0][1..3], [0.75, 0.75]);
        assert_eq!(record(5).thinned(1), record(5));
    }
}
