//! One of Euler's steps at the seams among some places.

use std::ops::Range;

use crate::model::operator::{Local, Locals, LocalsMut, Seams, take_below};

/// The rows of seams among some places, in one of Euler's steps.
pub(super) struct SeamStep<'a> {
    seams: &'a Seams,
    /// What all are like as the step begins.
    locals: &'a Locals,
    /// What those of these places are like after it, and the first of them.
    after: LocalsMut<'a>,
    first: usize,
    /// The rows whose rates are still to be added to, and those of which is still to be noted what they are like.
    to_add: Range<usize>,
    to_note: Range<usize>,
}

impl<'a> SeamStep<'a> {
    /// A step of `rows` from `locals`, which are of all; `after` is for those.
    pub(super) fn new(
        seams: &'a Seams,
        locals: &'a Locals,
        rows: Range<usize>,
        after: LocalsMut<'a>,
    ) -> Self {
        Self { seams, locals, after, first: rows.start, to_add: rows.clone(), to_note: rows }
    }

    /// Adds what the matrix does not know of flows between materials to the rates of the next places up to `end`, which
    /// are in `rates` from place `first` on; returns what held particles gave beyond what it knows,
    /// value x capacity / s.
    pub(super) fn add(&mut self, end: usize, first: usize, rates: &mut [f64]) -> f64 {
        let rows = take_below(self.seams.places(), &mut self.to_add, end);
        self.seams.add(rows, self.locals, 1.0, first, rates)
    }

    /// Takes note of what the particles of the next places up to `end` are like after the step, which `local` tells
    /// of a row and its place.
    pub(super) fn note(
        &mut self,
        end: usize,
        mut local: impl FnMut(&Seams, usize, usize) -> Local,
    ) {
        for row in take_below(self.seams.places(), &mut self.to_note, end) {
            let place = self.seams.places()[row] as usize;
            self.after.set(row - self.first, local(self.seams, row, place));
        }
    }
}
