//! Draws the pictures of docs/pictures. Each is made from a model, a log, a table or a computation.
//!
//! A picture is an SVG file; `canvas` has its elements.

mod base_parameters;
mod benchmarks;
mod canvas;
mod cut_off;
mod excitation;
mod intervals;
mod spectrum;
mod verdict;

/// A function that draws a picture and returns the text of an SVG file.
type Draw = fn() -> Result<String, String>;

/// For each picture, the name of its file and the function that draws it.
pub(crate) const ALL: [(&str, Draw); 7] = [
    ("base_parameters", base_parameters::draw),
    ("benchmarks", benchmarks::draw),
    ("cut_off", cut_off::draw),
    ("excitation", excitation::draw),
    ("intervals", intervals::draw),
    ("spectrum", spectrum::draw),
    ("verdict", verdict::draw),
];
