//! Scenes that are one stencil all over, but for held particles and what walls impose.

use std::ops::Range;
use std::sync::Arc;

use super::kernel::{Combine, Run, Scratch};
use super::{LatticeOperator, Now, RATE};
use crate::model::Problem;
use crate::model::lattice::LatticeScene;
use crate::model::operator::{WallRows, within};

/// A scene that fills its lattice.
pub(super) struct Uniform {
    scene: Arc<LatticeScene>,
    /// Volume of a particle.
    volume: f64,
    /// Sites of the held particles, ascending.
    held: Vec<u32>,
    /// What each of them would gain a second without the others, which does not change.
    among_held: Vec<f64>,
    /// The rows that walls act on, by site.
    walls: WallRows,
}

impl Uniform {
    pub(super) fn new(problem: &Problem, scene: Arc<LatticeScene>, walls: WallRows) -> Self {
        let held = scene.held_sites(&problem.held);
        let among_held = scene.rates_among_held(&held, &problem.initial);
        let volume = problem.particles.volume.first().copied().unwrap_or(0.0);
        Self { scene, volume, held, among_held, walls }
    }

    /// Whether a held particle or one with a source of a wall is among `sites`.
    fn is_exceptional(&self, sites: &Range<usize>) -> bool {
        !(within(&self.held, sites).is_empty() && within(self.walls.rank(), sites).is_empty())
    }

    /// Adds the sources of walls at `sites` to their rates and takes those of held particles out;
    /// returns what these gave.
    fn exceptions(&self, now: &Now<'_>, sites: Range<usize>, rate: &mut [f64]) -> f64 {
        let mut given = 0.0;
        for k in within(&self.held, &sites) {
            let held = self.held[k] as usize;
            let rate = &mut rate[held - sites.start];
            given -= self.volume * (*rate - self.among_held[k]);
            *rate = 0.0;
        }
        for row in within(self.walls.rank(), &sites) {
            rate[self.walls.rank()[row] as usize - sites.start] += now.source[row];
        }
        given
    }
}

impl LatticeOperator for Uniform {
    fn lattice(&self) -> &LatticeScene {
        &self.scene
    }

    fn walls(&self) -> &WallRows {
        &self.walls
    }

    fn advance(
        &self,
        scratch: &mut Scratch,
        now: &Now<'_>,
        first: usize,
        out: &mut [f64],
        combine: Combine,
    ) -> f64 {
        let (mut given, mut done) = (0.0, 0);
        while done < out.len() {
            let run = Run::starting(&self.scene, first + done, out.len() - done);
            let out = &mut out[done..done + run.length];
            let sites = run.first..run.first + run.length;
            done += run.length;
            if !self.is_exceptional(&sites) {
                scratch.work(&self.scene, now.state, &run, combine, out);
                continue;
            }
            scratch.work(&self.scene, now.state, &run, RATE, out);
            given += self.exceptions(now, sites.clone(), out);
            for (out, own) in out.iter_mut().zip(&now.state[sites]) {
                *out = combine.share * own + combine.scale * *out;
            }
        }
        given
    }

    fn memory_bytes(&self) -> usize {
        let held = size_of_val(&*self.held) + size_of_val(&*self.among_held);
        held + self.walls.memory_bytes()
    }
}
