//! The record of an experiment: sampled positions and efforts.

/// A record: `q[k][i]` in rad, `current[k][i]` in A, of coordinate k at instant i.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time between samples, s.
    pub sample_time: f64,
    /// rad (m), one series a coordinate.
    pub q: Vec<Vec<f64>>,
    /// A, or N m (N) where torques were recorded.
    pub current: Vec<Vec<f64>>,
}

impl Record {
    /// The samples of some windows, one after another.
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
}
