//! Estimates drive gains (torque per current of each drive, N m/A) together with the parameters, from logs of motor currents.

pub mod equations;
pub mod likelihood;
pub mod replicates;
pub mod total_least_squares;
