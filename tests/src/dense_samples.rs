//! Checks a motion against its limits at dense samples.

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::limits::LimitKind;

/// How often position, velocity, acceleration or jerk of a joint is beyond its limit, and the number of samples. There
/// are `times` times as many samples as in the file, from the start to the end of the first period, and over the last
/// blend.
pub fn violations(artefact: &ExcitingMotion, times: f64) -> (usize, usize) {
    let motion = artefact.motion("motion.yaml").expect("a motion that was found");
    let step = 1.0 / (motion.rate * times);
    let (period, blend) = (motion.shape.period(), artefact.blend_s.unwrap_or(0.0));
    // All periods are alike.
    let spans = [(0.0, blend + period), (motion.duration() - blend, motion.duration())];
    let (mut beyond, mut count) = (0, 0);
    for (from, to) in spans {
        for i in 0..=((to - from) / step) as usize {
            let state = motion.at(from + step * i as f64);
            count += 1;
            for (x, joint) in state.iter().zip(&artefact.joints) {
                for (x, kind) in x.iter().zip(LimitKind::KINEMATIC) {
                    let (low, high) = joint.limits.bounds(kind).expect("every joint has it");
                    // Rounding of the sum, which the proof encloses.
                    let rounding = 1e-12 * (high - low);
                    beyond += usize::from(*x < low - rounding || *x > high + rounding);
                }
            }
        }
    }
    (beyond, count)
}
