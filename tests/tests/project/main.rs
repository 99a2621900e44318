//! What the project asks of itself: its packages, files, citations, pages.

mod citations;
mod front_door;
mod notation;
mod pages;
mod source;
mod supply;
mod tidy;
mod weight;
