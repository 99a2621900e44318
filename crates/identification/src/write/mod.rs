//! An estimate as a page for people.

pub mod html;
pub mod svg;
pub mod write_back;
