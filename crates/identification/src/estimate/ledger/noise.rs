//! Whether what a fit leaves looks like noise.

use crate::estimate::artefact::Estimate;
use crate::estimate::autocorrelation::NOISE_MEMORY_PERIODS;
use crate::estimate::digits::significant;
use crate::estimate::residuals::JointResidual;

/// A residual whose memory is more than this many times that of noise is none.
const LONG_MEMORY_RATIO: f64 = 2.0;

/// Whether what is left at every joint has no longer memory than noise.
pub(super) fn is_noise(estimate: &Estimate) -> bool {
    let memory = |j: &JointResidual| Some(times(estimate.cutoff?, j.memory?));
    let known: Vec<f64> = estimate.joints.iter().filter_map(memory).collect();
    !known.is_empty() && known.iter().all(|times| *times <= LONG_MEMORY_RATIO)
}

/// The memory of a residual over that of noise below the cut-off.
fn times(cutoff: f64, memory: f64) -> f64 {
    memory * cutoff / NOISE_MEMORY_PERIODS
}

/// What the autocorrelation of the residual says, for the joint with the longest memory.
pub(crate) fn not_noise(estimate: &Estimate) -> Option<String> {
    let known = estimate.joints.iter().filter_map(|joint| Some((joint, joint.memory?)));
    let (joint, memory) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (name, times) = (&joint.coordinate, times(estimate.cutoff?, memory));
    Some(match times > LONG_MEMORY_RATIO {
        true => format!(
            "what is left at {name} is not noise alone: it stays alike for {} s, {times:.0} times as long as noise does, so friction or \
             flexibility is missing",
            significant(memory),
        ),
        false => "what is left looks like noise".into(),
    })
}
