//! The wall fold: what ghosts behind walls add to a row of the matrix.
//!
//! A ghost of particle b behind some faces holds s C_b + c. Its pair with particle a, of weight w,
//! adds w (s C_b + c - C_a) to the rate of a, which is
//! w s (C_b - C_a) + w (s - 1) C_a + w c: more weight for the neighbour b, a diagonal, a source. A
//! ghost within the support has its particle within it too, so a row gets no new neighbours.
//!
//! Which wall a pair goes through is decided where the segment from the particle to the ghost
//! crosses the face; for a ghost behind several faces the crossing is mirrored back into the body.
//! The pair with both roles swapped crosses at the same points, so the matrix stays symmetric
//! beside patches of different kinds. The conductivity of a flux or convection wall is half the
//! pair's mean: with it a flux's total is exact between different materials too. What the wall
//! imposes is taken at the foot of the mirrored particle. Behind several faces the ghost is a
//! ghost's ghost: the mean over the orders of mirroring, each map at the foot of the ghost before
//! it, which may be outside of the body.
//!
//! Convection is the one kind that leaves the matrix unsymmetric where a support reaches past the
//! first layer: s depends on the distance of b alone.

use glam::DVec3;

use super::PairWeight;
use crate::model::Problem;
use crate::model::neighbors::Neighbor;
use crate::model::wall::{Condition, Face, Mirror, WalledFace};

/// The orders in which one, two or three faces can be mirrored.
const ORDERS: [&[&[usize]]; 3] = [
    &[&[0]],
    &[&[0, 1], &[1, 0]],
    &[&[0, 1, 2], &[0, 2, 1], &[1, 0, 2], &[1, 2, 0], &[2, 0, 1], &[2, 1, 0]],
];

/// A particle nearer than this fraction of the spacing to a surface lies on it.
const ON_SURFACE: f64 = 1e-9;

/// Beyond this, a surface is no longer smooth within a support.
const STRONGLY_CURVED: f64 = 0.4;

/// A part of a row's source that changes in time: `coefficient` x what is imposed at `foot`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Which wall or surface imposes it: an index into [`Problem::imposed`].
    pub imposed: usize,
    /// Where (m); 0 if it is the same everywhere.
    pub foot: DVec3,
    /// Factor, 1/s.
    pub coefficient: f64,
}

/// What walls and surfaces add to a row.
#[derive(Clone, Debug, Default)]
pub struct RowFold {
    /// What each neighbour's weight gets, 1/s, in the order of the neighbours.
    pub weight: Vec<f64>,
    /// Factor of the row's own value, 1/s.
    pub diagonal: f64,
    /// Twice the antisymmetric part of the weights, 1/s: -sum_b w_ab (s_ab - s_ba).
    pub skew: f64,
    /// The part of the source that does not change, 1/s x the value's unit.
    pub source: f64,
    /// The part of the source that does.
    pub changing: Vec<Term>,
    /// Whether anything but insulation acts here.
    pub acts: bool,
    /// What imposes a value that is not finite, and where (m), if anything does.
    pub not_finite: Option<(usize, DVec3)>,
}

impl RowFold {
    fn clear(&mut self, neighbors: usize) {
        self.weight.clear();
        self.weight.resize(neighbors, 0.0);
        self.changing.clear();
        (self.diagonal, self.skew, self.source) = (0.0, 0.0, 0.0);
        (self.acts, self.not_finite) = (false, None);
    }
}

/// Folds the walls and surfaces of a scene into rows.
pub struct Fold<'a> {
    problem: &'a Problem,
    weight: &'a PairWeight<'a>,
    faces: Vec<WalledFace<'a>>,
    /// [`crate::model::Kernel::crossing_moment`], where there are surfaces.
    crossing_moment: f64,
}

/// The faces behind which a ghost lies, by axis.
type Image = [Option<Face>; 3];

/// One passage of a pair through a wall.
struct Passage {
    face: Face,
    /// Index of the wall.
    wall: usize,
    /// What the wall makes of the neighbour's value.
    of_neighbor: Mirror,
    /// What it would make of the row's own value in the swapped pair.
    of_row: Mirror,
}

impl<'a> Fold<'a> {
    /// The fold of `problem`, whose pairs have the weights `weight`; `None` if it has no wall but
    /// free ones, and no surface.
    pub fn new(problem: &'a Problem, weight: &'a PairWeight<'a>) -> Option<Self> {
        let faces = WalledFace::all(&problem.walls, problem.dimension);
        let acts = !faces.is_empty() || !problem.surfaces.is_empty();
        let crossing_moment = match problem.surfaces.is_empty() {
            true => 0.0,
            false => problem.kernel.crossing_moment(),
        };
        acts.then_some(Self { problem, weight, faces, crossing_moment })
    }

    /// Whether a ghost or a surface may be within the support of a particle at `x` (m).
    pub fn reaches(&self, x: DVec3) -> bool {
        let cutoff = self.problem.kernel.cutoff();
        let near =
            |walled: &WalledFace<'_>| walled.face().distance(&self.problem.domain, x) < cutoff;
        let on_surface = || self.problem.surfaces.iter().any(|s| s.foot(x, cutoff).is_some());
        self.faces.iter().any(near) || on_surface()
    }

    /// Writes what row `a` gets into `row`. `neighbors` are all particles within its support, as
    /// ranks of `order`. Nothing is written and `false` returned where nothing reaches.
    pub fn of_row(
        &self,
        a: usize,
        neighbors: &[Neighbor],
        order: &[u32],
        row: &mut RowFold,
    ) -> bool {
        if !self.reaches(self.problem.particles.position[a]) {
            return false;
        }
        row.clear(neighbors.len());
        let mut gradient = DVec3::ZERO;
        let images = self.images(a);
        for (k, neighbor) in neighbors.iter().enumerate() {
            let b = order[neighbor.rank as usize] as usize;
            gradient += self.kernel_gradient(b, neighbor.dist, self.separation(a, b));
            for image in &images {
                row.weight[k] += self.ghost(a, b, image, row, &mut gradient);
            }
        }
        for image in &images {
            self.ghost(a, a, image, row, &mut gradient);
        }
        self.surfaces(a, gradient, row);
        true
    }

    /// The images within whose reach particle `a` is.
    fn images(&self, a: usize) -> Vec<Image> {
        let x = self.problem.particles.position[a];
        let cutoff = self.problem.kernel.cutoff();
        let mut images: Vec<Image> = vec![[None; 3]];
        for axis in 0..self.problem.dimension {
            let before = images.clone();
            for walled in self.faces.iter().filter(|walled| walled.face().axis == axis) {
                if walled.face().distance(&self.problem.domain, x) < cutoff {
                    images.extend(before.iter().map(|image| {
                        let mut image = *image;
                        image[axis] = Some(walled.face());
                        image
                    }));
                }
            }
        }
        images.split_off(1)
    }

    /// From particle `a` to the nearest image of `b`, m.
    fn separation(&self, a: usize, b: usize) -> DVec3 {
        let position = &self.problem.particles.position;
        self.problem.domain.nearest_image(position[b] - position[a])
    }

    /// V_b grad W_ab over the lattice's moment, with `separation` from a to b.
    fn kernel_gradient(&self, b: usize, dist: f64, separation: DVec3) -> DVec3 {
        if self.problem.surfaces.is_empty() || dist == 0.0 {
            return DVec3::ZERO;
        }
        let slope = self.problem.kernel.dw_over_r(dist) / self.weight.lattice_ratio();
        -self.problem.particles.volume[b] * slope * separation
    }

    /// Adds the pair of `a` with the ghost of `b` behind `image` to the row; returns what the
    /// weight of the neighbour b gets.
    fn ghost(
        &self,
        a: usize,
        b: usize,
        image: &Image,
        row: &mut RowFold,
        gradient: &mut DVec3,
    ) -> f64 {
        let problem = self.problem;
        let distance = |face: Face, particle: usize| {
            face.distance(&problem.domain, problem.particles.position[particle])
        };
        let mut to_ghost = self.separation(a, b);
        for face in image.iter().flatten() {
            let apart = distance(*face, a) + distance(*face, b);
            to_ghost[face.axis] = if face.upper { apart } else { -apart };
        }
        let dist = to_ghost.length();
        if dist >= problem.kernel.cutoff() {
            return 0.0;
        }
        let Some(passages) = self.passages(a, b, image, to_ghost) else {
            return 0.0;
        };
        *gradient += self.kernel_gradient(b, dist, to_ghost);
        let weight = self.weight.of(a, b, dist);
        let scale: f64 = passages.iter().map(|passage| passage.of_neighbor.scale).product();
        let swapped: f64 = passages.iter().map(|passage| passage.of_row.scale).product();
        row.diagonal += weight * (scale - 1.0);
        // Between two held particles nothing is exchanged.
        if scale != swapped && !(problem.is_held(a) && problem.is_held(b)) {
            row.skew -= weight * (scale - swapped);
        }
        self.sources(b, weight, &passages, row);
        weight * scale
    }

    /// The walls that a pair goes through, by axis; `None` where one of them is free.
    fn passages(&self, a: usize, b: usize, image: &Image, to_ghost: DVec3) -> Option<Vec<Passage>> {
        let position = &self.problem.particles.position;
        let domain = &self.problem.domain;
        let conductivity = self.weight.conductivity(a, b);
        let mut passages = Vec::with_capacity(3);
        for &face in image.iter().flatten() {
            let [from, to] = [a, b].map(|particle| face.distance(domain, position[particle]));
            let share = if from + to > 0.0 { from / (from + to) } else { 0.5 };
            let crossing = self.inside(face.foot(domain, position[a] + share * to_ghost), image);
            let walled = self.faces.iter().find(|walled| walled.face() == face)?;
            let (index, wall) = walled.at(crossing)?;
            let mirror = |distance| wall.condition.mirror(conductivity, distance, crossing);
            let (of_neighbor, of_row) = (mirror(to)?, mirror(from)?);
            passages.push(Passage { face, wall: index, of_neighbor, of_row });
        }
        Some(passages)
    }

    /// A point on a face, mirrored back at the other faces of `image` and wrapped round periodic
    /// axes.
    fn inside(&self, mut point: DVec3, image: &Image) -> DVec3 {
        let domain = &self.problem.domain;
        for face in image.iter().flatten() {
            if face.distance(domain, point) < 0.0 {
                point = face.mirrored(domain, point);
            }
        }
        for axis in 0..self.problem.dimension {
            let (min, extent) = (domain.min[axis], domain.extent()[axis]);
            if domain.periodic[axis] {
                point[axis] -= extent * ((point[axis] - min) / extent).floor();
            }
        }
        point
    }

    /// Adds the source of a pair with the ghost of `b`: weight x c, with c the mean over the orders
    /// of mirroring.
    fn sources(&self, b: usize, weight: f64, passages: &[Passage], row: &mut RowFold) {
        let domain = &self.problem.domain;
        row.acts |= passages
            .iter()
            .any(|passage| passage.of_neighbor != (Mirror { scale: 1.0, offset: 0.0 }));
        let orders = ORDERS[passages.len() - 1];
        for order in orders {
            let mut point = self.problem.particles.position[b];
            for (step, &k) in order.iter().enumerate() {
                let Passage { face, wall, of_neighbor, .. } = &passages[k];
                // What later mirrors make of this one's part.
                let later =
                    order[step + 1..].iter().map(|&later| passages[later].of_neighbor.scale);
                let coefficient = weight * of_neighbor.offset * later.product::<f64>();
                if coefficient != 0.0 {
                    let condition = &self.problem.walls[*wall].condition;
                    let foot = face.foot(domain, point);
                    add_source(row, condition, *wall, foot, coefficient / orders.len() as f64);
                }
                point = face.mirrored(domain, point);
            }
        }
    }

    /// By what the total that enters through a surface with this divergence of its normal (1/m)
    /// differs from flux x area. Near an edge the divergence means nothing.
    fn curved(&self, divergence: f64) -> f64 {
        let excess = self.crossing_moment * divergence;
        if excess.abs() < STRONGLY_CURVED { 1.0 + excess } else { 1.0 }
    }

    /// Adds what enters through surfaces: 2 q n . `gradient`, with the gradient summed over the
    /// support.
    fn surfaces(&self, a: usize, gradient: DVec3, row: &mut RowFold) {
        let problem = self.problem;
        let x = problem.particles.position[a];
        for (k, surface) in problem.surfaces.iter().enumerate() {
            let Some(foot) = surface.foot(x, problem.kernel.cutoff()) else {
                continue;
            };
            let depth = x.distance(foot);
            let on_surface = depth <= ON_SURFACE * problem.spacing;
            let inward = if on_surface { gradient } else { x - foot }.normalize_or_zero();
            let conductivity = self.weight.conductivity(a, a);
            let Some(inflow) = surface.condition.inflow(conductivity, depth, foot) else {
                continue;
            };
            let reach = problem.kernel.support_radius();
            let divergence = surface.divergence(foot, inward, reach, problem.dimension);
            let spread = 2.0 * inward.dot(gradient) / self.curved(divergence);
            row.acts = true;
            row.diagonal -= spread * inflow.loss;
            let imposed = problem.walls.len() + k;
            add_source(row, &surface.condition, imposed, foot, spread * inflow.gain);
        }
    }
}

/// Adds `coefficient` x what `condition` imposes at `foot`: at once, or as a term where it changes.
fn add_source(
    row: &mut RowFold,
    condition: &Condition,
    imposed: usize,
    foot: DVec3,
    coefficient: f64,
) {
    let field = &condition.imposed;
    if field.depends_on_time() {
        let foot = if field.depends_on_position() { foot } else { DVec3::ZERO };
        row.changing.push(Term { imposed, foot, coefficient });
        return;
    }
    let value = field.at(foot, 0.0);
    if !value.is_finite() {
        row.not_finite = Some((imposed, foot));
    }
    row.source += coefficient * value;
}

#[cfg(test)]
#[path = "fold_tests.rs"]
mod tests;
