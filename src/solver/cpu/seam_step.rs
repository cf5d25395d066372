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

    /// Adds what the matrix does not know of flows between materials to what is `written` of the next places up to
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
            given += self.seams.add(rows, self.locals, |place, potential, rate| {
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
            self.locals.set_some(row, found.each_ref());
            row += FEW;
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
