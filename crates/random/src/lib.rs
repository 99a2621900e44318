//! Random numbers from a seed: the same numbers at every run and on every machine. Not for cryptography.
//!
//! [`SplitMix`] has a state of one word, for the draws of a derivation or a test. [`Random`] is a stream for thousands of
//! draws, with normal deviates and a stream for each index of an enumeration.

#![warn(missing_docs)]

mod random;
mod split_mix;

pub use crate::random::Random;
pub use crate::split_mix::SplitMix;
