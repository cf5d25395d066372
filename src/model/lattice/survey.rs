//! What a lattice's stencil tells about a scene, without a walk over its particles.

use glam::DVec3;
use rayon::prelude::*;

use super::{Edge, LatticeScene, Site};
use crate::model::Problem;
use crate::model::operator::rows::Survey;

/// A place along an axis, standing for all that find the same around them.
#[derive(Clone, Copy)]
struct Place {
    at: usize,
    /// How many it stands for.
    count: usize,
}

/// Particles that find the same around them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Alike {
    /// One of them.
    pub(super) at: [usize; 3],
    /// How many they are.
    pub(super) count: usize,
    /// Whether any is not held.
    pub(super) free: bool,
    /// Mass of each, kg.
    pub(super) mass: f64,
    /// Their diffusivity over that of the stencil.
    pub(super) ratio: f64,
}

impl LatticeScene {
    /// The survey of `problem`, whose lattice this is: that of [`crate::model::operator::rows`],
    /// from one particle of each kind of place. Whether walls leave the matrix symmetric is for
    /// [`crate::model::operator::rows::wall_fold`] to say.
    pub fn survey(&self, problem: &Problem) -> Survey {
        let places = [0, 1, 2].map(|axis| self.places(axis));
        let mut held = vec![0; places.iter().map(Vec::len).product()];
        let kind = |[x, y, z]: [usize; 3]| (z * places[1].len() + y) * places[0].len() + x;
        let sites = self.sites();
        for &particle in &problem.held {
            let site = sites(particle) as usize;
            let at = self.at(site);
            let of = |axis: usize| self.kind_of_place(axis, at[axis]);
            held[kind([of(0), of(1), of(2)])] += 1;
        }
        let mut survey = Survey::EMPTY;
        let mass = problem.mass(0);
        for (z, place_z) in places[2].iter().enumerate() {
            for (y, place_y) in places[1].iter().enumerate() {
                for (x, place_x) in places[0].iter().enumerate() {
                    let count = place_x.count * place_y.count * place_z.count;
                    let at = [place_x.at, place_y.at, place_z.at];
                    let free = count > held[kind([x, y, z])];
                    let alike = Alike { at, count, free, mass, ratio: 1.0 };
                    self.note(problem, &alike, &mut survey);
                }
            }
        }
        survey.with_sources(problem)
    }

    /// The kinds of places along an axis: each near its ends, and one for all between.
    fn places(&self, axis: usize) -> Vec<Place> {
        let (count, reach) = (self.counts[axis], self.reach);
        if count <= 2 * reach + 1 {
            return (0..count).map(|at| Place { at, count: 1 }).collect();
        }
        let end = |at| Place { at, count: 1 };
        let between = Place { at: reach, count: count - 2 * reach };
        (0..reach).map(end).chain([between]).chain((count - reach..count).map(end)).collect()
    }

    /// Which of [`LatticeScene::places`] stands for `at`.
    pub(super) fn kind_of_place(&self, axis: usize, at: usize) -> usize {
        let (count, reach) = (self.counts[axis], self.reach);
        if count <= 2 * reach + 1 || at < reach {
            at
        } else if at < count - reach {
            reach
        } else {
            at + 2 * reach + 1 - count
        }
    }

    /// A site of each kind, those that find the same around them: first along the first axis.
    pub fn kinds(&self) -> impl Iterator<Item = [usize; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis| self.places(axis));
        z.into_iter().flat_map(move |z| {
            let (x, y) = (x.clone(), y.clone());
            y.into_iter().flat_map(move |y| x.clone().into_iter().map(move |x| [x.at, y.at, z.at]))
        })
    }

    /// Which of [`LatticeScene::kinds`] a site is of.
    pub fn kind(&self, at: [usize; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| self.kind_of_place(axis, at[axis]));
        let [nx, ny, _] = self.counts.map(|count| count.min(2 * self.reach + 1));
        (z * ny + y) * nx + x
    }

    /// Calls `visit(steps, weight, sites)` for every place of the stencil around `at` that is not
    /// past a free end.
    pub(super) fn for_each(
        &self,
        at: [usize; 3],
        mut visit: impl FnMut([isize; 3], f64, [Site; 3]),
    ) {
        let site = |axis: usize, step: isize| {
            self.edges[axis].at(at[axis] as isize + step, self.counts[axis])
        };
        for class in &self.classes {
            for &[y, z] in &class.lines {
                let (Some(site_y), Some(site_z)) = (site(1, y), site(2, z)) else {
                    continue;
                };
                let reach = class.weights.len() as isize - 1;
                for x in -reach..=reach {
                    let weight = class.weights[x.unsigned_abs()];
                    if let Some(site_x) = site(0, x).filter(|_| weight != 0.0) {
                        visit([x, y, z], weight, [site_x, site_y, site_z]);
                    }
                }
            }
        }
    }

    /// The part of the rate of each particle at the sites `held` (ascending) that comes from held
    /// ones, its own ghosts among them, and from what ghosts add to its diagonal: it is no exchange
    /// with others. `values` are in the problem's order.
    pub fn rates_among_held(&self, held: &[u32], values: &[f64]) -> Vec<f64> {
        held.par_iter().map(|&site| self.rate_among_held(site as usize, held, values)).collect()
    }

    fn rate_among_held(&self, site: usize, held: &[u32], values: &[f64]) -> f64 {
        let [nx, ny, _] = self.counts;
        let (own, mut sum) = (values[self.particle(site)], 0.0);
        self.for_each(self.at(site), |_, weight, places| {
            let [x, y, z] = places.map(|place| place.index);
            let there = (z * ny + y) * nx + x;
            let factor: f64 = places.iter().map(|place| place.factor).product();
            let is_held = held.binary_search(&(there as u32)).is_ok();
            let value = if is_held { values[self.particle(there)] } else { own };
            sum += weight * (factor * value - own);
        });
        sum
    }

    /// Sites along each axis to every neighbour, and its weight, 1/s.
    pub fn steps(&self) -> impl Iterator<Item = ([isize; 3], f64)> + '_ {
        self.classes.iter().flat_map(|class| {
            class.lines.iter().flat_map(move |&[y, z]| {
                let reach = class.weights.len() as isize - 1;
                let weights =
                    (-reach..=reach).map(move |x| ([x, y, z], class.weights[x.unsigned_abs()]));
                weights.filter(|&(_, weight)| weight != 0.0)
            })
        })
    }

    /// How many sites a neighbour is away at most, round the ends of the last axis if that is periodic.
    pub fn longest_step(&self) -> usize {
        let [nx, ny, _] = self.counts;
        let strides = [1, nx, nx * ny];
        let last = self.dimension - 1;
        let steps = (0..last).map(|axis| match self.edges[axis] {
            Edge::Periodic => (self.counts[axis] - 1) * strides[axis],
            Edge::Open(_) => self.reach * strides[axis],
        });
        self.reach * strides[last] + steps.sum::<usize>()
    }

    /// Calls `visit(other, weight)` for every neighbour of a site, with its weight (1/s) and what ghosts of it
    /// add to that, each by itself.
    pub fn entries(&self, site: usize, mut visit: impl FnMut(usize, f64)) {
        let [nx, ny, _] = self.counts;
        self.for_each(self.at(site), |_, weight, places| {
            let [x, y, z] = places.map(|place| place.index);
            let other = (z * ny + y) * nx + x;
            if other != site {
                visit(other, weight * places.iter().map(|place| place.factor).product::<f64>());
            }
        });
    }

    /// The diagonal of the stencil at a site, 1/s, with what mirrors add to it: a function of the site.
    pub fn diagonals(&self) -> impl Fn(usize) -> f64 + Sync {
        let of_kind: Vec<f64> = self.kinds().map(|at| self.diagonal(at)).collect();
        move |site| of_kind[self.kind(self.at(site))]
    }

    fn diagonal(&self, at: [usize; 3]) -> f64 {
        let mut diagonal = 0.0;
        self.for_each(at, |_, weight, sites| {
            let is_own = sites.map(|site| site.index) == at;
            let factor: f64 = sites.iter().map(|site| site.factor).product();
            diagonal += weight * (if is_own { factor } else { 0.0 } - 1.0);
        });
        diagonal
    }

    /// Adds some particles.
    pub(super) fn note(&self, problem: &Problem, alike: &Alike, survey: &mut Survey) {
        let Alike { at, count, free, mass, ratio } = *alike;
        let (mut neighbors, mut diagonal) = (0, 0.0);
        let mut density = mass * problem.kernel.w(0.0);
        let mut columns: Vec<([usize; 3], f64)> = Vec::new();
        self.for_each(at, |steps, weight, sites| {
            let column = sites.map(|site| site.index);
            let factor: f64 = sites.iter().map(|site| site.factor).product();
            let weight = ratio * weight;
            diagonal += weight;
            if sites.iter().all(|site| !site.is_ghost) {
                neighbors += 1;
                let offset = DVec3::from_array(steps.map(|step| step as f64));
                density += mass * problem.kernel.w((offset * problem.spacing).length());
            }
            if column == at {
                diagonal -= weight * factor;
            } else if let Some(known) = columns.iter_mut().find(|(known, _)| *known == column) {
                known.1 += weight * factor;
            } else {
                columns.push((column, weight * factor));
            }
        });
        survey.entries += neighbors * count as u64;
        survey.most_neighbors = survey.most_neighbors.max(neighbors as usize);
        survey.note_density(density);
        if free {
            let negative: f64 = columns.iter().map(|(_, weight)| -weight.min(0.0)).sum();
            survey.note_diagonal(diagonal, negative);
        }
    }
}
