//! Tests of the program `rist`: output, drawings, refusals and hostile input.

mod as_given;
#[cfg(unix)]
mod brought_along;
mod calibrate;
mod calibration_example;
mod chromium;
mod command_line;
mod digits;
mod drawing;
mod fields_in_texts;
mod help;
#[cfg(unix)]
mod hostile;
#[cfg(unix)]
mod hostile_files;
mod live_page;
#[cfg(unix)]
mod mutations;
mod one_gate;
mod page;
mod readme;
mod refusals;
mod terminal;
mod what_is_read;
#[cfg(unix)]
mod whole_files;
