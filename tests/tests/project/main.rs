//! Tests of the project itself: packages, files, citations and pages.

mod citations;
mod front_door;
mod notation;
mod pages;
mod source;
mod supply;
mod tidy;
mod weight;
