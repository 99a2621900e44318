//! File formats: each reads a text into a [`crate::Robot`].
