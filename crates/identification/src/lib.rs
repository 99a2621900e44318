//! From experiments to parameters.

mod regressor;

pub use regressor::Regressor;
