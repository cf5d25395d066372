//! The diffusion operator: pair means, correction, the weight of a pair, and assembled rows.
//!
//! rate_a = sum_b w_ab (C_b - C_a) with w_ab = -V_b kbar(D_a, D_b) F(r_ab) / moment >= 0: the
//! Brookshaw sum of the report's (107) and (109). The moment is 1 for the plain operator and the
//! lattice's Deff / D for the moment-corrected one.

mod bodies;
pub mod fold;
mod fronts;
mod interfaces;
mod pair_mean;
mod row_block;
pub mod rows;
mod seams;
mod some_rows;
mod source_rows;
mod survey;
mod weight;

pub use bodies::floating_bodies;
pub use fronts::{Front, Fronts};
pub use interfaces::ContactResistance;
pub use pair_mean::PairMean;
pub use seams::{Local, Locals, LocalsMut, Seam, SeamGroup, Seams};
pub use some_rows::{SomeRows, Visit, seek, take_below, within, within_near};
pub use source_rows::{FoldNeeds, SourceRows};
pub use weight::{Correction, PairWeight};
