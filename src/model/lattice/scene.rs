//! Box lattices with a stencil, and the scenes that are one all over: their particles fill the box.

use glam::DVec3;
use rayon::prelude::*;

use super::{Edge, End, for_each_neighbor};
use crate::model::operator::{FoldNeeds, PairWeight};
use crate::model::wall::WalledFace;
use crate::model::{Face, Problem, Wall, WallKind};

/// A particle this close to its site (in spacings) is on it: far from the origin, positions are
/// rounded more.
pub(super) const ON_SITE: f64 = 1e-6;

/// The same where walls act: what they add is computed from the positions themselves, and has to
/// cancel with the stencil's.
pub(super) const ON_SITE_BY_WALLS: f64 = 1e-9;

/// Relative error of a count of spacings.
const WHOLE: f64 = 1e-9;

/// The widest reach of a stencil, in sites. A wider one has so many entries that it is no faster than
/// a list.
pub const WIDEST: usize = 4;

/// A site without a particle, in [`LatticeScene::order`].
pub const ABSENT: u32 = u32::MAX;

/// A box of sites with the stencil of one material: counts, order, edges and weights.
///
/// As a scene by itself every site has a particle of that material; in a [`super::MixedScene`] some may
/// have none or one of another.
#[derive(Clone, Debug)]
pub struct LatticeScene {
    /// 1, 2 or 3.
    pub dimension: usize,
    /// Particles along each axis; 1 along axes past the dimension.
    pub counts: [usize; 3],
    /// The particle at each site, x fastest, or [`ABSENT`]; `None` where that is the order of the
    /// particles.
    pub order: Option<Vec<u32>>,
    /// What lies past the ends of each axis.
    pub edges: [Edge; 3],
    /// How many sites the stencil reaches along an axis.
    pub reach: usize,
    /// The stencil, line by line.
    pub classes: Vec<LineClass>,
}

/// The lines of a stencil, parallel to x, that share their weights.
#[derive(Clone, Debug, PartialEq)]
pub struct LineClass {
    /// Sites to each line along y and z.
    pub lines: Vec<[isize; 2]>,
    /// Weight (1/s) of the sites |i| along x, for i from 0; that of the particle itself is 0.
    pub weights: Vec<f64>,
}

impl LatticeScene {
    /// The scene as a lattice.
    ///
    /// # Errors
    /// Why it is none, in words.
    pub fn of(problem: &Problem) -> Result<Self, &'static str> {
        let counts = counts(problem, |_| true)?;
        if problem.particles.len() != sites_of(counts) {
            return Err("the particles do not fill the box around them");
        }
        check_volume(problem)?;
        check_material(problem)?;
        if !problem.contacts.is_empty() {
            return Err("materials meet with a contact resistance");
        }
        if !problem.surfaces.is_empty() {
            return Err("a surface that is no face of the domain acts on it");
        }
        let allowed = match FoldNeeds::of_walls(problem) {
            FoldNeeds::None | FoldNeeds::Insulated => ON_SITE,
            FoldNeeds::Steady | FoldNeeds::Changing => ON_SITE_BY_WALLS,
        };
        let order = order(problem, counts, allowed)?;
        let weight = PairWeight::new(problem);
        let (reach, classes) = stencil(problem, &weight, 0)?;
        let edges = edges(problem, &weight, reach)?;
        Ok(Self { dimension: problem.dimension, counts, order, edges, reach, classes })
    }

    /// The site of each particle, as a function.
    pub fn sites(&self) -> impl Fn(u32) -> u32 + use<> {
        let sites = self.order.as_ref().map(|order| {
            let mut sites = vec![0; present(order).count()];
            for (site, particle) in present(order) {
                sites[particle] = site as u32;
            }
            sites
        });
        move |particle| sites.as_ref().map_or(particle, |sites| sites[particle as usize])
    }

    /// The place of a site along each axis.
    pub(crate) fn at(&self, site: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        let line = site / nx;
        [site - line * nx, line % ny, line / ny]
    }

    /// The particle at a site that has one.
    pub fn particle(&self, site: usize) -> usize {
        self.order.as_ref().map_or(site, |order| order[site] as usize)
    }

    /// The material of `problem` that is at a site, if there is a particle.
    pub fn material(&self, problem: &Problem, site: usize) -> Option<u16> {
        // There are fewer particles than the number of an absent one.
        problem.particles.material.get(self.particle(site)).copied()
    }

    /// The sites of particles `held`, ascending.
    pub fn held_sites(&self, held: &[u32]) -> Vec<u32> {
        let site = self.sites();
        let mut sites: Vec<u32> = held.iter().map(|&particle| site(particle)).collect();
        sites.sort_unstable();
        sites
    }

    /// A field from the problem's order to that of the sites; 0 where there is no particle.
    pub fn by_site(&self, values: &[f64]) -> Vec<f64> {
        let Some(order) = &self.order else {
            return values.to_vec();
        };
        let mut out = vec![0.0; order.len()];
        present(order).for_each(|(site, particle)| out[site] = values[particle]);
        out
    }

    /// A field from the order of the sites to the problem's.
    pub fn by_particle(&self, values: &[f64]) -> Vec<f64> {
        let Some(order) = &self.order else {
            return values.to_vec();
        };
        let mut out = vec![0.0; present(order).count()];
        present(order).for_each(|(site, particle)| out[particle] = values[site]);
        out
    }
}

/// The sites with a particle, and these.
fn present(order: &[u32]) -> impl Iterator<Item = (usize, usize)> {
    let site = |(site, &particle): (usize, &u32)| (site, particle as usize);
    order.iter().enumerate().filter(|(_, particle)| **particle != ABSENT).map(site)
}

/// How many sites there are.
pub(super) fn sites_of(counts: [usize; 3]) -> usize {
    counts.iter().fold(1, |n, &count| n.saturating_mul(count))
}

/// Sites along each axis, if the domain is a whole number of spacings along those that `is_whole`
/// names.
pub(super) fn counts(
    problem: &Problem,
    is_whole: impl Fn(usize) -> bool,
) -> Result<[usize; 3], &'static str> {
    let extent = problem.domain.extent();
    let mut counts = [1; 3];
    for axis in 0..problem.dimension {
        let count = extent[axis] / problem.spacing;
        if is_whole(axis) && !whole(count) || count < 0.5 {
            return Err("the domain is no whole number of spacings");
        }
        counts[axis] = (count + 0.5 + WHOLE * count) as usize;
    }
    Ok(counts)
}

/// Sites along each axis, and the particle at each site, [`ABSENT`] where there is none, or their own order;
/// `None` where particles are on no lattice.
pub fn sites_with_particles(problem: &Problem) -> Option<([usize; 3], Option<Vec<u32>>)> {
    let counts = counts(problem, |axis| problem.domain.periodic[axis]).ok()?;
    let order = order(problem, counts, ON_SITE).ok()?;
    Some((counts, order))
}

/// Whether an axis is a whole number of spacings.
pub(super) fn whole(count: f64) -> bool {
    (count - count.round()).abs() <= WHOLE * count
}

/// One volume, that of a site.
pub(super) fn check_volume(problem: &Problem) -> Result<(), &'static str> {
    let volume = problem.spacing.powi(problem.dimension as i32);
    let is_site = |v: &f64| (v / volume - 1.0).abs() < 1e-12;
    let same = problem.particles.volume.par_iter().all(is_site);
    if same { Ok(()) } else { Err("particles differ in volume") }
}

/// One diffusivity and one density.
fn check_material(problem: &Problem) -> Result<(), &'static str> {
    let particles = &problem.particles;
    let properties = |&m: &u16| {
        let material = &problem.materials[usize::from(m)];
        (material.conductivity, material.capacity, material.density)
    };
    let first = particles.material.first().map(properties);
    if !particles.material.par_iter().all(|m| Some(properties(m)) == first) {
        return Err("particles differ in conductivity, capacity or density");
    }
    Ok(())
}

/// The particle at each site, if all are within `allowed` spacings of theirs.
pub(super) fn order(
    problem: &Problem,
    counts: [usize; 3],
    allowed: f64,
) -> Result<Option<Vec<u32>>, &'static str> {
    let site = |x: &DVec3| -> Option<usize> {
        let mut index = 0;
        for axis in (0..3).rev() {
            let place = match axis < problem.dimension {
                true => (x[axis] - problem.domain.min[axis]) / problem.spacing - 0.5,
                false => 0.0,
            };
            let near = place.round();
            if (place - near).abs() > allowed || near < 0.0 || near >= counts[axis] as f64 {
                return None;
            }
            index = index * counts[axis] + near as usize;
        }
        Some(index)
    };
    let off = "a particle is not on its site of the lattice";
    let position = &problem.particles.position;
    let in_order = || position.par_iter().enumerate().all(|(k, x)| site(x) == Some(k));
    if position.len() == sites_of(counts) && in_order() {
        return Ok(None);
    }
    let mut order = vec![ABSENT; sites_of(counts)];
    for (particle, x) in (0..).zip(position) {
        let place = &mut order[site(x).ok_or(off)?];
        if *place != ABSENT {
            return Err("two particles are on one site of the lattice");
        }
        *place = particle;
    }
    Ok(Some(order))
}

/// The reach of the stencil around particle `a` in sites, and its lines. Lines at one distance share
/// their weights.
pub(super) fn stencil(
    problem: &Problem,
    weight: &PairWeight<'_>,
    a: usize,
) -> Result<(usize, Vec<LineClass>), &'static str> {
    let mut entries: Vec<([isize; 3], f64)> = Vec::new();
    for_each_neighbor(&problem.kernel, problem.spacing, |offset| {
        let steps = (offset / problem.spacing).to_array().map(|x| x.round() as isize);
        if steps[0] >= 0 {
            entries.push((steps, weight.of(a, a, offset.length())));
        }
    });
    let distance = |[_, y, z]: [isize; 3]| y * y + z * z;
    let mut distances: Vec<isize> = entries.iter().map(|(steps, _)| distance(*steps)).collect();
    distances.sort_unstable();
    distances.dedup();
    let class = |&squared: &isize| {
        let on = |entry: &&([isize; 3], f64)| distance(entry.0) == squared;
        let mut lines: Vec<[isize; 2]> =
            entries.iter().filter(on).map(|([_, y, z], _)| [*z, *y]).collect();
        lines.sort_unstable();
        lines.dedup();
        let reach = entries.iter().filter(on).map(|([x, ..], _)| *x as usize).max().unwrap_or(0);
        let mut weights = vec![0.0; reach + 1];
        for ([x, ..], weight) in entries.iter().filter(on) {
            weights[*x as usize] = *weight;
        }
        LineClass { lines: lines.into_iter().map(|[z, y]| [y, z]).collect(), weights }
    };
    let classes: Vec<LineClass> = distances.iter().map(class).collect();
    let reach = entries.iter().flat_map(|(steps, _)| steps.map(isize::unsigned_abs)).max();
    match reach.unwrap_or(0) {
        reach if reach > WIDEST => Err("the support reaches past four spacings"),
        reach => Ok((reach, classes)),
    }
}

/// What lies past the ends of each axis.
fn edges(
    problem: &Problem,
    weight: &PairWeight<'_>,
    reach: usize,
) -> Result<[Edge; 3], &'static str> {
    let end = |face| end(problem, weight, face, reach);
    let mut edges = [const { Edge::Periodic }; 3];
    for (axis, edge) in edges.iter_mut().enumerate().take(problem.dimension) {
        if !problem.domain.periodic[axis] {
            let face = |upper| Face { axis, upper };
            *edge = Edge::Open([end(face(false))?, end(face(true))?]);
        }
    }
    let is_free = |edge: &Edge| edge.is_free(false) || edge.is_free(true);
    let is_cooled = |face: Face| is_cooled(problem, face);
    if Face::all(problem.dimension).any(is_cooled) && edges.iter().any(is_free) {
        return Err("a convection wall meets a free face");
    }
    Ok(edges)
}

/// Whether a face, or a part of it, loses heat by convection.
pub(super) fn is_cooled(problem: &Problem, face: Face) -> bool {
    let is_convection = |wall: &Wall| wall.condition.kind == WallKind::Convection;
    problem.walls.iter().any(|wall| wall.face == face && is_convection(wall))
}

/// What lies past a face.
pub(super) fn end(
    problem: &Problem,
    weight: &PairWeight<'_>,
    face: Face,
    reach: usize,
) -> Result<End, &'static str> {
    let walled = WalledFace::all(&problem.walls, problem.dimension);
    let Some(walls) = walled.iter().find(|walled| walled.face() == face) else {
        return Ok(End::Free);
    };
    let Some(wall) = walls.only() else {
        return Err("a face has walls of several kinds, or on a part of it");
    };
    let condition = &wall.condition;
    if condition.coefficient.depends_on_position() {
        return Err("the coefficient of a convection wall depends on position");
    }
    let at = face.foot(&problem.domain, problem.domain.min);
    let factor = |layer: usize| {
        let distance = (layer as f64 + 0.5) * problem.spacing;
        condition.mirror(weight.conductivity(0, 0), distance, at).map(|mirror| mirror.scale)
    };
    let factors: Option<Vec<f64>> = (0..reach).map(factor).collect();
    Ok(factors.map_or(End::Free, End::Mirror))
}
