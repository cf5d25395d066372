//! Assembled rows.
