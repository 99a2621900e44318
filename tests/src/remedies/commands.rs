//! The tested commands that do not read a log of a motion.
//!
//! Each command has a file in this folder.

use super::case::Command;
use super::{of_excite, of_lint, of_postures, of_wrench};

pub const COMMANDS: [Command; 4] = [of_postures::COMMAND, of_wrench::COMMAND, of_lint::COMMAND, of_excite::COMMAND];
