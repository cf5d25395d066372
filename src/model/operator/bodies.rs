//! Bodies that nothing holds at a value.

use super::rows::{cell_grid, wall_fold};
use crate::model::Problem;
use crate::model::neighbors::Scratch;

/// The bodies of a scene, groups of particles that exchange with each other, in which nothing holds a value:
/// no held particle is near, and no wall or surface adds to a diagonal. Their steady state is known up to a
/// constant each, if there is one. Particles are in the problem's order.
pub fn floating_bodies(problem: &Problem) -> Vec<Vec<u32>> {
    let grid = cell_grid(problem);
    let order = grid.order();
    let mut groups = Groups { parent: (0..order.len() as u32).collect() };
    let mut is_held = vec![false; order.len()];
    let fold = wall_fold(problem, &grid);
    for (&rank, &diagonal) in fold.rows.rank().iter().zip(fold.rows.diagonal()) {
        is_held[rank as usize] |= diagonal != 0.0;
    }
    let held = |rank: u32| problem.is_held(order[rank as usize] as usize);
    let mut scratch = Scratch::default();
    for cell in 0..grid.layout().count() {
        grid.for_each_row(cell, problem.kernel.cutoff(), &mut scratch, |rank, neighbors| {
            if held(rank as u32) {
                return;
            }
            for neighbor in neighbors {
                if held(neighbor.rank) {
                    is_held[rank] = true;
                } else {
                    groups.join(rank as u32, neighbor.rank);
                }
            }
        });
    }
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); order.len()];
    for rank in (0..order.len() as u32).filter(|&rank| !held(rank)) {
        let first = groups.first(rank) as usize;
        members[first].push(rank);
    }
    members.retain(|body| !body.is_empty() && !body.iter().any(|&rank| is_held[rank as usize]));
    for body in &mut members {
        body.iter_mut().for_each(|rank| *rank = order[*rank as usize]);
    }
    members
}

/// Groups of numbers, each known by its first.
struct Groups {
    parent: Vec<u32>,
}

impl Groups {
    fn first(&mut self, mut k: u32) -> u32 {
        while self.parent[k as usize] != k {
            // Halves the way for those who come after.
            self.parent[k as usize] = self.parent[self.parent[k as usize] as usize];
            k = self.parent[k as usize];
        }
        k
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::scenes::lattice;
    use crate::model::{Condition, Face, KernelKind, ScalarField, Wall};

    #[test]
    fn a_body_floats_until_something_holds_it() {
        let mut problem = lattice(KernelKind::CubicSpline, 1, [12, 1, 1], 1.0, 2.0);
        // Two bodies, six particles each.
        problem.particles.position[6..].iter_mut().for_each(|x| x.x += 10.0);
        problem.domain.max.x += 10.0;
        let first: Vec<u32> = (0..6).collect();
        let second: Vec<u32> = (6..12).collect();
        assert_eq!(floating_bodies(&problem), [first.clone(), second.clone()]);
        let wall = |condition| {
            let face = Face { axis: 0, upper: true };
            Wall { name: "wall".into(), face, covers: None, condition }
        };
        problem.walls = vec![wall(Condition::insulated())];
        assert_eq!(floating_bodies(&problem).len(), 2);
        problem.walls = vec![wall(Condition::value(ScalarField::constant(1.0)))];
        assert_eq!(floating_bodies(&problem), [first]);
        problem.held = vec![3];
        assert_eq!(floating_bodies(&problem), Vec::<Vec<u32>>::new());
        problem.walls.clear();
        assert_eq!(floating_bodies(&problem), [second]);
    }
}
