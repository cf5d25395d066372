//! Neighbour search by a cell grid: a counting sort into cells no smaller than the support.

mod grid;
mod layout;

pub use grid::{CellGrid, Neighbor, Scratch};
pub use layout::{CellLayout, CellPlace};
