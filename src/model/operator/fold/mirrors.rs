//! Ghosts behind walls on faces.
//!
//! A ghost of particle b behind some faces holds s C_b + c. Its pair with particle a, of weight w,
//! adds w (s C_b + c - C_a) to the rate of a, which is
//! w s (C_b - C_a) + w (s - 1) C_a + w c: more weight for the neighbour b, a diagonal, a source. A
//! ghost within the support has its particle within it too, so a row gets no new neighbours.
//!
//! Which wall a pair goes through is decided where the segment from the particle to the ghost
//! crosses the face; for a ghost behind several faces the crossing is mirrored back into the body.
//! The pair with both roles swapped crosses at the same points, so the matrix stays symmetric
//! beside patches of different kinds. A pair that crosses on the edge of a patch belongs to both
//! sides in equal parts. The conductivity of a flux or convection wall is half the pair's mean: with
//! it a flux's total is exact between different materials too.
//!
//! What the wall imposes is taken at the foot of the mirrored particle. Behind several faces the
//! ghost is a ghost's ghost: the mean over the orders of mirroring, each map at the foot of the
//! ghost before it, which may be outside of the body. Behind insulation the foot stays inside: what
//! is imposed goes on there as the value does.
//!
//! A free face has no ghosts. Where it meets a flux or convection wall, what enters through the
//! wall by the ghosts that are missing behind both still enters: a flux is imposed in full.

use glam::DVec3;

use super::{PairWeight, RowFold};
use crate::model::Problem;
use crate::model::neighbors::Neighbor;
use crate::model::wall::{Face, Mirror, WalledFace};

/// The orders in which one, two or three faces can be mirrored.
const ORDERS: [&[&[usize]]; 3] = [
    &[&[0]],
    &[&[0, 1], &[1, 0]],
    &[&[0, 1, 2], &[0, 2, 1], &[1, 0, 2], &[1, 2, 0], &[2, 0, 1], &[2, 1, 0]],
];

/// Patches are looked up this fraction of the spacing beside a crossing, on either side along every
/// axis: more than what counts as the edge itself, and far less than anything that matters.
const BESIDE: f64 = 1e-6;

/// What an insulated wall makes of a value; a free face is taken for one where only what enters
/// through other walls counts.
const UNCHANGED: Mirror = Mirror { scale: 1.0, offset: 0.0 };

/// The ghosts of a scene.
pub(super) struct Mirrors<'a> {
    problem: &'a Problem,
    weight: &'a PairWeight<'a>,
    faces: Vec<WalledFace<'a>>,
    /// Whether something enters through a wall by a flux, so that free faces beside it matter.
    by_flux: bool,
}

/// The faces behind which a ghost lies, by axis.
type Image = [Option<Face>; 3];

/// One passage of a pair through a face.
struct Passage {
    face: Face,
    /// Index of the wall; none on a free part.
    wall: Option<usize>,
    /// Whether what is imposed is a flux, or a law for one.
    by_flux: bool,
    /// What the wall makes of the neighbour's value.
    of_neighbor: Mirror,
    /// What it would make of the row's own value in the swapped pair.
    of_row: Mirror,
}

/// A pair of a particle with the ghost of another.
struct GhostPair<'a> {
    a: usize,
    b: usize,
    image: &'a Image,
    /// From the particle to the ghost, m.
    to_ghost: DVec3,
    /// w, 1/s.
    weight: f64,
}

impl<'a> Mirrors<'a> {
    pub(super) fn new(
        problem: &'a Problem,
        weight: &'a PairWeight<'a>,
        faces: Vec<WalledFace<'a>>,
    ) -> Self {
        let is_flux = |wall: &crate::model::Wall| wall.condition.kind.has_inflow();
        let by_flux = problem.walls.iter().any(is_flux);
        Self { problem, weight, faces, by_flux }
    }

    /// Whether a ghost may be within the support of a particle at `x` (m).
    pub(super) fn reach(&self, x: DVec3) -> bool {
        self.faces.iter().any(|walled| self.is_near(walled.face(), x))
    }

    fn is_near(&self, face: Face, x: DVec3) -> bool {
        face.distance(&self.problem.domain, x) < self.problem.kernel.cutoff()
    }

    /// Adds the ghosts of the neighbours of particle `a`, and its own, to its row.
    pub(super) fn fold(&self, a: usize, neighbors: &[Neighbor], order: &[u32], row: &mut RowFold) {
        for image in &self.images(self.problem.particles.position[a]) {
            for (k, neighbor) in neighbors.iter().enumerate() {
                let b = order[neighbor.rank as usize] as usize;
                row.weight[k] += self.ghost(a, b, image, row);
            }
            self.ghost(a, a, image, row);
        }
    }

    /// The images within whose reach a particle at `x` (m) is: at least one face is walled.
    fn images(&self, x: DVec3) -> Vec<Image> {
        let open = |face: &Face| !self.problem.domain.periodic[face.axis];
        let mut images: Vec<Image> = vec![[None; 3]];
        for face in Face::all(self.problem.dimension).filter(open) {
            if self.is_near(face, x) && (self.is_walled(face) || self.by_flux) {
                let before = images.iter().filter(|image| image[face.axis].is_none());
                let with_face = |image: &Image| {
                    let mut image = *image;
                    image[face.axis] = Some(face);
                    image
                };
                let more: Vec<Image> = before.map(with_face).collect();
                images.extend(more);
            }
        }
        images.retain(|image| image.iter().flatten().any(|&face| self.is_walled(face)));
        images
    }

    /// Adds the pair of `a` with the ghost of `b` behind `image` to the row; returns what the
    /// weight of the neighbour b gets.
    fn ghost(&self, a: usize, b: usize, image: &Image, row: &mut RowFold) -> f64 {
        let Problem { domain, particles, kernel, .. } = self.problem;
        let [at_a, at_b] = [a, b].map(|particle| particles.position[particle]);
        let mut to_ghost = domain.nearest_image(at_b - at_a);
        for face in image.iter().flatten() {
            let apart = face.distance(domain, at_a) + face.distance(domain, at_b);
            to_ghost[face.axis] = if face.upper { apart } else { -apart };
        }
        let dist = to_ghost.length();
        if dist >= kernel.cutoff() {
            return 0.0;
        }
        // A face between cells that reaches the wall is crossed on the way to the ghost as well.
        let weight = self.weight.between(a, b, dist);
        let beside = self.beside(image);
        let pair = GhostPair { a, b, image, to_ghost, weight: weight / beside.len() as f64 };
        beside.iter().map(|&beside| self.passed(&pair, beside, row)).sum()
    }

    /// Where the walls of a pair are looked up, from its crossing, m.
    fn beside(&self, image: &Image) -> Vec<DVec3> {
        let has_patches = |walled: &WalledFace<'_>| {
            image[walled.face().axis] == Some(walled.face()) && walled.has_patches()
        };
        if !self.faces.iter().any(has_patches) {
            return vec![DVec3::ZERO];
        }
        let offset = BESIDE * self.problem.spacing;
        let sign = |bits: usize, axis: usize| if bits >> axis & 1 == 0 { -offset } else { offset };
        let corner = |bits: usize| DVec3::from_array([0, 1, 2].map(|axis| sign(bits, axis)));
        (0..1 << self.problem.dimension).map(corner).collect()
    }

    /// Adds a pair as it passes the walls `beside` (m) its crossings; returns what the weight of
    /// the neighbour gets.
    fn passed(&self, pair: &GhostPair<'_>, beside: DVec3, row: &mut RowFold) -> f64 {
        let passages = self.passages(pair, beside);
        let conducts = passages.iter().all(|passage| passage.wall.is_some());
        let of_fluxes = || {
            let counts = |p: &Passage| p.by_flux || p.of_neighbor == UNCHANGED;
            passages.iter().any(|p| p.by_flux) && passages.iter().all(counts)
        };
        if !(conducts || of_fluxes()) {
            return 0.0;
        }
        let scale: f64 = passages.iter().map(|passage| passage.of_neighbor.scale).product();
        let swapped: f64 = passages.iter().map(|passage| passage.of_row.scale).product();
        row.diagonal += pair.weight * (scale - 1.0);
        // Between two held particles nothing is exchanged.
        let held = self.problem.is_held(pair.a) && self.problem.is_held(pair.b);
        if scale != swapped && !held {
            row.skew -= pair.weight * (scale - swapped);
        }
        row.acts |= passages.iter().any(|passage| passage.of_neighbor != UNCHANGED);
        self.sources(pair, &passages, row);
        // Without conduction only w (s - 1) C_b of w (s C_b - C_a) is left.
        pair.weight * if conducts { scale } else { scale - 1.0 }
    }

    /// The faces that a pair goes through, by axis, and the walls there.
    fn passages(&self, pair: &GhostPair<'_>, beside: DVec3) -> Vec<Passage> {
        let Problem { domain, particles, .. } = self.problem;
        let conductivity = self.weight.conductivity_between(pair.a, pair.b);
        let passage = |&face: &Face| {
            let [from, to] = [pair.a, pair.b].map(|p| face.distance(domain, particles.position[p]));
            let share = if from + to > 0.0 { from / (from + to) } else { 0.5 };
            let crossing = particles.position[pair.a] + share * pair.to_ghost + beside;
            let crossing =
                self.folded(face.foot(domain, crossing), |f| pair.image.contains(&Some(f)));
            let walled = self.faces.iter().find(|walled| walled.face() == face);
            let wall = walled.and_then(|walled| walled.at(crossing.0));
            let mirrors = wall.and_then(|(_, wall)| {
                let mirror = |d| wall.condition.mirror(conductivity, d, crossing.0);
                Some([mirror(to)?, mirror(from)?])
            });
            let [of_neighbor, of_row] = mirrors.unwrap_or([UNCHANGED; 2]);
            let by_flux = wall.is_some_and(|(_, w)| w.condition.kind.has_inflow());
            let wall = wall.filter(|_| mirrors.is_some()).map(|(index, _)| index);
            Passage { face, wall, by_flux, of_neighbor, of_row }
        };
        pair.image.iter().flatten().map(passage).collect()
    }

    /// A point mirrored back at the faces for which `mirrors` holds and wrapped round periodic
    /// axes, and by axis -1 where it was mirrored and 1 elsewhere.
    pub(super) fn folded(
        &self,
        mut point: DVec3,
        mirrors: impl Fn(Face) -> bool,
    ) -> (DVec3, DVec3) {
        let domain = &self.problem.domain;
        let mut sign = DVec3::ONE;
        for face in Face::all(self.problem.dimension) {
            let (axis, extent) = (face.axis, domain.extent()[face.axis]);
            if domain.periodic[axis] {
                point[axis] -= extent * ((point[axis] - domain.min[axis]) / extent).floor();
            } else if face.distance(domain, point) < 0.0 && mirrors(face) {
                point = face.mirrored(domain, point);
                sign[axis] = -1.0;
            }
        }
        (point, sign)
    }

    /// Whether a face has walls with ghosts.
    pub(super) fn is_walled(&self, face: Face) -> bool {
        self.faces.iter().any(|walled| walled.face() == face)
    }

    /// Adds the source of a pair: weight x c, with c the mean over the orders of mirroring.
    fn sources(&self, pair: &GhostPair<'_>, passages: &[Passage], row: &mut RowFold) {
        let domain = &self.problem.domain;
        let orders = ORDERS[passages.len() - 1];
        let weight = pair.weight / orders.len() as f64;
        for order in orders {
            let mut point = self.problem.particles.position[pair.b];
            for (step, &k) in order.iter().enumerate() {
                let Passage { face, wall, of_neighbor, .. } = &passages[k];
                // What later mirrors make of this one's part.
                let later =
                    order[step + 1..].iter().map(|&later| passages[later].of_neighbor.scale);
                let coefficient = weight * of_neighbor.offset * later.product::<f64>();
                if let Some(wall) = wall.filter(|_| coefficient != 0.0) {
                    let condition = &self.problem.walls[wall].condition;
                    row.add_source(condition, wall, face.foot(domain, point), coefficient);
                }
                if *of_neighbor != UNCHANGED {
                    point = face.mirrored(domain, point);
                }
            }
        }
    }
}
