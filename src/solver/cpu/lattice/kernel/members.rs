//! The lines around a run.

use super::Run;
use crate::model::lattice::{LatticeScene, WIDEST};

/// The lines around a run, but for its own: for each its class, and the site that is beside the
/// first of the run. Those of one class go together, as far as there are enough.
#[derive(Debug, Default)]
pub(super) struct Members {
    pub(super) fours: Vec<(usize, [usize; 4])>,
    pub(super) twos: Vec<(usize, [usize; 2])>,
    /// With the factor of their values, since ghosts are among them.
    pub(super) ones: Vec<(usize, usize, f64)>,
    /// K_i
    pub(super) along: [f64; WIDEST + 1],
}

/// The lines around the run that was last asked for.
#[derive(Debug, Default)]
pub(super) struct MembersOf {
    members: Members,
    /// The first site of that run, if it is inside.
    first: Option<usize>,
    /// Lines of a class whose values count as they are.
    plain: Vec<usize>,
}

impl MembersOf {
    pub(super) fn of(&mut self, scene: &LatticeScene, run: &Run) -> &Members {
        let before = std::mem::replace(&mut self.first, run.is_inside.then_some(run.first));
        match before.filter(|_| run.is_inside) {
            // Inside, the same lines are around every run.
            Some(before) => self.members.shift(run.first.wrapping_sub(before)),
            None => self.find(scene, run),
        }
        &self.members
    }

    fn find(&mut self, scene: &LatticeScene, run: &Run) {
        let Self { members, plain, .. } = self;
        let [nx, ny, nz] = scene.counts;
        let [_, y, z] = scene.at(run.first);
        members.clear();
        for (c, class) in scene.classes.iter().enumerate() {
            plain.clear();
            let mut count = 0.0;
            for &[step_y, step_z] in &class.lines {
                let site_y = scene.edges[1].at(y as isize + step_y, ny);
                let site_z = scene.edges[2].at(z as isize + step_z, nz);
                let (Some(y), Some(z)) = (site_y, site_z) else {
                    continue;
                };
                count += 1.0;
                let line = (z.index * ny + y.index) * nx + run.x;
                match y.factor * z.factor {
                    // Of the line itself there is no difference.
                    _ if (step_y, step_z) == (0, 0) => {}
                    1.0 => plain.push(line),
                    factor => members.ones.push((c, line, factor)),
                }
            }
            members.add(c, plain);
            for (along, weight) in members.along.iter_mut().zip(&class.weights) {
                *along += weight * count;
            }
        }
    }
}

impl Members {
    fn clear(&mut self) {
        self.fours.clear();
        self.twos.clear();
        self.ones.clear();
        self.along.fill(0.0);
    }

    /// Moves all lines by some sites; those before wrap around.
    fn shift(&mut self, sites: usize) {
        let move_by = |line: &mut usize| *line = line.wrapping_add(sites);
        self.fours.iter_mut().flat_map(|(_, lines)| lines).for_each(move_by);
        self.twos.iter_mut().flat_map(|(_, lines)| lines).for_each(move_by);
        self.ones.iter_mut().for_each(|(_, line, _)| move_by(line));
    }

    /// Adds lines of a class whose values count as they are.
    fn add(&mut self, class: usize, lines: &[usize]) {
        let mut rest = lines;
        while let &[a, b, c, d, ref more @ ..] = rest {
            self.fours.push((class, [a, b, c, d]));
            rest = more;
        }
        if let &[a, b, ref more @ ..] = rest {
            self.twos.push((class, [a, b]));
            rest = more;
        }
        self.ones.extend(rest.iter().map(|&one| (class, one, 1.0)));
    }
}
