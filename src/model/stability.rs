//! Step bounds.
