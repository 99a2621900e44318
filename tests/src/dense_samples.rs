//! Checks a motion against its limits at dense samples.
//!
//! A motion is proved to keep its limits at all times; here, this is tested independently, at many more samples than in its
//! file.

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::limits::LimitKind;

/// Number of samples at which position, velocity, acceleration or jerk of a joint exceeds its limit, and the number of samples.
/// The motion is sampled `times` times as densely as in the file: from the start to the end of the first period, and during the
/// last blend (from the periodic motion to rest).
pub fn violations(artefact: &ExcitingMotion, times: f64) -> (usize, usize) {
    let motion = artefact.motion("motion.yaml").expect("a motion that was found");
    let step = 1.0 / (motion.rate * times);
    let (period, blend) = (motion.shape.period(), artefact.blend_s.unwrap_or(0.0));
    // All periods of the motion are equal, so it is enough to sample one.
    let spans = [(0.0, blend + period), (motion.duration() - blend, motion.duration())];
    let (mut beyond, mut count) = (0, 0);
    for (from, to) in spans {
        for i in 0..=((to - from) / step) as usize {
            let state = motion.at(from + step * i as f64);
            count += 1;
            for (x, joint) in state.iter().zip(&artefact.joints) {
                for (x, kind) in x.iter().zip(LimitKind::KINEMATIC) {
                    let (low, high) = joint.limits.bounds(kind).expect("every joint has it");
                    // The proof allows for rounding errors when the harmonics are summed, so this test allows for them too.
                    let rounding = 1e-12 * (high - low);
                    beyond += usize::from(*x < low - rounding || *x > high + rounding);
                }
            }
        }
    }
    (beyond, count)
}
