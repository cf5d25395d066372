//! Where materials meet of which one's conductivity depends on temperature, or which melts.
//!
//! Within a material heat flows down its potential, but potentials of different materials are no measure for
//! each other. The matrix has such pairs as if they were: a [`Seam`] says what they are short of. With the
//! weight w of the pair, made from the reference conductivities, that is
//! w ((K / K_ref) (T_b - T_a) - (psi_b - psi_a)), where K is the mean of the conductivities at T_a and T_b.
//! A step of an enthalpy may have the pair with another weight w' before, that of a stencil which goes over it anyway:
//! it is short of w (K / K_ref) (T_b - T_a) - w' (psi_b - psi_a).

mod find;

use std::ops::Range;

use rayon::prelude::*;

use crate::model::PairMean;
use crate::model::material::Material;
use crate::model::wide::{self, Work, multiply_add};

/// Rows that one parallel task works on.
const ROWS_OF_A_TASK: usize = 1 << 9;

/// Rows of one kind that are worked on together.
const FEW: usize = 4;

/// The pairs of different materials, row by row: those of one material follow each other, so that neighbours of a row
/// do too.
#[derive(Clone, Debug)]
pub struct Seams {
    pair_mean: PairMean,
    materials: Vec<Material>,
    groups: Vec<SeamGroup>,
    /// By row, ascending in each group.
    places: Vec<u32>,
    /// By row: which one of the kinds. Of a lattice many rows are of one.
    rows: Vec<u32>,
    kinds: Vec<RowKind>,
    /// The pairs of kinds, one kind after the other.
    pairs: Vec<Pair>,
    /// The weights with which a step of an enthalpy has these before seams add to it, 1/s, where some are others.
    written: Option<Vec<f64>>,
}

/// A particle that has neighbours of other materials.
#[derive(Clone, Debug)]
pub struct Seam {
    /// Its place.
    pub place: u32,
    /// Its material.
    pub material: u16,
    /// Place and material of each of these neighbours, the weight of the pair, and that with which a step of an enthalpy
    /// has it before, 1/s.
    pub pairs: Vec<(u32, u16, [f64; 2])>,
}

/// The rows of particles of one material.
#[derive(Clone, Debug)]
pub struct SeamGroup {
    /// The material.
    pub material: u16,
    /// Which rows.
    pub rows: Range<usize>,
}

/// Rows that differ in their place alone.
#[derive(Clone, Debug)]
struct RowKind {
    material: u16,
    /// Capacity where the particle is held, else none.
    held: Option<f64>,
    /// How many rows further the first of its neighbours is, and how far the last is behind that.
    first: isize,
    span: usize,
    /// Which pairs it has.
    pairs: Range<usize>,
}

/// A row with one of its neighbours.
#[derive(Clone, Copy, Debug)]
struct Pair {
    /// How many rows further than the first of the neighbours this one is.
    ahead: usize,
    /// The weight, 1/s.
    weight: f64,
    /// This over the mean of the reference conductivities.
    over_mean: f64,
}

/// What the particle of a row is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// K
    pub temperature: f64,
    /// K
    pub potential: f64,
    /// What [`PairMean`] needs of its conductivity, W/(m K).
    pub term: f64,
}

/// What the particles of rows are like.
#[derive(Clone, Debug, Default)]
pub struct Locals {
    /// By row.
    temperatures: Vec<f64>,
    potentials: Vec<f64>,
    terms: Vec<f64>,
}

/// Those of some rows that follow each other, to be written.
#[derive(Debug)]
pub struct LocalsMut<'a> {
    temperatures: &'a mut [f64],
    potentials: &'a mut [f64],
    terms: &'a mut [f64],
}

impl Locals {
    /// Those of all rows, which are still to be written.
    pub fn of(seams: &Seams) -> Self {
        let count = seams.places.len();
        let [temperatures, potentials, terms] = [(); 3].map(|()| vec![0.0; count]);
        Self { temperatures, potentials, terms }
    }

    /// All of them.
    pub fn all_mut(&mut self) -> LocalsMut<'_> {
        let Self { temperatures, potentials, terms } = self;
        LocalsMut { temperatures, potentials, terms }
    }

    /// That of one row.
    #[cfg(test)]
    pub fn at(&self, row: usize) -> Local {
        let [temperature, potential, term] =
            [&self.temperatures, &self.potentials, &self.terms].map(|of| of[row]);
        Local { temperature, potential, term }
    }

    /// Bytes that they hold.
    pub fn memory_bytes(&self) -> usize {
        [&self.temperatures, &self.potentials, &self.terms]
            .map(|each| size_of_val(&**each))
            .iter()
            .sum()
    }
}

impl LocalsMut<'_> {
    /// Takes those of the next rows out.
    pub fn take(&mut self, rows: usize) -> Self {
        let Self { temperatures, potentials, terms } = self;
        let [temperatures, potentials, terms] = [temperatures, potentials, terms]
            .map(|rest| rest.split_off_mut(..rows).expect("as many rows as there are"));
        Self { temperatures, potentials, terms }
    }

    /// Takes note of what one of them is like, counted from the first.
    #[inline(always)]
    pub fn set(&mut self, row: usize, Local { temperature, potential, term }: Local) {
        self.temperatures[row] = temperature;
        self.potentials[row] = potential;
        self.terms[row] = term;
    }

    /// The same of some that follow each other: temperatures and potentials (K), and terms.
    #[inline(always)]
    pub fn set_some<const COUNT: usize>(&mut self, first: usize, some: &[[f64; COUNT]; 3]) {
        let [temperatures, potentials, terms] = some;
        self.temperatures[first..][..COUNT].copy_from_slice(temperatures);
        self.potentials[first..][..COUNT].copy_from_slice(potentials);
        self.terms[first..][..COUNT].copy_from_slice(terms);
    }
}

impl Seams {
    /// The rows of each material.
    pub fn groups(&self) -> &[SeamGroup] {
        &self.groups
    }

    /// The places of its rows, which ascend among those of a material.
    pub fn places(&self) -> &[u32] {
        &self.places
    }

    #[inline(always)]
    fn kind(&self, row: usize) -> &RowKind {
        &self.kinds[self.rows[row] as usize]
    }

    /// What the particle of a row is like with an enthalpy (K).
    pub fn local(&self, row: usize, enthalpy: f64) -> Local {
        let material = &self.materials[usize::from(self.kind(row).material)];
        let plain = || [enthalpy, enthalpy, material.conductivity];
        let [temperature, potential, conductivity] =
            material.curve.as_ref().map_or_else(plain, |curve| curve.state(enthalpy));
        Local { temperature, potential, term: self.term(conductivity) }
    }

    /// What is needed of a conductivity (W/(m K)) of one of a pair.
    #[inline(always)]
    pub fn term(&self, conductivity: f64) -> f64 {
        self.pair_mean.term(conductivity)
    }

    /// What all of them are like, which `local` tells of a row and its place.
    pub fn locals(&self, local: impl Fn(usize, usize) -> Local + Sync) -> Locals {
        let (count, mut locals) = (self.places.len(), Locals::of(self));
        let mut rest = locals.all_mut();
        let parts = (0..count).step_by(ROWS_OF_A_TASK).map(|first| {
            let rows = first..count.min(first + ROWS_OF_A_TASK);
            (rest.take(rows.len()), rows)
        });
        parts.collect::<Vec<_>>().into_par_iter().for_each(|(mut part, rows)| {
            let first = rows.start;
            rows.for_each(|row| part.set(row - first, local(row, self.places[row] as usize)));
        });
        locals
    }

    /// Calls `add(place, potential, rate)` for some rows of free particles with what their rates are short of, where
    /// particles are like `locals`; returns what held particles gave beyond what the matrix knows,
    /// value x capacity / s.
    pub fn add(
        &self,
        rows: Range<usize>,
        locals: &Locals,
        add: impl FnMut(usize, f64, f64),
    ) -> f64 {
        wide::run(AddSeams::<_, false> { of: self, rows, locals, add })
    }

    /// As [`Self::add`] where a step of an enthalpy is written: with what that is short of.
    pub fn add_to_step(
        &self,
        rows: Range<usize>,
        locals: &Locals,
        add: impl FnMut(usize, f64, f64),
    ) -> f64 {
        match self.written {
            Some(_) => wide::run(AddSeams::<_, true> { of: self, rows, locals, add }),
            None => self.add(rows, locals, add),
        }
    }

    /// Its rows.
    pub fn rows(&self) -> impl Iterator<Item = Seam> + '_ {
        (0..self.rows.len()).map(|row| {
            let kind = self.kind(row);
            let first = row.wrapping_add_signed(kind.first);
            let pair = |which: usize| {
                let Pair { ahead, weight, .. } = self.pairs[which];
                let written = self.written.as_ref().map_or(weight, |written| written[which]);
                let other = first + ahead;
                (self.places[other], self.kind(other).material, [weight, written])
            };
            let pairs = kind.pairs.clone().map(pair).collect();
            Seam { place: self.places[row], material: kind.material, pairs }
        })
    }

    /// Bytes that they hold.
    pub fn memory_bytes(&self) -> usize {
        let pairs =
            size_of_val(&*self.pairs) + size_of_val(self.written.as_deref().unwrap_or_default());
        let kinds = size_of_val(&*self.kinds) + pairs;
        size_of_val(&*self.places) + size_of_val(&*self.rows) + kinds + size_of_val(&*self.groups)
    }
}

/// See [`Seams::add`], and [`Seams::add_to_step`] if it is `TO_STEP`.
struct AddSeams<'a, A, const TO_STEP: bool> {
    of: &'a Seams,
    rows: Range<usize>,
    locals: &'a Locals,
    add: A,
}

impl<A: FnMut(usize, f64, f64), const TO_STEP: bool> Work for AddSeams<'_, A, TO_STEP> {
    type Output = f64;

    #[inline(always)]
    fn run<const FUSED: bool>(self) -> f64 {
        match self.of.pair_mean {
            PairMean::Harmonic => self.add::<FUSED>(|a, b| PairMean::Harmonic.of_terms(a, b)),
            PairMean::Arithmetic => self.add::<FUSED>(|a, b| PairMean::Arithmetic.of_terms(a, b)),
        }
    }
}

impl<A: FnMut(usize, f64, f64), const TO_STEP: bool> AddSeams<'_, A, TO_STEP> {
    #[inline(always)]
    fn add<const FUSED: bool>(self, mean: impl Fn(f64, f64) -> f64) -> f64 {
        let Self { of, mut rows, locals, mut add } = self;
        let mut given = 0.0;
        while let left @ [kind, ..] = &of.rows[rows.clone()] {
            let few = left.first_chunk::<FEW>();
            let are_alike = few.is_some_and(|few| few.iter().all(|which| which == kind));
            let (row, kind) = (rows.start, &of.kinds[*kind as usize]);
            if are_alike {
                let rates = of.rates::<FUSED, TO_STEP, FEW>(row, kind, locals, &mean);
                for (row, rate) in (row..).zip(rates) {
                    given += of.add_one(row, kind, locals, rate, &mut add);
                }
                rows.start += FEW;
            } else {
                let [rate] = of.rates::<FUSED, TO_STEP, 1>(row, kind, locals, &mean);
                given += of.add_one(row, kind, locals, rate, &mut add);
                rows.start += 1;
            }
        }
        given
    }
}

impl Seams {
    /// What rates of the rows of one kind from `row` on are short of.
    #[inline(always)]
    fn rates<const FUSED: bool, const TO_STEP: bool, const COUNT: usize>(
        &self,
        row: usize,
        kind: &RowKind,
        locals: &Locals,
        mean: impl Fn(f64, f64) -> f64,
    ) -> [f64; COUNT] {
        let all = [&locals.temperatures, &locals.potentials, &locals.terms];
        let from = |some: &[f64], first: usize| -> [f64; COUNT] {
            some[first..first + COUNT].try_into().expect("as many")
        };
        let [temperature, potential, term] = all.map(|all| from(all, row));
        let start = row.wrapping_add_signed(kind.first);
        let around = all.map(|all| &all[start..start + kind.span + COUNT]);
        let mut rates = [0.0; COUNT];
        let pairs = &self.pairs[kind.pairs.clone()];
        let written = self.written.as_ref().filter(|_| TO_STEP);
        let written = written.map_or(&[][..], |written| &written[kind.pairs.clone()]);
        for (k, &Pair { ahead, weight, over_mean }) in pairs.iter().enumerate() {
            let weight = if TO_STEP { written[k] } else { weight };
            let [temperatures, potentials, terms] = around.map(|around| from(around, ahead));
            for x in 0..COUNT {
                let by_heat = over_mean * mean(term[x], terms[x]);
                let known = weight * (potentials[x] - potential[x]);
                let fall = temperatures[x] - temperature[x];
                rates[x] += multiply_add::<FUSED>(by_heat, fall, -known);
            }
        }
        rates
    }

    /// Adds the rate of a row of a free particle; returns what a held one gave.
    #[inline(always)]
    fn add_one(
        &self,
        row: usize,
        kind: &RowKind,
        locals: &Locals,
        rate: f64,
        add: &mut impl FnMut(usize, f64, f64),
    ) -> f64 {
        match kind.held {
            Some(capacity) => -capacity * rate,
            None => {
                add(self.places[row] as usize, locals.potentials[row], rate);
                0.0
            }
        }
    }
}

#[cfg(test)]
#[path = "seams_tests.rs"]
mod tests;
