//! One of Euler's steps at the seams among some places.

use std::ops::Range;

use super::course::Course;
use super::latent::LatentEnthalpies;
use super::written::Written;
use crate::model::operator::{Local, Locals, LocalsMut, SeamGroup, Seams, take_below};
use crate::model::wide::Work;

/// The rows of seams among some places, in one of Euler's steps.
pub(super) struct SeamStep<'a> {
    seams: &'a Seams,
    /// What all are like as the step begins.
    locals: &'a Locals,
    groups: Vec<Group<'a>>,
}

/// Those of them whose particles are of one material.
struct Group<'a> {
    material: u16,
    /// The rows to which something is still to be added, and those of which is still to be noted what they are like.
    to_add: Range<usize>,
    to_note: Range<usize>,
    /// What the latter are like after the step.
    after: LocalsMut<'a>,
}

impl<'a> SeamStep<'a> {
    /// A step of all rows, from `locals` to what is written `after` it.
    pub(super) fn of_all(seams: &'a Seams, locals: &'a Locals, after: &'a mut Locals) -> Self {
        let mut after = after.all_mut();
        let group = |SeamGroup { material, rows }: &SeamGroup| Group {
            material: *material,
            to_add: rows.clone(),
            to_note: rows.clone(),
            after: after.take(rows.len()),
        };
        Self { seams, locals, groups: seams.groups().iter().map(group).collect() }
    }

    /// Takes the step of the next places up to `end` out.
    pub(super) fn take(&mut self, end: usize) -> Self {
        let Self { seams, locals, ref mut groups } = *self;
        let take = |group: &mut Group<'a>| {
            let rows = take_below(seams.places(), &mut group.to_add, end);
            group.to_note = group.to_add.clone();
            let after = group.after.take(rows.len());
            Group { material: group.material, to_add: rows.clone(), to_note: rows, after }
        };
        Self { seams, locals, groups: groups.iter_mut().map(take).collect() }
    }

    /// To how many rows something is still to be added.
    pub(super) fn len(&self) -> usize {
        self.groups.iter().map(|group| group.to_add.len()).sum()
    }

    /// Adds what the operator has not written of flows between materials to what is `written` of the next places up to
    /// `end`, which is in `out` from place `first` on; returns what held particles gave beyond what it knows,
    /// value x capacity / s.
    pub(super) fn add(
        &mut self,
        end: usize,
        first: usize,
        written: Written<'_>,
        out: &mut [f64],
    ) -> f64 {
        let mut given = 0.0;
        for group in &mut self.groups {
            let rows = take_below(self.seams.places(), &mut group.to_add, end);
            let combine = written.of(usize::from(group.material));
            given += self.seams.add_to_step(rows, self.locals, |place, potential, rate| {
                out[place - first] += combine.factor(potential) * rate;
            });
        }
        given
    }

    /// Takes note of what the particles of the next places up to `end` are like after the step: `note` gets a material,
    /// rows of it, and where that is to be written.
    pub(super) fn note(
        &mut self,
        end: usize,
        mut note: impl FnMut(u16, Range<usize>, LocalsMut<'_>),
    ) {
        for group in &mut self.groups {
            let rows = take_below(self.seams.places(), &mut group.to_note, end);
            let after = group.after.take(rows.len());
            if !rows.is_empty() {
                note(group.material, rows, after);
            }
        }
    }
}

/// Particles that are worked on together.
const FEW: usize = 8;

/// Takes note of what some particles of seams that follow a course are like, from potentials and from what of them is
/// latent.
pub(super) struct Note<'a> {
    pub(super) seams: &'a Seams,
    pub(super) course: &'a Course,
    /// Their places, ascending.
    pub(super) places: &'a [u32],
    /// Potentials of places from `first` on, K.
    pub(super) potentials: &'a [f64],
    pub(super) first: usize,
    pub(super) latent: LatentEnthalpies<'a>,
    pub(super) locals: LocalsMut<'a>,
}

impl Work for Note<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(mut self) {
        let (mut row, mut near) = (0, 0);
        if let Some(&place) = self.places.first() {
            self.latent.seek(place as usize, &mut near);
        }
        let (many, rest) = self.places.as_chunks::<FEW>();
        for places in many {
            let found = self.few::<FUSED>(places, &mut near);
            self.locals.set_some(row, &found);
            row += FEW;
        }
        if rest.is_empty() {
            return;
        }
        let [temperatures, potentials, terms] = self.few::<FUSED>(rest, &mut near);
        for x in 0..rest.len() {
            let [temperature, potential, term] = [temperatures[x], potentials[x], terms[x]];
            self.locals.set(row + x, Local { temperature, potential, term });
        }
    }
}

impl Note<'_> {
    /// Temperatures and potentials (K) and terms of a few in ascending places, before the first of which there are `near`
    /// latent ones: this becomes how many there are before the last.
    #[inline(always)]
    fn few<const FUSED: bool>(&self, places: &[u32], near: &mut usize) -> [[f64; FEW]; 3] {
        let (mut potentials, mut melting) = ([0.0; FEW], [self.course.unmelted(); FEW]);
        for (x, &place) in places.iter().enumerate() {
            potentials[x] = self.potentials[place as usize - self.first];
            if let Some(enthalpy) = self.latent.next(place as usize, near) {
                melting[x] = enthalpy;
            }
        }
        let [temperatures, conductivities] =
            self.course.states::<FEW, FUSED>(&potentials, &melting);
        let mut terms = [0.0; FEW];
        for x in 0..FEW {
            terms[x] = self.seams.term(conductivities[x]);
        }
        [temperatures, potentials, terms]
    }
}

#[cfg(test)]
mod tests {
    use super::super::course::tests::{melts, solid};
    use super::super::latent::Latent;
    use super::*;
    use crate::model::{KernelKind, scenes, wide};

    #[test]
    fn many_and_a_rest_are_like_each_by_itself() {
        let mut problem = scenes::lattice(KernelKind::CubicSpline, 2, [8, 23, 1], 0.1, 2.0);
        // At one temperature, over a range and not at all, beside each other.
        problem.materials = vec![melts(400.0, 200.0), melts(420.0, 900.0), solid()];
        let count = problem.particles.len();
        problem.particles.material = (0..count).map(|place| (place % 8 / 3) as u16).collect();
        let places: Vec<u32> = (0..count as u32).collect();
        let seams = Seams::of(&problem, &places, true, |_| None).expect("materials meet");
        // Solid, melting and liquid, in turn.
        let enthalpy = |place: usize| 350.0 + ((place * 61) % 350) as f64;
        for SeamGroup { material, rows } in seams.groups() {
            let course = Course::of(&problem.materials[usize::from(*material)]).expect("one");
            let (mut potentials, mut latent) = (vec![0.0; count], Latent::default());
            for (place, potential) in potentials.iter_mut().enumerate() {
                *potential = course.potential(enthalpy(place));
                if !course.tells(enthalpy(place), *potential) {
                    latent.push(place, enthalpy(place), None);
                }
            }
            assert_eq!(latent.places().len() > 10, *material == 0);
            for first in [0, 3] {
                for length in 0..=rows.len() - first {
                    let rows = rows.start + first..rows.start + first + length;
                    let places = &seams.places()[rows.clone()];
                    let mut locals = Locals::of(&seams);
                    let mut rest = locals.all_mut();
                    rest.take(rows.start);
                    wide::run(Note {
                        seams: &seams,
                        course: &course,
                        places,
                        potentials: &potentials,
                        first: 0,
                        latent: latent.known(),
                        locals: rest.take(length),
                    });
                    for (row, &place) in rows.clone().zip(places) {
                        let expected = seams.local(row, enthalpy(place as usize));
                        let found = locals.at(row);
                        let pairs = [
                            (found.temperature, expected.temperature),
                            (found.potential, expected.potential),
                            (found.term, expected.term),
                        ];
                        let are_close = pairs.iter().all(|(a, b)| (a - b).abs() < 1e-11 * b.abs());
                        assert!(are_close, "{material}, {length}: {found:?}, not {expected:?}");
                    }
                    let behind = rows.end..seams.places().len();
                    assert!(behind.into_iter().all(|row| locals.at(row).temperature == 0.0));
                }
            }
        }
    }
}
