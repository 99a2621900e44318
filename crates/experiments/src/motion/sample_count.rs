//! Limits the number of samples of a motion.
//!
//! A duration or a rate in a wrong unit would give more samples than memory or time allow.

/// Greatest number of samples of one motion: more than an hour at 1 kHz.
pub(crate) const MAX_SAMPLES_PER_MOTION: f64 = 4e6;

/// Fails if a motion has more than `MAX_SAMPLES_PER_MOTION` samples.
pub fn check_samples(samples: f64) -> Result<(), String> {
    if samples <= MAX_SAMPLES_PER_MOTION {
        return Ok(());
    }
    Err(format!("the motion has {samples:.1e} samples; at most {MAX_SAMPLES_PER_MOTION:.0e} are taken"))
}
