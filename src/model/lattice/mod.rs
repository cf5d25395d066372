//! Sums over the infinite lattice, and scenes on a box lattice, filled or not.

mod beside_seams;
mod edge;
mod mixed;
mod regular;
mod scene;
mod survey;

use glam::DVec3;

pub use edge::{Edge, End, Site};
pub use mixed::MixedScene;
pub use scene::{ABSENT, LatticeScene, LineClass, WIDEST, sites_with_particles};

use super::Kernel;

/// Calls `visit` with the vector to every neighbour of a particle of the infinite lattice.
pub fn for_each_neighbor(kernel: &Kernel, spacing: f64, mut visit: impl FnMut(DVec3)) {
    let reach = (kernel.support_radius() / spacing).ceil() as i64;
    let reach_along = |axis: usize| if axis < kernel.dimension() { reach } else { 0 };
    for z in -reach_along(2)..=reach_along(2) {
        for y in -reach_along(1)..=reach_along(1) {
            for x in -reach_along(0)..=reach_along(0) {
                let offset = spacing * DVec3::new(x as f64, y as f64, z as f64);
                if (x, y, z) != (0, 0, 0) && offset.length() < kernel.cutoff() {
                    visit(offset);
                }
            }
        }
    }
}

/// Deff / D of the plain operator on the infinite lattice: (1/dim) sum_b V r |W'(r)|.
///
/// It depends on the kernel and on H / dx alone and not on dx, which is why plain SPH does not
/// converge to D under refinement. 1 within rounding for the cubic spline at H / dx = 2 in 1-D;
/// 1.0200416738 in 3-D.
pub fn effective_diffusivity_ratio(kernel: &Kernel, spacing: f64) -> f64 {
    let volume = spacing.powi(kernel.dimension() as i32);
    let mut sum = 0.0;
    for_each_neighbor(kernel, spacing, |offset| {
        sum -= volume * offset.length_squared() * kernel.dw_over_r(offset.length());
    });
    sum / kernel.dimension() as f64
}

#[cfg(test)]
mod tests;
