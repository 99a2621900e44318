//! Identification on whole arms: logs of every format, measured robots, simulated experiments.
//!
//! One program of many modules, because each program of tests is linked with everything.

mod broken_logs;
mod coverage;
mod experiments;
mod gains_of_currents;
mod lack_of_fit;
mod log_files;
mod log_formats;
mod measured;
mod misfit;
mod panda;
mod simulated_dynamics;
mod spectrum_analysis;
