//! Identification by spectrum analysis: the paper and RIST-MH.

pub mod experiment;
pub mod harmonics;
pub mod identify;
pub mod paper;
pub mod rist_mh;
pub mod validate;
pub mod words;
