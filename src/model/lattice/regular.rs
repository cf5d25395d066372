//! Which sites of a lattice have the stencil for their row.

use glam::DVec3;
use rayon::prelude::*;

use super::scene::{end, is_cooled, whole};
use super::{ABSENT, Edge, End, LatticeScene};
use crate::model::operator::PairWeight;
use crate::model::wall::WalledFace;
use crate::model::{Face, Problem};

/// The kind of a site without a particle.
pub(super) const NOTHING: u16 = u16::MAX;

/// What lies past the ends of each axis as far as the stencil knows it, and the faces that it does
/// not know: sites within their reach need rows of their own.
pub(super) struct Ends {
    pub(super) edges: [Edge; 3],
    odd: Vec<Face>,
}

impl Ends {
    /// The ends of `problem`. Faces with patches and those between the sites are odd; so is
    /// convection between several diffusivities or where another face is free or odd.
    pub(super) fn of(problem: &Problem, weight: &PairWeight<'_>, reach: usize) -> Self {
        let of_face = |face: Face| {
            let whole = whole(problem.domain.extent()[face.axis] / problem.spacing);
            end(problem, weight, face, reach).ok().filter(|end| whole || *end == End::Free)
        };
        let open = |face: &Face| !problem.domain.periodic[face.axis];
        let faces = Face::all(problem.dimension).filter(open);
        let mut ends: Vec<(Face, Option<End>)> = faces.map(|face| (face, of_face(face))).collect();
        let is_plain = |end: &Option<End>| matches!(end, Some(End::Mirror(_)));
        if has_several(problem) || !ends.iter().all(|(_, end)| is_plain(end)) {
            let cooled = ends.iter_mut().filter(|(face, _)| is_cooled(problem, *face));
            cooled.for_each(|(_, end)| *end = None);
        }
        let known = |axis: usize, upper: bool| {
            let found = ends.iter().find(|(face, _)| *face == Face { axis, upper });
            found.and_then(|(_, end)| end.clone()).unwrap_or(End::Free)
        };
        let edge = |axis: usize| match axis >= problem.dimension || problem.domain.periodic[axis] {
            true => Edge::Periodic,
            false => Edge::Open([known(axis, false), known(axis, true)]),
        };
        let odd = ends.iter().filter(|(_, end)| end.is_none()).map(|(face, _)| *face).collect();
        Self { edges: [0, 1, 2].map(edge), odd }
    }
}

/// Whether particles differ in conductivity or capacity.
fn has_several(problem: &Problem) -> bool {
    let flows = |m: &u16| {
        let material = &problem.materials[usize::from(*m)];
        (material.conductivity, material.capacity)
    };
    let first = problem.particles.material.first().map(flows);
    !problem.particles.material.par_iter().all(|m| Some(flows(m)) == first)
}

/// The sites near faces.
pub(super) struct Near {
    /// By axis and place: whether an odd face reaches.
    odd: [Vec<bool>; 3],
    /// By axis and place: whether any walled face reaches.
    wall: [Vec<bool>; 3],
}

impl Near {
    pub(super) fn of(problem: &Problem, counts: [usize; 3], ends: &Ends) -> Self {
        let walled = WalledFace::all(&problem.walls, problem.dimension);
        let walled: Vec<Face> = walled.iter().map(WalledFace::face).collect();
        let near = |faces: &[Face]| {
            [0, 1, 2].map(|axis| {
                let along = |face: &&Face| face.axis == axis && !problem.domain.periodic[axis];
                let at = |place: usize| {
                    let x = problem.domain.min
                        + DVec3::AXES[axis] * (place as f64 + 0.5) * problem.spacing;
                    // A little further, for what rounding does to a site on the border.
                    let reach = problem.kernel.cutoff() + 0.01 * problem.spacing;
                    let is_near = |face: &Face| face.distance(&problem.domain, x) < reach;
                    faces.iter().filter(along).any(is_near)
                };
                (0..counts[axis]).map(at).collect()
            })
        };
        Self { odd: near(&ends.odd), wall: near(&walled) }
    }

    pub(super) fn odd(&self, [x, y, z]: [usize; 3]) -> bool {
        self.odd[0][x] || self.odd[1][y] || self.odd[2][z]
    }

    pub(super) fn wall(&self, [x, y, z]: [usize; 3]) -> bool {
        self.wall[0][x] || self.wall[1][y] || self.wall[2][z]
    }
}

/// What is at each site: the first material of the same diffusivity and density, or [`NOTHING`].
pub(super) fn kinds(problem: &Problem, lattice: &LatticeScene) -> Vec<u16> {
    let properties = |m: u16| {
        let material = &problem.materials[usize::from(m)];
        (material.conductivity, material.capacity, material.density)
    };
    let count = problem.materials.len() as u16;
    // Where contacts resist, also materials of the same properties are to be told apart.
    let alike = |a: u16, b: u16| problem.contacts.is_empty() && properties(a) == properties(b);
    let same = |m: u16| (0..m).find(|&other| alike(other, m)).unwrap_or(m);
    let kind: Vec<u16> = (0..count).map(same).collect();
    let of_particle = |&particle: &u32| match particle {
        ABSENT => NOTHING,
        _ => kind[usize::from(problem.particles.material[particle as usize])],
    };
    match &lattice.order {
        Some(order) => order.par_iter().map(of_particle).collect(),
        None => problem.particles.material.par_iter().map(|&m| kind[usize::from(m)]).collect(),
    }
}

/// Whether the row of each site is the stencil times a factor: it has a particle, every place of its
/// stencil has one of the same kind or is past an end that the stencil knows, and neither an odd
/// face nor a surface reaches it.
pub(super) fn regular(
    problem: &Problem,
    lattice: &LatticeScene,
    kinds: &[u16],
    near: &Near,
) -> Vec<bool> {
    let [nx, ny, _] = lattice.counts;
    let alike: Vec<u8> = kinds.par_chunks(nx).flat_map_iter(|line| alike(line, lattice)).collect();
    let cutoff = problem.kernel.cutoff();
    let is_reached = |site: usize| {
        let x = problem.particles.position[lattice.particle(site)];
        problem.surfaces.iter().any(|surface| surface.distance(x) < cutoff)
    };
    let mut regular = vec![true; kinds.len()];
    regular.par_chunks_mut(nx).enumerate().for_each(|(line, regular)| {
        let (y, z) = (line % ny, line / ny);
        let own = &kinds[line * nx..][..nx];
        for (x, regular) in regular.iter_mut().enumerate() {
            *regular = own[x] != NOTHING && !near.odd([x, y, z]);
        }
        for class in &lattice.classes {
            let reach = (class.weights.len() - 1) as u8;
            for &[step_y, step_z] in &class.lines {
                let y = lattice.edges[1].at(y as isize + step_y, lattice.counts[1]);
                let z = lattice.edges[2].at(z as isize + step_z, lattice.counts[2]);
                let (Some(y), Some(z)) = (y, z) else {
                    continue;
                };
                let there = (z.index * ny + y.index) * nx;
                let (kind, alike) = (&kinds[there..][..nx], &alike[there..][..nx]);
                for x in 0..nx {
                    regular[x] &= kind[x] == own[x] && alike[x] >= reach;
                }
            }
        }
        if !problem.surfaces.is_empty() {
            for (x, regular) in regular.iter_mut().enumerate().filter(|(_, regular)| **regular) {
                *regular = !is_reached(line * nx + x);
            }
        }
    });
    regular
}

/// How many steps to either side along a line the kind is the same, at most the reach. What lies
/// past an open end is a mirror image of what is nearer, or nothing.
fn alike<'a>(line: &'a [u16], lattice: &'a LatticeScene) -> impl Iterator<Item = u8> + 'a {
    let count = line.len() as isize;
    let is_periodic = lattice.edges[0] == Edge::Periodic;
    let kind = move |place: isize| match (0..count).contains(&place) {
        true => Some(line[place as usize]),
        false => is_periodic.then(|| line[place.rem_euclid(count) as usize]),
    };
    (0..count).map(move |x| {
        let own = line[x as usize];
        let same =
            |step: &isize| [x - step, x + step].iter().all(|&p| kind(p).is_none_or(|k| k == own));
        (1..=lattice.reach as isize).take_while(same).count() as u8
    })
}
