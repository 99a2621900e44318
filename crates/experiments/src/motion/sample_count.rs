//! How many samples a motion may have.
//!
//! A duration or a rate of another unit would make a motion whose samples take memory or time without end.

/// Samples of one motion: more than an hour at 1 kHz.
pub(crate) const MAX_SAMPLES_PER_MOTION: f64 = 4e6;

/// Refuses a motion of more than `MAX_SAMPLES_PER_MOTION`.
pub fn check_samples(samples: f64) -> Result<(), String> {
    if samples <= MAX_SAMPLES_PER_MOTION {
        return Ok(());
    }
    Err(format!("the motion has {samples:.1e} samples; at most {MAX_SAMPLES_PER_MOTION:.0e} are taken"))
}
