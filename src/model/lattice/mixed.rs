//! Scenes on a box lattice that a stencil describes in part: bodies with holes or of any shape,
//! several materials, walls on parts of faces, surfaces.
//!
//! A site whose whole stencil holds particles of one diffusivity has the row of a uniform lattice,
//! times its diffusivity over that of the stencil. All others have rows of their own: those beside
//! holes and outer surfaces, beside other materials, and within reach of a wall that covers a part
//! of its face or that the stencil does not know otherwise. Both have the same weight for a pair that
//! they share, to the last bits: distances in rows are those of the sites, not of the positions.

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;

use super::regular::{Ends, NOTHING, Near, kinds, regular};
use super::scene::{ON_SITE, ON_SITE_BY_WALLS, check_volume, counts, order, sites_of, stencil};
use super::survey::Alike;
use super::{ABSENT, LatticeScene};
use crate::model::neighbors::Neighbor;
use crate::model::operator::rows::Survey;
use crate::model::operator::{FoldNeeds, PairWeight, SomeRows, Visit};
use crate::model::{Material, Problem};

/// The least part of the box that particles have to fill: below it the states of the empty sites
/// would take as much memory as the list.
const LEAST_FILLED: f64 = 0.1;

/// A lattice with rows where its stencil does not hold.
#[derive(Clone, Debug)]
pub struct MixedScene {
    /// The box of sites, some of them perhaps without a particle, and the stencil of the largest
    /// diffusivity.
    pub lattice: LatticeScene,
    /// From which site on the stencil has which factor, the first from 0; at sites that have rows of
    /// their own, any.
    pub ratios: Vec<(u32, f64)>,
    /// The sites without a particle.
    pub absent: Vec<Range<u32>>,
    /// The sites with rows of their own, and those on which walls or sources act beyond the stencil.
    visits: Vec<Visit>,
    /// The sites without rows of their own.
    alike: Vec<Alike>,
    /// How many particles there are.
    particles: usize,
    /// Diffusivity of the stencil, m2/s.
    base: f64,
}

impl MixedScene {
    /// The scene as a lattice with rows where its stencil does not hold.
    ///
    /// # Errors
    /// Why it is none, in words.
    pub fn of(problem: &Problem) -> Result<Self, &'static str> {
        let counts = counts(problem, |axis| problem.domain.periodic[axis])?;
        let particles = problem.particles.len();
        let sites = sites_of(counts);
        if (particles as f64) < LEAST_FILLED * sites as f64 {
            return Err("the particles fill less than a tenth of the box around them");
        }
        if sites >= ABSENT as usize {
            return Err("the box around the particles has more sites than 32 bits number");
        }
        check_volume(problem)?;
        let walls = FoldNeeds::of(problem);
        let allowed = if FoldNeeds::of_walls(problem) == FoldNeeds::None {
            ON_SITE
        } else {
            ON_SITE_BY_WALLS
        };
        let order = order(problem, counts, allowed)?;
        let weight = PairWeight::new(problem);
        let base = fastest(problem);
        let (reach, classes) = stencil(problem, &weight, base)?;
        let ends = Ends::of(problem, &weight, reach);
        let near = Near::of(problem, counts, &ends);
        let lattice = LatticeScene {
            dimension: problem.dimension,
            counts,
            order,
            edges: ends.edges,
            reach,
            classes,
        };
        let kinds = kinds(problem, &lattice);
        let regular = regular(problem, &lattice, &kinds, &near);
        let has_sources = |at, particle| {
            walls >= FoldNeeds::Steady && (near.wall(at) || problem.is_fed(particle))
        };
        let mut scene = Self {
            lattice,
            ratios: Vec::new(),
            absent: Vec::new(),
            visits: Vec::new(),
            alike: Vec::new(),
            particles,
            base: problem.materials[usize::from(problem.particles.material[base])].diffusivity(),
        };
        scene.sort_out(problem, &kinds, &regular, has_sources);
        Ok(scene)
    }

    /// Goes through all sites and notes what each needs.
    fn sort_out(
        &mut self,
        problem: &Problem,
        kinds: &[u16],
        regular: &[bool],
        has_sources: impl Fn([usize; 3], usize) -> bool,
    ) {
        let held = self.lattice.held_sites(&problem.held);
        let mut held = held.into_iter().peekable();
        let mut known = Known::new(&self.lattice);
        for (site, (&kind, &regular)) in kinds.iter().zip(regular).enumerate() {
            let rank = site as u32;
            let is_held = held.next_if_eq(&rank).is_some();
            if kind == NOTHING {
                match self.absent.last_mut() {
                    Some(range) if range.end == rank => range.end += 1,
                    _ => self.absent.push(rank..rank + 1),
                }
            } else if is_held || !regular {
                self.visits.push(Visit { rank, whole: true });
            } else {
                let at = self.lattice.at(site);
                if has_sources(at, self.lattice.particle(site)) {
                    self.visits.push(Visit { rank, whole: false });
                }
                let alike = known.add(problem, self, site, at, kind);
                if self.ratios.last().is_none_or(|(_, before)| *before != alike.ratio) {
                    let from = if self.ratios.is_empty() { 0 } else { rank };
                    self.ratios.push((from, alike.ratio));
                }
            }
        }
        self.alike = known.alike;
    }

    /// Surveys the scene and assembles the rows that its stencil does not describe. Ranks are sites.
    pub fn assemble(&self, problem: &Problem) -> (Survey, SomeRows) {
        let identity: Vec<u32>;
        let order = match &self.lattice.order {
            Some(order) => order,
            None => {
                identity = (0..self.particles as u32).collect();
                &identity
            }
        };
        let neighbors = |site: u32, out: &mut Vec<Neighbor>| {
            let [nx, ny, _] = self.lattice.counts;
            let site = site as usize;
            self.lattice.for_each(
                [site % nx, site / nx % ny, site / (nx * ny)],
                |steps, _, places| {
                    let [x, y, z] = places.map(|place| place.index);
                    let rank = ((z * ny + y) * nx + x) as u32;
                    let is_ghost = places.iter().any(|place| place.is_ghost);
                    if !is_ghost && order[rank as usize] != ABSENT {
                        let offset = DVec3::from_array(steps.map(|step| step as f64));
                        out.push(Neighbor { rank, dist: (problem.spacing * offset).length() });
                    }
                },
            );
        };
        let (mut survey, rows) = SomeRows::assemble(problem, order, &self.visits, neighbors);
        self.alike.iter().for_each(|alike| self.lattice.note(problem, alike, &mut survey));
        (survey.with_sources(problem), rows)
    }

    /// How many times the diffusivity of the stencil that of a material is.
    pub fn ratio(&self, material: &Material) -> f64 {
        material.diffusivity() / self.base
    }

    /// Bytes that it holds, but for the order of its lattice.
    pub fn memory_bytes(&self) -> usize {
        let by_range = size_of_val(&*self.ratios) + size_of_val(&*self.absent);
        by_range + size_of_val(&*self.visits) + size_of_val(&*self.alike)
    }

    /// How many particles have rows of their own.
    pub fn rows(&self) -> usize {
        self.visits.iter().filter(|visit| visit.whole).count()
    }

    /// The first site with a row of its own: a diagnostic.
    pub fn first_row(&self) -> Option<u32> {
        self.visits.iter().find(|visit| visit.whole).map(|visit| visit.rank)
    }

    /// How much of the box particles fill.
    pub fn filled(&self) -> f64 {
        self.particles as f64 / sites_of(self.lattice.counts) as f64
    }
}

/// A particle of the largest diffusivity.
fn fastest(problem: &Problem) -> usize {
    let diffusivity =
        |a: usize| problem.materials[usize::from(problem.particles.material[a])].diffusivity();
    let larger = |a: usize, b: usize| if diffusivity(b) > diffusivity(a) { b } else { a };
    (1..problem.particles.len()).fold(0, larger)
}

/// The sites without rows of their own, as they are found.
struct Known {
    alike: Vec<Alike>,
    /// Where in that those of one kind at one kind of place are.
    index: HashMap<([usize; 3], u16), usize>,
    /// The last of these.
    last: Option<(([usize; 3], u16), usize)>,
    /// By axis: the kind of each place.
    place: [Vec<usize>; 3],
}

impl Known {
    fn new(lattice: &LatticeScene) -> Self {
        let kind = |axis: usize| {
            let places = 0..lattice.counts[axis];
            places.map(|place| lattice.kind_of_place(axis, place)).collect()
        };
        let place = [0, 1, 2].map(kind);
        Self { alike: Vec::new(), index: HashMap::new(), last: None, place }
    }

    /// Adds a site of this kind; returns those that it is like.
    fn add(
        &mut self,
        problem: &Problem,
        scene: &MixedScene,
        site: usize,
        at: [usize; 3],
        kind: u16,
    ) -> &Alike {
        let key = ([0, 1, 2].map(|axis| self.place[axis][at[axis]]), kind);
        let index = match self.last {
            Some((last, index)) if last == key => index,
            _ => *self.index.entry(key).or_insert_with(|| {
                let mass = problem.mass(scene.lattice.particle(site));
                let ratio = scene.ratio(&problem.materials[usize::from(kind)]);
                self.alike.push(Alike { at, count: 0, free: true, mass, ratio });
                self.alike.len() - 1
            }),
        };
        self.last = Some((key, index));
        self.alike[index].count += 1;
        &self.alike[index]
    }
}
