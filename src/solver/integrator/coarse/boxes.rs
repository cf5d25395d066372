//! Boxes of particles.

use std::collections::BTreeMap;

use glam::DVec3;

use super::NONE;
use super::envelope::Envelope;
use crate::model::Problem;

/// The most aggregates, about: more reduce iterations further, but their system is solved in each.
const MOST: f64 = 1000.0;

/// The least width of an aggregate, in spacings: narrower ones gain nothing that pays.
const NARROWEST: f64 = 4.0;

/// A grid of boxes, each at least as wide as the support.
pub(super) struct Boxes {
    min: DVec3,
    /// Width of a box along each axis, m; infinite along axes past the dimension.
    width: DVec3,
    counts: [usize; 3],
    periodic: [bool; 3],
    /// The axes, the one with the fewest boxes first: numbered so, boxes that are neighbours have near
    /// numbers.
    axes: [usize; 3],
    /// Box and material of each aggregate.
    members: Vec<(usize, u16)>,
    materials: usize,
}

impl Boxes {
    pub(super) fn of(problem: &Problem) -> Self {
        let (extent, dimension) = (problem.domain.extent(), problem.dimension);
        let volume: f64 = (0..dimension).map(|axis| extent[axis]).product();
        let even = (volume / MOST).powf(1.0 / dimension as f64);
        let support = problem.kernel.cutoff() * (1.0 + 1e-9);
        let wanted = even.max(NARROWEST * problem.spacing).max(support);
        let counts: [usize; 3] = std::array::from_fn(|axis| match axis < dimension {
            true => ((extent[axis] / wanted) as usize).max(1),
            false => 1,
        });
        let width = std::array::from_fn(|axis| match axis < dimension {
            true => extent[axis] / counts[axis] as f64,
            false => f64::INFINITY,
        });
        let mut axes = [0, 1, 2];
        axes.sort_by_key(|&axis| counts[axis]);
        Self {
            min: problem.domain.min,
            width: DVec3::from_array(width),
            counts,
            periodic: problem.domain.periodic,
            axes,
            members: Vec::new(),
            materials: problem.materials.len(),
        }
    }

    /// The aggregate of each particle, or [`NONE`], and the colour of each aggregate: no two neighbours of
    /// one box have the same.
    pub(super) fn aggregates(&mut self, problem: &Problem) -> (Vec<u32>, Vec<usize>) {
        let particles = &problem.particles;
        let key =
            |a: usize| (self.number(self.place(particles.position[a])), particles.material[a]);
        let mut known: BTreeMap<(usize, u16), u32> = BTreeMap::new();
        let is_free = |a: &usize| !problem.is_held(*a);
        for a in (0..particles.len()).filter(is_free) {
            known.entry(key(a)).or_insert(0);
        }
        known.values_mut().zip(0..).for_each(|(aggregate, number)| *aggregate = number);
        let of = |a: usize| if is_free(&a) { known[&key(a)] } else { NONE };
        let aggregate = (0..particles.len()).map(of).collect();
        self.members = known.into_keys().collect();
        let colors = self.members.iter().map(|&(number, material)| {
            self.color(self.at(number)) * self.materials + usize::from(material)
        });
        (aggregate, colors.collect())
    }

    /// The matrix whose product with the indicator of each colour that is there is in `products`, in the
    /// order of the colours.
    pub(super) fn matrix(&self, colors: &[usize], products: &[(usize, Vec<f64>)]) -> Envelope {
        let numbered = (0..).zip(&self.members).map(|(k, member)| (*member, k));
        let known: BTreeMap<(usize, u16), usize> = numbered.collect();
        let row = |i: usize| {
            let (number, _) = self.members[i];
            let mut columns = Vec::new();
            for beside in self.neighbors(self.at(number)) {
                let of_box = (beside, 0)..=(beside, u16::MAX);
                columns.extend(known.range(of_box).map(|(_, &j)| j).filter(|&j| j <= i));
            }
            columns.sort_unstable();
            columns.dedup();
            let entry = |j: usize| {
                let product = products.iter().find(|(color, _)| *color == colors[j]);
                (j, product.map_or(0.0, |(_, product)| product[i]))
            };
            columns.into_iter().map(entry).collect()
        };
        let rows: Vec<Vec<(usize, f64)>> = (0..self.members.len()).map(row).collect();
        Envelope::new(&rows)
    }

    /// The box that a position is in.
    fn place(&self, position: DVec3) -> [usize; 3] {
        let offset = (position - self.min) / self.width;
        std::array::from_fn(|axis| (offset[axis].max(0.0) as usize).min(self.counts[axis] - 1))
    }

    fn number(&self, at: [usize; 3]) -> usize {
        let [fast, middle, slow] = self.axes;
        (at[slow] * self.counts[middle] + at[middle]) * self.counts[fast] + at[fast]
    }

    fn at(&self, number: usize) -> [usize; 3] {
        let [fast, middle, slow] = self.axes;
        let mut at = [0; 3];
        at[fast] = number % self.counts[fast];
        at[middle] = number / self.counts[fast] % self.counts[middle];
        at[slow] = number / (self.counts[fast] * self.counts[middle]);
        at
    }

    /// The boxes around one, and itself, by number.
    fn neighbors(&self, at: [usize; 3]) -> Vec<usize> {
        let beside = |axis: usize| -> Vec<usize> {
            let (here, count) = (at[axis], self.counts[axis]);
            match self.periodic[axis] {
                true => vec![(here + count - 1) % count, here, (here + 1) % count],
                false => (here.saturating_sub(1)..(here + 2).min(count)).collect(),
            }
        };
        let [x, y, z] = [beside(0), beside(1), beside(2)];
        let mut found = Vec::new();
        for &z in &z {
            for &y in &y {
                found.extend(x.iter().map(|&x| self.number([x, y, z])));
            }
        }
        found
    }

    /// Three colours repeat along each axis; where they do not fit round a periodic one, the last boxes have
    /// others.
    fn color(&self, at: [usize; 3]) -> usize {
        let along = |axis: usize| {
            let (here, count) = (at[axis], self.counts[axis]);
            let over = if self.periodic[axis] { count % 3 } else { 0 };
            if here < count - over { here % 3 } else { 3 + here - (count - over) }
        };
        (along(2) * 5 + along(1)) * 5 + along(0)
    }
}
