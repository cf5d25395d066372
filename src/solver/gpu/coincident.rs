//! Particles that sit on one another, where the kernel does not allow it.

use glam::DVec3;

use crate::gpu::Real;
use crate::model::Problem;
use crate::model::cells::CellGrid;
use crate::solver::SolverError;

/// An error if two particles are so close that their offsets may round to the same, and the kernel
/// has no finite weight there.
pub(super) fn check(problem: &Problem, cells: &CellGrid, real: Real) -> Result<(), SolverError> {
    let definition = problem.kernel.kind().definition();
    if definition.finite_at_zero {
        return Ok(());
    }
    let resolution = cells.size.max_element() * real.epsilon();
    match find(problem, resolution) {
        None => Ok(()),
        Some((a, b)) => Err(SolverError::CoincidentParticles {
            a,
            b,
            at: problem.particles.position[a],
            kernel: definition.name,
        }),
    }
}

/// A pair within `resolution` (m), by a sweep along x.
fn find(problem: &Problem, resolution: f64) -> Option<(usize, usize)> {
    let position = &problem.particles.position;
    let domain = &problem.domain;
    let length = domain.extent().x;
    let along = |x: DVec3| match domain.periodic[0] {
        true => (x.x - domain.min.x).rem_euclid(length),
        false => x.x,
    };
    let mut sweep: Vec<(f64, usize)> = (0..).zip(position).map(|(i, &x)| (along(x), i)).collect();
    if domain.periodic[0] {
        // The lower end comes again beyond the upper one.
        let lower = sweep.iter().filter(|&&(x, _)| x <= resolution);
        let again: Vec<_> = lower.map(|&(x, i)| (x + length, i)).collect();
        sweep.extend(again);
    }
    sweep.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (n, &(x, a)) in sweep.iter().enumerate() {
        for &(_, b) in sweep[n + 1..]
            .iter()
            .take_while(|&&(y, _)| y - x <= resolution)
        {
            let apart = domain.nearest_image(position[a] - position[b]);
            if a != b && apart.length() <= resolution {
                return Some((a.min(b), a.max(b)));
            }
        }
    }
    None
}
