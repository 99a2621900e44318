//! Tests of identification on whole arms: logs of every format, measured robots, simulated experiments.
//!
//! They form one test program of many modules, because every test program is linked with all crates.

mod broken_logs;
mod claims_of_logs;
mod contact;
mod coverage;
mod default_path;
mod doctor;
mod drives;
mod estimates;
mod experiments;
mod field_logs;
mod fleet;
mod gains_of_currents;
mod hobby_arms;
mod identify_logs;
mod joint_friction;
mod known_load;
mod lack_of_fit;
mod log_files;
mod log_formats;
mod measured;
mod methods;
mod misfit;
mod monitor_on_cortex;
mod obeyed_remedies;
mod panda;
mod plan_verdict;
mod positions_beyond_limits;
mod possible_bodies;
mod postures;
mod random_situations;
mod replay;
mod scrambled;
mod servos;
mod signals_of_logs;
mod simulated_dynamics;
mod spectrum_analysis;
mod standing_joints;
mod unknowns;
mod verdict;
mod written_bodies;
