//! Decides whether the residual of a fit is noise: its autocorrelation time (memory) is then near the autocorrelation time of
//! white noise after the same low-pass. A residual with a longer memory contains an effect that the model lacks.

use crate::estimate::artefact::Estimate;
use crate::estimate::autocorrelation::NOISE_MEMORY_PERIODS;
use crate::estimate::digits::significant;
use crate::estimate::residuals::JointResidual;

/// A residual is not noise if its autocorrelation time exceeds the autocorrelation time of white noise after the low-pass by
/// this factor.
const LONG_MEMORY_RATIO: f64 = 2.0;

/// Whether the residual of every joint is noise, by its autocorrelation time; false if no autocorrelation time is known.
pub(super) fn is_noise(estimate: &Estimate) -> bool {
    let memory = |j: &JointResidual| Some(times(estimate.cutoff?, j.memory?));
    let known: Vec<f64> = estimate.joints.iter().filter_map(memory).collect();
    !known.is_empty() && known.iter().all(|times| *times <= LONG_MEMORY_RATIO)
}

/// Autocorrelation time of a residual (`memory`, s), divided by the autocorrelation time of white noise after a low-pass with the
/// cut-off `cutoff`, Hz.
fn times(cutoff: f64, memory: f64) -> f64 {
    memory * cutoff / NOISE_MEMORY_PERIODS
}

/// A sentence on whether the residual of the joint with the longest autocorrelation time is noise; `None` if no
/// autocorrelation time is known.
pub(crate) fn not_noise(estimate: &Estimate) -> Option<String> {
    let known = estimate.joints.iter().filter_map(|joint| Some((joint, joint.memory?)));
    let (joint, memory) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (name, times) = (&joint.coordinate, times(estimate.cutoff?, memory));
    Some(match times > LONG_MEMORY_RATIO {
        true => format!(
            "the residual of {name} is not noise alone: its autocorrelation time is {} s, {times:.0} times that of noise, so friction or flexibility is missing",
            significant(memory),
        ),
        false => "the residual looks like noise".into(),
    })
}
