//! The pictures of docs/pictures: each is drawn from what it tells of, a model, a log, a table or a computation.

mod base_parameters;
mod benchmarks;
mod canvas;
mod cut_off;
mod excitation;
mod intervals;
mod spectrum;

/// Draws a picture: the text of an SVG.
type Draw = fn() -> Result<String, String>;

/// Name of the file, and who draws it.
pub(crate) const ALL: [(&str, Draw); 6] = [
    ("base_parameters", base_parameters::draw),
    ("benchmarks", benchmarks::draw),
    ("cut_off", cut_off::draw),
    ("excitation", excitation::draw),
    ("intervals", intervals::draw),
    ("spectrum", spectrum::draw),
];
