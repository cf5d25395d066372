//! Parts of a lattice, each of one factor and one curve.

use std::collections::HashMap;
use std::ops::Range;

use crate::model::lattice::LatticeScene;
use crate::model::operator::seek;
use crate::model::{Material, Problem};
use crate::solver::cpu::operator::Combine;
use crate::solver::cpu::written::Written;

/// Where along the sites rates are how many times those of the stencil, and which curve there is.
pub(super) struct Parts {
    /// From which site on there is which kind, the first from 0.
    starts: Vec<(u32, u32)>,
    kinds: Vec<PartKind>,
}

/// What is the same all along a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PartKind {
    /// How many times that of the stencil rates are.
    pub(super) factor: f64,
    /// Which curve particles have.
    curve: u16,
}

impl PartKind {
    /// What is `written` where there is one.
    #[inline(always)]
    pub(super) fn written(self, written: Written<'_>) -> Combine {
        written.of(usize::from(self.curve))
    }
}

impl Parts {
    /// Those of a lattice with one curve, where rates are the stencil's times some factors, the first from 0.
    pub(super) fn of_factors(factors: &[(u32, f64)]) -> Self {
        let kind = |&(first, factor): &(u32, f64)| (first, PartKind { factor, curve: 0 });
        let whole = factors.is_empty().then_some((0, PartKind { factor: 1.0, curve: 0 }));
        Self::of(whole.into_iter().chain(factors.iter().map(kind)))
    }

    /// Those of some `sites` (ascending) of a lattice with the particles of `problem`, of several curves, whose materials
    /// have factors. A stencil goes through a part at once, and what is at other sites does not count there.
    pub(super) fn of_materials(
        problem: &Problem,
        scene: &LatticeScene,
        factor: impl Fn(&Material) -> f64,
        sites: impl Iterator<Item = u32>,
    ) -> Self {
        let kinds = problem.materials.iter().zip(0..);
        let kinds: Vec<PartKind> =
            kinds.map(|(material, curve)| PartKind { factor: factor(material), curve }).collect();
        let part = |site: u32| {
            let material = scene.material(problem, site as usize)?;
            Some((site, kinds[usize::from(material)]))
        };
        let mut parts = sites.filter_map(part).peekable();
        // All others are taken to be like those before them.
        let first = parts.peek().map_or(kinds[0], |&(_, kind)| kind);
        Self::of([(0, first)].into_iter().chain(parts))
    }

    /// Those of sites that ascend, with which kind there is from each on.
    fn of(sites: impl Iterator<Item = (u32, PartKind)>) -> Self {
        let (mut parts, mut known) =
            (Self { starts: Vec::new(), kinds: Vec::new() }, HashMap::new());
        let mut last = None;
        for (first, kind) in sites.filter(|&(_, kind)| last.replace(kind) != Some(kind)) {
            let which = *known.entry((kind.factor.to_bits(), kind.curve)).or_insert_with(|| {
                parts.kinds.push(kind);
                parts.kinds.len() as u32 - 1
            });
            parts.starts.push((first, which));
        }
        parts.starts.shrink_to_fit();
        parts
    }

    /// How many there are up to that of a site, looked for from `near` on, which becomes this.
    #[inline]
    fn seek(&self, site: usize, near: &mut usize) -> usize {
        *near = seek(&self.starts, *near, |&(first, _)| first as usize <= site);
        *near
    }

    /// The kind at a site, looked for as by [`Self::seek`].
    #[inline]
    pub(super) fn at(&self, site: usize, near: &mut usize) -> PartKind {
        self.kinds[self.starts[self.seek(site, near) - 1].1 as usize]
    }

    /// Those from that of site `first` on, looked for as by [`Self::seek`].
    #[inline]
    pub(super) fn from(&self, first: usize, near: &mut usize) -> Rest<'_> {
        Rest { starts: &self.starts[self.seek(first, near) - 1..], kinds: &self.kinds }
    }

    /// Bytes that they hold.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.kinds)
    }
}

/// Parts that follow each other; there is always one.
#[derive(Clone, Copy)]
pub(super) struct Rest<'a> {
    starts: &'a [(u32, u32)],
    kinds: &'a [PartKind],
}

impl<'a> Rest<'a> {
    /// Those within `sites`, the first of which is in the first part.
    #[inline(always)]
    pub(super) fn within(
        self,
        sites: Range<usize>,
    ) -> impl Iterator<Item = (Range<usize>, PartKind)> + 'a {
        let (mut rest, mut first) = (self, sites.start);
        std::iter::from_fn(move || {
            if first >= sites.end {
                return None;
            }
            let part = first..rest.end().min(sites.end);
            let kind = rest.kind();
            first = part.end;
            if first < sites.end {
                rest.starts = &rest.starts[1..];
            }
            Some((part, kind))
        })
    }

    /// The kind at a site that is not before the first part: those before its part are left.
    #[inline(always)]
    pub(super) fn next(&mut self, site: usize) -> PartKind {
        while self.end() <= site {
            self.starts = &self.starts[1..];
        }
        self.kind()
    }

    /// That of the first part.
    #[inline(always)]
    fn kind(&self) -> PartKind {
        self.kinds[self.starts[0].1 as usize]
    }

    /// Where the second part begins.
    #[inline(always)]
    fn end(&self) -> usize {
        self.starts.get(1).map_or(usize::MAX, |&(first, _)| first as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::lattice::MixedScene;
    use crate::model::material::Melting;
    use crate::model::{Conductivity, KernelKind, scenes};

    #[test]
    fn parts_are_those_of_factors_within_some_sites() {
        let parts = Parts::of_factors(&[(0, 1.0), (5, 0.6), (9, 1.0), (12, 1.0)]);
        assert_eq!((parts.starts.len(), parts.kinds.len()), (3, 2));
        let expected = [(3..5, 1.0), (5..9, 0.6), (9..14, 1.0)];
        for near in [0, 1, 3] {
            let rest = parts.from(3, &mut near.clone());
            let found: Vec<_> =
                rest.within(3..14).map(|(part, kind)| (part, kind.factor)).collect();
            assert_eq!(found, expected);
            assert_eq!(rest.within(4..5).count(), 1);
            let mut rest = rest;
            for (site, factor) in [(3, 1.0), (4, 1.0), (5, 0.6), (8, 0.6), (20, 1.0)] {
                assert_eq!(rest.next(site).factor, factor);
                assert_eq!(parts.at(site, &mut near.clone()).factor, factor);
            }
        }
        let whole = Parts::of_factors(&[]);
        assert_eq!(whole.from(0, &mut 0).within(0..7).count(), 1);
        assert_eq!(whole.at(6, &mut 0).factor, 1.0);
    }

    #[test]
    fn sites_of_a_material_have_its_factor_and_its_curve() {
        let mut problem = scenes::lattice(KernelKind::CubicSpline, 2, [13, 11, 1], 0.1, 2.0);
        let melting = Melting {
            solidus: 330.0,
            liquidus: 330.0,
            latent: 1e6,
            conductivity: Conductivity::constant(4.0),
            capacity: 1.0,
        };
        let solid = Conductivity::constant(0.5);
        let melts = Material::thermal("metal", &solid, 1.0, Some(&melting), 1000.0);
        problem.materials.extend([melts, Material::diffusive("sand", 0.25, 1000.0)]);
        // Beginning with a hole, and with one in the middle.
        let mut keep =
            (0..problem.particles.len()).map(|site| site > 2 && !(60..64).contains(&site));
        problem.particles.position.retain(|_| keep.next() == Some(true));
        let count = problem.particles.position.len();
        problem.particles.volume.truncate(count);
        problem.initial.truncate(count);
        let material = |particle: usize| {
            let position = problem.particles.position[particle];
            if position.y > 0.7 { 2 } else { u16::from(position.x > 0.55) }
        };
        problem.particles.material = (0..count).map(material).collect();
        let scene = MixedScene::of(&problem).expect("a lattice");
        let ratio = |material: &Material| scene.ratio(material);
        let order = scene.lattice.order.as_ref().expect("holes");
        for rows in [vec![], vec![3, 5, 30, 31, 32, 90]] {
            for of_rows in [false, true] {
                let sites = (0..order.len() as u32).filter(|site| rows.contains(site) == of_rows);
                let parts = Parts::of_materials(&problem, &scene.lattice, ratio, sites);
                assert!(parts.kinds.len() <= 3 && parts.starts[0].0 == 0);
                let (mut rest, mut found) = (parts.from(0, &mut 0), 0);
                for (site, &particle) in order.iter().enumerate() {
                    let kind = rest.next(site);
                    assert_eq!(parts.at(site, &mut 0), kind);
                    let Some(&of) = problem.particles.material.get(particle as usize) else {
                        continue;
                    };
                    if rows.contains(&(site as u32)) != of_rows {
                        continue;
                    }
                    let factor = [1.0, 0.5, 0.25][usize::from(of)];
                    assert_eq!((kind.curve, kind.factor), (of, factor), "{site}");
                    let written = [1.0, 2.0, 3.0].map(|factor| Combine::new(1.0, factor));
                    assert_eq!(kind.written(Written::Each(&written)), written[usize::from(of)]);
                    assert_eq!(kind.written(Written::Same(written[2])), written[2]);
                    found += 1;
                }
                assert_eq!(found, if of_rows { rows.len() } else { count - rows.len() });
            }
        }
        // Of both ends alone there are two.
        let ends = (0..4).chain(140..order.len() as u32);
        let parts = Parts::of_materials(&problem, &scene.lattice, ratio, ends);
        assert_eq!(parts.starts.len(), 2);
    }
}
