//! Reads and prints untrusted input safely: [`source`] reads bytes up to a maximum; [`budget`] limits the memory, and
//! [`unfolding`] the decompressed bytes; [`shown`] escapes names for the output; [`opened`] lists the files that were read;
//! [`suggestion`] finds the valid word nearest to a mistyped one.

pub mod budget;
pub mod opened;
pub mod shown;
pub mod source;
pub mod suggestion;
pub mod unfolding;
