//! Zero-phase low-pass: a digital Butterworth filter that runs forward and backward.
//!
//! |H(w)|^2 = 1 / (1 + (tan(w/2) / tan(w_c/2))^(2n)) for order n and cut-off w_c, by the bilinear transform with prewarping.
//! With a forward and a backward pass the phase cancels and the magnitude is |H|^2 (-6 dB at the cut-off). At each end the
//! signal is extended by 3 (n + 1) samples, reflected about its end point. The initial state of every section is the steady
//! state of a constant. These are the conventions of `scipy.signal.filtfilt`.
//!
//! The filter is a chain of second-order sections in transposed direct form II. A polynomial of order n is never formed.

use processor::{Work, widely};

/// A Butterworth low-pass of order n: a chain of sections, each with unit gain at zero frequency.
#[derive(Clone, Debug)]
pub struct Butterworth {
    sections: Vec<Section>,
    order: usize,
}

/// A second-order section, (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2).
#[derive(Clone, Copy, Debug)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

impl Butterworth {
    /// Makes a low-pass with this `cutoff`, Hz, for signals with the sampling rate `rate`, Hz. `None` unless 0 < cutoff < rate /
    /// 2 and 1 <= order <= 20.
    pub fn low_pass(order: usize, cutoff: f64, rate: f64) -> Option<Butterworth> {
        if !(cutoff > 0.0 && cutoff < 0.5 * rate && rate.is_finite() && ORDERS.contains(&order)) {
            return None;
        }
        let w = (std::f64::consts::PI * cutoff / rate).tan();
        let mut sections = Vec::with_capacity(order.div_ceil(2));
        if order % 2 == 1 {
            let d = 1.0 + w;
            sections.push(Section { b: [w / d, w / d, 0.0], a: [(w - 1.0) / d, 0.0] });
        }
        for k in 0..order / 2 {
            // The analogue filter has the poles w exp(+-i (pi - angle)).
            let angle = std::f64::consts::PI * (2 * k + 1 + order % 2) as f64 / (2 * order) as f64;
            let damping = if order % 2 == 1 { 2.0 * angle.cos() } else { 2.0 * angle.sin() };
            let d = 1.0 + damping * w + w * w;
            let b = w * w / d;
            sections
                .push(Section { b: [b, 2.0 * b, b], a: [2.0 * (w * w - 1.0) / d, (1.0 - damping * w + w * w) / d] });
        }
        Some(Butterworth { sections, order })
    }

    /// The time after which the effect of the start of a signal has decayed to 10^-12, s. `cutoff` in Hz.
    ///
    /// The slowest pole decays by exp(-2 pi f_c sin(pi / (2 n)) t).
    pub fn memory(order: usize, cutoff: f64) -> f64 {
        let decay = 2.0 * std::f64::consts::PI * cutoff * (0.5 * std::f64::consts::PI / order as f64).sin();
        FORGOTTEN_EFFECT_RATIO.ln() / decay
    }

    /// Filters signals of equal length without phase shift. Signals shorter than two samples are returned unchanged.
    ///
    /// Each filtered sample depends on the previous one, so a single signal cannot use SIMD lanes. `SIGNALS_PER_PASS` signals in
    /// parallel lanes take hardly longer than one signal.
    pub fn zero_phase(&self, mut signals: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        for group in signals.chunks_mut(SIGNALS_PER_PASS) {
            let Some((all, pad)) = self.forward(group) else { break };
            self.backward(all, pad, &mut |first, rows| put(group, first, rows));
        }
        signals
    }

    /// Filters like [`Butterworth::zero_phase`], but returns only the samples with the indices `chosen`, ascending. The order is
    /// sample by sample, one number per signal.
    pub fn zero_phase_at(&self, signals: &[Vec<f64>], chosen: &[usize]) -> Vec<f64> {
        let width = signals.len();
        let mut kept = vec![0.0; chosen.len() * width];
        for (g, group) in signals.chunks(SIGNALS_PER_PASS).enumerate() {
            let mut left = chosen.len();
            let mut keep = |first: usize, rows: &[[f64; SIGNALS_PER_PASS]]| {
                while left > 0 && chosen[left - 1] >= first {
                    left -= 1;
                    let row = &rows[chosen[left] - first][..group.len()];
                    kept[left * width + g * SIGNALS_PER_PASS..][..row.len()].copy_from_slice(row);
                }
            };
            match self.forward(group) {
                Some((all, pad)) => self.backward(all, pad, &mut keep),
                None => keep(0, taken(group, 0, &mut [[0.0; SIGNALS_PER_PASS]; ROWS_PER_COPY])),
            }
        }
        kept
    }

    /// Filters at most `SIGNALS_PER_PASS` signals of one length forward. Returns them in SIMD lanes with the reflected samples
    /// at both ends, and the number of reflected samples per end. `None` for signals shorter than two samples.
    fn forward(&self, group: &[Vec<f64>]) -> Option<(Vec<[f64; SIGNALS_PER_PASS]>, usize)> {
        let n = group.first().map_or(0, Vec::len);
        if n < 2 {
            return None;
        }
        let pad = (3 * (self.order + 1)).min(n - 1);
        let (mut before, mut behind) = (vec![[0.0; SIGNALS_PER_PASS]; pad], vec![[0.0; SIGNALS_PER_PASS]; pad]);
        for (lane, x) in group.iter().enumerate() {
            for i in 0..pad {
                before[i][lane] = 2.0 * x[0] - x[pad - i];
                behind[i][lane] = 2.0 * x[n - 1] - x[n - 2 - i];
            }
        }
        let mut run = FilterRun::new(&self.sections, before[0]);
        let mut all = Vec::with_capacity(n + 2 * pad);
        all.extend(before);
        run.forward(&mut all);
        for first in (0..n).step_by(ROWS_PER_COPY) {
            all.resize(pad + n.min(first + ROWS_PER_COPY), [0.0; SIGNALS_PER_PASS]);
            run.forward(taken(group, first, &mut all[pad + first..]));
        }
        all.extend(behind);
        run.forward(&mut all[pad + n..]);
        Some((all, pad))
    }

    /// Filters the result of `forward` backward. Calls `each` with the index of the first sample and the rows of every block,
    /// from the last block to the first.
    fn backward(
        &self,
        mut all: Vec<[f64; SIGNALS_PER_PASS]>,
        pad: usize,
        each: &mut dyn FnMut(usize, &[[f64; SIGNALS_PER_PASS]]),
    ) {
        let Some(last) = all.last() else { return };
        let mut run = FilterRun::new(&self.sections, *last);
        let n = all.len() - 2 * pad;
        run.backward(&mut all[pad + n..]);
        for first in (0..n).step_by(ROWS_PER_COPY).rev() {
            let rows = &mut all[pad + first..pad + n.min(first + ROWS_PER_COPY)];
            run.backward(rows);
            each(first, rows);
        }
    }
}

/// The signals are stored one by one, but the filter has one signal per SIMD lane. This many rows are transposed at a time from
/// one form to the other, so that the rows stay in the cache.
const ROWS_PER_COPY: usize = 256;

/// Copies the samples of the signals from index `first` on into `rows`, one signal per SIMD lane. Returns the filled rows.
fn taken<'a>(
    group: &[Vec<f64>],
    first: usize,
    rows: &'a mut [[f64; SIGNALS_PER_PASS]],
) -> &'a mut [[f64; SIGNALS_PER_PASS]] {
    let count = group.first().map_or(0, |x| rows.len().min(x.len() - first));
    for (lane, x) in group.iter().enumerate() {
        rows.iter_mut().zip(&x[first..first + count]).for_each(|(row, x)| row[lane] = *x);
    }
    &mut rows[..count]
}

/// Writes rows back into the signals from index `first` on.
fn put(group: &mut [Vec<f64>], first: usize, rows: &[[f64; SIGNALS_PER_PASS]]) {
    for (lane, x) in group.iter_mut().enumerate() {
        x[first..first + rows.len()].iter_mut().zip(rows).for_each(|(x, row)| *x = row[lane]);
    }
}

/// A filter while it runs, with the state of each section.
struct FilterRun {
    sections: Vec<(Section, State)>,
}

impl FilterRun {
    /// Starts a filter in the steady state that a constant signal `first` would reach.
    fn new(sections: &[Section], first: [f64; SIGNALS_PER_PASS]) -> FilterRun {
        let start = |&Section { b, a }: &Section| {
            let state = [first.map(|first| (1.0 - b[0]) * first), first.map(|first| (b[2] - a[1]) * first)];
            (Section { b, a }, state)
        };
        FilterRun { sections: sections.iter().map(start).collect() }
    }

    /// Filters samples in place, from the first to the last.
    fn forward(&mut self, samples: &mut [[f64; SIGNALS_PER_PASS]]) {
        widely(Pass { run: self, samples, is_backward: false });
    }

    /// Filters samples in place, from the last to the first.
    fn backward(&mut self, samples: &mut [[f64; SIGNALS_PER_PASS]]) {
        widely(Pass { run: self, samples, is_backward: true });
    }
}

/// One pass of a filter over samples, in place.
struct Pass<'a> {
    run: &'a mut FilterRun,
    samples: &'a mut [[f64; SIGNALS_PER_PASS]],
    is_backward: bool,
}

impl Work for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        // Two sections run in one loop: while one sample is in the second section, the next sample is in the first.
        for sections in self.run.sections.chunks_mut(2) {
            match (sections, self.is_backward) {
                ([one, two], false) => over([one, two], self.samples.iter_mut()),
                ([one, two], true) => over([one, two], self.samples.iter_mut().rev()),
                (some, false) => some.iter_mut().for_each(|one| over([one], self.samples.iter_mut())),
                (some, true) => some.iter_mut().for_each(|one| over([one], self.samples.iter_mut().rev())),
            }
        }
    }
}

/// Filters samples in place with S sections in series. The states of the sections stay in registers during the loop.
#[inline(always)]
fn over<'a, const S: usize>(
    sections: [&mut (Section, State); S],
    samples: impl Iterator<Item = &'a mut [f64; SIGNALS_PER_PASS]>,
) {
    let mut states = [[[0.0; SIGNALS_PER_PASS]; 2]; S];
    for s in 0..S {
        states[s] = sections[s].1;
    }
    for sample in samples {
        let mut x = *sample;
        for s in 0..S {
            let (Section { b, a }, [z0, z1]) = (sections[s].0, &mut states[s]);
            for lane in 0..SIGNALS_PER_PASS {
                let u = x[lane];
                let v = b[0] * u + z0[lane];
                z0[lane] = b[1] * u - a[0] * v + z1[lane];
                z1[lane] = b[2] * u - a[1] * v;
                x[lane] = v;
            }
        }
        *sample = x;
    }
    for s in 0..S {
        sections[s].1 = states[s];
    }
}

/// The state of a section: two values per SIMD lane.
type State = [[f64; SIGNALS_PER_PASS]; 2];

/// Allowed orders of a low-pass.
const ORDERS: std::ops::RangeInclusive<usize> = 1..=20;
/// The effect of the start of a signal is negligible when it has decayed by this factor. The memory of a filter is the time of
/// this decay.
const FORGOTTEN_EFFECT_RATIO: f64 = 1e12;

/// Number of signals that are filtered together, one per SIMD lane.
const SIGNALS_PER_PASS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    fn wave() -> Vec<f64> {
        (0..40).map(|i| (0.3 * i as f64).sin() + 0.1 * (((7 * i) % 5) as f64 - 2.0)).collect()
    }

    /// Results of `scipy.signal.butter` and `filtfilt`, SciPy 1.17.1: samples 0, 1, 20, 38, 39. The tolerance allows for
    /// rounding errors of SciPy at the lowest cut-off: SciPy computes the filter as a polynomial and not as sections.
    #[test]
    fn agrees_with_scipy() {
        let figures = [
            (4, 0.1, [-0.1639495879435, 0.0531409772525, -0.2145755376823, -0.7141056716306, -0.7898111012870]),
            (5, 0.15, [-0.2134700859253, 0.1441607273439, -0.2689188904751, -0.7349232067538, -0.6467430386458]),
            (1, 0.3, [-0.2000375668113, 0.2182046298452, -0.2924553736369, -0.8111323856153, -0.6616613215382]),
            (2, 0.02, [-0.4271748063131, -0.4072210296922, -0.1526509301940, -0.1203263787292, -0.1212892398718]),
        ];
        for (order, cutoff, expected) in figures {
            let y = Butterworth::low_pass(order, cutoff, 2.0).unwrap().zero_phase(vec![wave()]).remove(0);
            for (i, e) in [0, 1, 20, 38, 39].into_iter().zip(expected) {
                assert!((y[i] - e).abs() < 1e-11, "order {order}, sample {i}: {} {e}", y[i]);
            }
        }
    }

    #[test]
    fn some_samples_of_the_whole() {
        let f = Butterworth::low_pass(3, 0.2, 2.0).unwrap();
        for (count, n) in [(0, 0), (1, 1), (3, 600), (8, 513), (19, 1024)] {
            let signals: Vec<Vec<f64>> =
                (0..count).map(|s| (0..n).map(|i| (0.1 * (i * (s + 1)) as f64).sin()).collect()).collect();
            let whole = f.zero_phase(signals.clone());
            for step in [1, 7, 300] {
                let chosen: Vec<usize> = (n.min(2)..n).step_by(step).collect();
                let expected: Vec<f64> = chosen.iter().flat_map(|&r| whole.iter().map(move |x| x[r])).collect();
                assert_eq!(f.zero_phase_at(&signals, &chosen), expected, "{count} of {n}");
            }
        }
    }

    #[test]
    fn keeps_lines_and_halves_the_cutoff() {
        let f = Butterworth::low_pass(4, 10.0, 1000.0).unwrap();
        let line: Vec<f64> = (0..2000).map(|i| 3.0 - 0.01 * i as f64).collect();
        let passed = f.zero_phase(vec![line.clone()]).remove(0);
        // Samples near the ends are not compared, because the padding of fifteen samples is shorter than the transient of the
        // filter.
        let worst = (800..1200).map(|i| (passed[i] - line[i]).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9, "a straight line passes: {worst}");
        let wave: Vec<f64> = (0..4000).map(|i| (2.0 * std::f64::consts::PI * 10.0 * i as f64 / 1000.0).sin()).collect();
        let peak = f.zero_phase(vec![wave]).remove(0)[1000..3000].iter().copied().fold(0.0, f64::max);
        // The period of the sine has 100 samples, so one sample is exactly at the peak.
        assert!((peak - 0.5).abs() < 1e-6, "{peak}");
    }

    /// Reference implementation: filters one signal, one section after the other, forward and backward.
    fn alone(f: &Butterworth, x: &[f64]) -> Vec<f64> {
        let (n, pad) = (x.len(), (3 * (f.order + 1)).min(x.len() - 1));
        let mut y: Vec<f64> = (1..=pad).rev().map(|i| 2.0 * x[0] - x[i]).collect();
        y.extend_from_slice(x);
        y.extend((1..=pad).map(|i| 2.0 * x[n - 1] - x[n - 1 - i]));
        for _ in 0..2 {
            let first = y[0];
            for Section { b, a } in &f.sections {
                let mut z = [(1.0 - b[0]) * first, (b[2] - a[1]) * first];
                for s in &mut y {
                    let v = b[0] * *s + z[0];
                    z = [b[1] * *s - a[0] * v + z[1], b[2] * *s - a[1] * v];
                    *s = v;
                }
            }
            y.reverse();
        }
        y[pad..pad + n].to_vec()
    }

    #[test]
    fn signals_in_lanes_are_as_one_by_one() {
        for (order, count, n) in [(4, 1, 40), (3, 8, 300), (5, 19, 1000), (4, 3, 2), (2, 9, 7)] {
            let f = Butterworth::low_pass(order, 0.13, 2.0).unwrap();
            let signal = |k: usize| (0..n).map(|i| ((0.1 + 0.03 * k as f64) * i as f64).sin() + k as f64).collect();
            let signals: Vec<Vec<f64>> = (0..count).map(signal).collect();
            let expected: Vec<Vec<f64>> = signals.iter().map(|x| alone(&f, x)).collect();
            assert_eq!(f.zero_phase(signals), expected, "order {order}, {count} of {n}");
        }
        let f = Butterworth::low_pass(4, 0.1, 2.0).unwrap();
        assert_eq!(f.zero_phase(vec![vec![1.0], vec![2.0]]), [[1.0], [2.0]]);
    }

    #[test]
    fn refuses_what_is_no_filter() {
        for (order, cutoff, rate) in [(4, 0.0, 1.0), (4, 0.5, 1.0), (0, 0.1, 1.0), (4, f64::NAN, 1.0), (99, 0.1, 1.0)] {
            assert!(Butterworth::low_pass(order, cutoff, rate).is_none());
        }
    }
}
