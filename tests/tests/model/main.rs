//! Tests of the model of a robot and of the generated code: laws of mechanics, published tables, comparison with other programs.

mod agreement;
mod closed_loops;
mod closed_points;
mod control_functions;
mod controller;
mod conversion;
mod counts;
mod derivations_end;
mod examples;
mod formulas;
mod frames_of_functions;
mod functions;
mod generated_source;
mod generation;
mod geometric_errors;
mod implicit_loops;
mod inverse_geometry;
mod lanes;
mod large_robots;
mod laws_of_dynamics;
mod oracle;
mod parameter_names;
mod random_robots;
mod random_structures;
mod regrouping;
mod weak_columns;
