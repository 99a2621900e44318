//! The pictures of docs/pictures, each drawn from a model, a log, a table or a computation.

mod base_parameters;
mod benchmarks;
mod canvas;
mod cut_off;
mod excitation;
mod intervals;
mod spectrum;
mod verdict;

/// Draws a picture: the text of an SVG.
type Draw = fn() -> Result<String, String>;

/// The name of each file, and the function that draws it.
pub(crate) const ALL: [(&str, Draw); 7] = [
    ("base_parameters", base_parameters::draw),
    ("benchmarks", benchmarks::draw),
    ("cut_off", cut_off::draw),
    ("excitation", excitation::draw),
    ("intervals", intervals::draw),
    ("spectrum", spectrum::draw),
    ("verdict", verdict::draw),
];
