//! Scenes that are one stencil all over, but for held particles and what walls impose.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::kernel::{Run, Scratch};
use super::parts::Parts;
use super::{BesideSeams, LatticeOperator};
use crate::model::Problem;
use crate::model::lattice::LatticeScene;
use crate::model::operator::{SourceRows, take_below, within_near};
use crate::solver::cpu::operator::{Now, RATE};
use crate::solver::cpu::written::Written;

/// A scene that fills its lattice.
pub(in crate::solver::cpu) struct Uniform {
    scene: Arc<LatticeScene>,
    /// Capacity of a particle.
    capacity: f64,
    /// Sites of the held particles, ascending.
    held: Vec<u32>,
    /// What each of them would gain a second without the others, which does not change; a change of the
    /// state has none.
    among_held: Vec<f64>,
    /// The rows that walls and sources act on, by site, with what the stencil does not have of them.
    walls: SourceRows,
    parts: Parts,
}

impl Uniform {
    pub(in crate::solver::cpu) fn new(
        problem: &Problem,
        scene: Arc<LatticeScene>,
        walls: SourceRows,
    ) -> Self {
        let held = scene.held_sites(&problem.held);
        let among_held = scene.rates_among_held(&held, &problem.potentials(&problem.initial));
        let capacity = problem.particles.volume.first().map_or(0.0, |_| problem.capacity(0));
        let parts = match problem.has_one_curve() {
            true => Parts::of_factors(&[]),
            false => {
                let all = 0..problem.particles.len() as u32;
                Parts::of_materials(problem, &scene, |_| 1.0, all)
            }
        };
        Self { scene, capacity, held, among_held, walls: walls.beside_stencil(&[]), parts }
    }

    /// Adds the sources of some rows of walls to the rates of `sites` and takes those of some held particles out;
    /// returns what these gave.
    fn exceptions(
        &self,
        now: &Now<'_>,
        sites: &Range<usize>,
        held: Range<usize>,
        walls: Range<usize>,
        rate: &mut [f64],
    ) -> f64 {
        let mut given = 0.0;
        for k in held {
            let held = self.held[k] as usize;
            let rate = &mut rate[held - sites.start];
            let among_held = if now.source.is_some() { self.among_held[k] } else { 0.0 };
            given -= self.capacity * (*rate - among_held);
            *rate = 0.0;
        }
        for row in walls {
            let site = self.walls.rank()[row] as usize;
            let source = now.source.map_or(0.0, |source| source[row]);
            rate[site - sites.start] += self.walls.diagonal()[row] * now.values[site] + source;
        }
        given
    }
}

impl LatticeOperator for Uniform {
    const PARTS: [usize; 3] = [1 << 12, 1 << 10, 1 << 10];
    const IS_STENCIL: bool = true;

    fn scene(&self) -> &LatticeScene {
        &self.scene
    }

    fn held(&self) -> &[u32] {
        &self.held
    }

    fn sources(&self) -> &SourceRows {
        &self.walls
    }

    fn advance(
        &self,
        scratch: &mut Scratch,
        now: &Now<'_>,
        first: usize,
        out: &mut [f64],
        written: Written<'_>,
        _beside_seams: BesideSeams,
    ) -> f64 {
        let (mut given, mut done) = (0.0, 0);
        let all = first..first + out.len();
        let mut held = within_near(&self.held, &all, &mut scratch.seen.held);
        let mut walls = within_near(self.walls.rank(), &all, &mut scratch.seen.walls);
        while done < out.len() {
            let run = Run::starting(&self.scene, first + done, out.len() - done);
            let out = &mut out[done..done + run.length];
            let sites = run.first..run.first + run.length;
            done += run.length;
            let held = take_below(&self.held, &mut held, sites.end);
            let walls = take_below(self.walls.rank(), &mut walls, sites.end);
            if held.is_empty() && walls.is_empty() {
                scratch.work(&self.scene, now.values, &run, &self.parts, written, out);
                continue;
            }
            scratch.work(&self.scene, now.values, &run, &self.parts, Written::Same(RATE), out);
            given += self.exceptions(now, &sites, held, walls, out);
            let parts = self.parts.from(sites.start, &mut scratch.seen.parts);
            for (part, kind) in parts.within(sites.clone()) {
                let out = &mut out[part.start - sites.start..part.end - sites.start];
                kind.written(written).write(&now.values[part], out);
            }
        }
        given
    }

    fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.scene.counts.iter().product()];
        let of_place = self.scene.diagonals();
        diagonal.par_iter_mut().enumerate().for_each(|(site, d)| *d = of_place(site));
        for (&site, linear) in self.walls.rank().iter().zip(self.walls.diagonal()) {
            diagonal[site as usize] += linear;
        }
        self.held.iter().for_each(|&site| diagonal[site as usize] = -1.0);
        diagonal
    }

    fn memory_bytes(&self) -> usize {
        let held = size_of_val(&*self.held) + size_of_val(&*self.among_held);
        held + self.walls.memory_bytes() + self.parts.memory_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{KernelKind, scenes};
    use crate::solver::cpu::lattice::Lattice;
    use crate::solver::cpu::operator::CpuOperator;

    #[test]
    fn lines_of_a_place_are_its_neighbours() {
        for (dimension, counts) in [(1, [30, 1, 1]), (2, [9, 4, 1]), (3, [9, 8, 7]), (3, [4, 9, 3])]
        {
            let problem = scenes::lattice(KernelKind::CubicSpline, dimension, counts, 0.1, 2.5);
            let scene = Arc::new(LatticeScene::of(&problem).expect("a lattice"));
            let uniform = Uniform::new(&problem, Arc::clone(&scene), SourceRows::default());
            let operator = Lattice::new(uniform);
            for place in 0..problem.particles.len() {
                let mut expected = Vec::new();
                scene.entries(place, |other, weight| expected.push((other, weight)));
                expected.sort_by_key(|&(other, _)| other);
                let which = operator.which_lines(place).expect("one");
                let mut found = Vec::new();
                let lines = operator.shared_lines(which).expect("lines");
                lines.for_each(place, |other, weight| found.push((other, weight)));
                assert_eq!(found, expected, "{place} of {counts:?}");
            }
            assert_ne!(operator.which_lines(0), operator.which_lines(1));
        }
    }
}
