//! The stencil along lines of a lattice, on the CPU.
//!
//! Lines parallel to x that lie at one distance are a class c; R_c is the sum of the n_c of them
//! that there are. With E_c = R_c - n_c C, the difference of a particle to the lines around it, and
//! P_i = sum_c w_ci E_c, K_i = sum_c w_ci n_c, Q_i = P_i + K_i C, the rate of a particle is
//!
//! P_0(x) + sum_i [Q_i(x - i) + Q_i(x + i) - 2 K_i C(x)].
//!
//! So every line is read once, whatever the reach of the stencil along x. Lines follow each other in
//! memory, so several of them are worked on as one, in loops that the processor runs on several
//! values at once; only what is near the ends of a line is then done again, with what lies past
//! them. The rate of a constant field is exactly 0: its E_c are, and the K_i C cancel.
//!
//! The loops are compiled twice, see [`crate::model::wide`].

mod ends;
mod members;
mod sums;

use std::ops::Range;

use crate::model::lattice::{LatticeScene, WIDEST};
use crate::model::wide::{self, Work, multiply_add};
use crate::solver::cpu::operator::Combine;
use crate::solver::cpu::written::Written;

use super::parts::{PartKind, Parts, Rest};

use ends::NearEnd;
use members::{Members, MembersOf};
use sums::Sums;

/// Values that are worked on together: what lies around them stays in the fastest cache.
const BLOCK: usize = 512;

/// A part of the lattice that is worked on as one: lines with the same lines around them, or a part
/// of a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    /// The first site.
    pub(super) first: usize,
    /// How many sites.
    pub(super) length: usize,
    /// Place of the first site along x.
    x: usize,
    /// Whether no line around it is past an end.
    is_inside: bool,
}

impl Run {
    /// The run from site `first` on, of at most `most` sites.
    pub(super) fn starting(scene: &LatticeScene, first: usize, most: usize) -> Self {
        let [nx, ny, nz] = scene.counts;
        let [x, y, z] = scene.at(first);
        let within =
            |place: usize, count: usize| place >= scene.reach && place + scene.reach < count;
        let is_inside = (ny == 1 || within(y, ny)) && (nz == 1 || within(z, nz));
        let lines = match x == 0 && is_inside {
            true => (BLOCK / nx).min(ny.saturating_sub(y + scene.reach)).min(most / nx).max(1),
            false => 1,
        };
        // A long line in equal parts: a short one costs as much as a long one.
        let part = nx.div_ceil(nx.div_ceil(BLOCK));
        let length = if lines > 1 { lines * nx } else { (nx - x).min(part - x % part).min(most) };
        Self { first, length, x, is_inside }
    }
}

/// What working on runs needs beside what it reads and writes.
#[derive(Debug)]
pub(in crate::solver::cpu) struct Scratch {
    members: MembersOf,
    /// P_0, Q_1, Q_2, ... from `reach` before the run on.
    sums: Vec<Vec<f64>>,
    ends: Vec<NearEnd>,
    /// Where exceptions were looked for last.
    pub(super) seen: Seen,
}

/// Where each kind of exception was looked for last: the next are near.
#[derive(Debug, Default)]
pub(super) struct Seen {
    pub(super) held: usize,
    pub(super) walls: usize,
    /// Rows of their own.
    pub(super) rows: usize,
    /// Rows that share lines, and those of them beside seams.
    pub(super) shared: usize,
    pub(super) beside_seams: usize,
    /// Parts of the lattice, and of its rows.
    pub(super) parts: usize,
    pub(super) row_parts: usize,
}

impl Scratch {
    pub(super) fn new(scene: &LatticeScene) -> Self {
        Self {
            members: MembersOf::default(),
            sums: vec![vec![0.0; BLOCK + 2 * scene.reach]; scene.reach + 1],
            ends: NearEnd::all(scene),
            seen: Seen::default(),
        }
    }

    /// Writes what `written` makes of values and rates along `run`, of which there are `parts`, to `out`.
    pub(super) fn work(
        &mut self,
        scene: &LatticeScene,
        state: &[f64],
        run: &Run,
        parts: &Parts,
        written: Written<'_>,
        out: &mut [f64],
    ) {
        let (members, parts) =
            (self.members.of(scene, run), parts.from(run.first, &mut self.seen.parts));
        let around = Around { scene, state, run, members, parts, written };
        wide::run(Along { around, sums: &mut self.sums, ends: &self.ends, out });
    }
}

/// The work on a run.
struct Along<'a> {
    around: Around<'a>,
    sums: &'a mut [Vec<f64>],
    ends: &'a [NearEnd],
    out: &'a mut [f64],
}

impl Work for Along<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { around, sums, ends, out } = self;
        match around.scene.reach {
            0 => around.work::<0, FUSED>(sums, ends, out),
            1 => around.work::<1, FUSED>(sums, ends, out),
            2 => around.work::<2, FUSED>(sums, ends, out),
            3 => around.work::<3, FUSED>(sums, ends, out),
            WIDEST => around.work::<WIDEST, FUSED>(sums, ends, out),
            reach => unreachable!("no stencil of a scene reaches {reach} sites"),
        }
    }
}

/// What a run reads.
struct Around<'a> {
    scene: &'a LatticeScene,
    state: &'a [f64],
    run: &'a Run,
    members: &'a Members,
    parts: Rest<'a>,
    written: Written<'a>,
}

impl Around<'_> {
    #[inline(always)]
    fn work<const REACH: usize, const FUSED: bool>(
        &self,
        sums: &mut [Vec<f64>],
        ends: &[NearEnd],
        out: &mut [f64],
    ) {
        self.add_lines::<REACH, FUSED>(sums);
        self.add_along::<REACH, FUSED>(sums, out);
        self.near_ends(sums, ends, out);
    }

    /// The sites of the run whose sums are needed, relative to its first: those of its lines that lie
    /// beside it as well.
    fn needed(&self) -> Range<isize> {
        let (run, reach, nx) = (self.run, self.scene.reach, self.scene.counts[0]);
        let after = if run.length >= nx { 0 } else { reach.min(nx - run.x - run.length) };
        -(reach.min(run.x) as isize)..(run.length + after) as isize
    }

    /// Writes P_0, Q_1, Q_2, ...
    #[inline(always)]
    fn add_lines<const REACH: usize, const FUSED: bool>(&self, sums: &mut [Vec<f64>]) {
        let needed = self.needed();
        let length = needed.len();
        let start = REACH.wrapping_add_signed(needed.start);
        let beside = |line: usize| &self.state[line.wrapping_add_signed(needed.start)..][..length];
        let mut sums = sums.iter_mut().map(|sum| &mut sum[start..][..length]);
        let here = sums.next().expect("that of the particle's own place");
        let mut all = Sums::<REACH> {
            own: beside(self.run.first),
            here,
            steps: std::array::from_fn(|_| sums.next().expect("one for each step of the reach")),
            along: std::array::from_fn(|k| self.members.along[k + 1]),
            is_new: true,
        };
        let weights = |class: usize| {
            let of_class = &self.scene.classes[class].weights;
            let mut weights = [0.0; WIDEST + 1];
            weights[..of_class.len()].copy_from_slice(of_class);
            weights
        };
        let Members { fours, twos, ones, .. } = self.members;
        let mut pairs = fours.chunks_exact(2);
        for pair in &mut pairs {
            let [(a, four), (b, other)] = [pair[0], pair[1]];
            let lines = [four.map(beside), other.map(beside)];
            all.add::<2, 4, FUSED>(&lines, 1.0, &[weights(a), weights(b)]);
        }
        for &(class, four) in pairs.remainder() {
            all.add::<1, 4, FUSED>(&[four.map(beside)], 1.0, &[weights(class)]);
        }
        for &(class, two) in twos {
            all.add::<1, 2, FUSED>(&[two.map(beside)], 1.0, &[weights(class)]);
        }
        for &(class, line, factor) in ones {
            all.add::<1, 1, FUSED>(&[[beside(line)]], factor, &[weights(class)]);
        }
        if all.is_new {
            all.add::<0, 1, FUSED>(&[], 1.0, &[]);
        }
    }

    /// Writes the run as if lines had no ends.
    #[inline(always)]
    fn add_along<const REACH: usize, const FUSED: bool>(&self, sums: &[Vec<f64>], out: &mut [f64]) {
        // What is left out at either end of the lattice is near the end of a line.
        let run = self.run;
        let lower = REACH.saturating_sub(run.first).min(run.length);
        let upper = run.length.min((self.state.len() - run.first).saturating_sub(REACH)).max(lower);
        let along: [f64; REACH] = std::array::from_fn(|k| self.members.along[k + 1]);
        for (part, kind) in self.parts.within(run.first..run.first + run.length) {
            let (from, to) =
                ((part.start - run.first).max(lower), (part.end - run.first).min(upper));
            if to <= from {
                continue;
            }
            let (length, combine) = (to - from, self.combine(kind));
            let own = &self.state[run.first + from..][..length];
            let steps: [&[f64]; REACH] =
                std::array::from_fn(|k| &sums[k + 1][from..][..length + 2 * REACH]);
            let here = &sums[0][from + REACH..][..length];
            let sums = AlongSums { own, here, steps, along };
            match combine.has_two_factors() {
                true => sums.write::<true, FUSED>(combine, &mut out[from..to]),
                false => sums.write::<false, FUSED>(combine, &mut out[from..to]),
            }
        }
    }

    /// What is written where there is a kind.
    #[inline(always)]
    fn combine(&self, kind: PartKind) -> Combine {
        kind.written(self.written).times(kind.factor)
    }

    /// Writes what is near the ends of lines again, with what lies past them.
    #[inline(always)]
    fn near_ends(&self, sums: &[Vec<f64>], ends: &[NearEnd], out: &mut [f64]) {
        let (nx, reach, run) = (self.scene.counts[0], self.scene.reach, self.run);
        let needed = self.needed();
        for end in ends {
            if !(run.x..run.x + run.length.min(nx)).contains(&end.x) {
                continue;
            }
            let mut parts = self.parts;
            for local in (end.x - run.x..run.length).step_by(nx) {
                let own = self.state[run.first + local];
                let mut rate = sums[0][reach + local];
                for term in &end.terms {
                    let there = local as isize + term.further;
                    // The other end of a line that is longer than the run is not in it.
                    let sum = match needed.contains(&there) {
                        true => sums[term.step][reach.wrapping_add_signed(there)],
                        false => self.sum_at(there, term.step),
                    };
                    rate += term.factor * sum - self.members.along[term.step] * own;
                }
                out[local] = self.combine(parts.next(run.first + local)).of(own, rate);
            }
        }
    }

    /// Q_`step` at a place relative to the first of the run.
    fn sum_at(&self, there: isize, step: usize) -> f64 {
        let Members { fours, twos, ones, along } = self.members;
        let value = |line: usize| self.state[line.wrapping_add_signed(there)];
        let weight = |class: usize| self.scene.classes[class].weights.get(step).unwrap_or(&0.0);
        let own = value(self.run.first);
        let fours = fours.iter().flat_map(|&(class, four)| four.map(|line| (class, line, 1.0)));
        let twos = twos.iter().flat_map(|&(class, two)| two.map(|line| (class, line, 1.0)));
        let lines = fours.chain(twos).chain(ones.iter().copied());
        let differences =
            lines.map(|(class, line, factor)| weight(class) * (factor * value(line) - own));
        along[step] * own + differences.sum::<f64>()
    }
}

/// What the rates along a run are made of.
struct AlongSums<'a, const REACH: usize> {
    own: &'a [f64],
    /// P_0
    here: &'a [f64],
    /// Q_1, Q_2, ... from `REACH` before the run on.
    steps: [&'a [f64]; REACH],
    /// K_1, K_2, ...
    along: [f64; REACH],
}

impl<const REACH: usize> AlongSums<'_, REACH> {
    /// Writes what `combine`, which has two factors or one, makes of values and rates.
    #[inline(always)]
    fn write<const TWO: bool, const FUSED: bool>(&self, combine: Combine, out: &mut [f64]) {
        let Self { own, here, steps, along } = *self;
        for x in 0..out.len() {
            let own = own[x];
            let mut rate = here[x];
            for k in 0..REACH {
                let both = steps[k][x + REACH - 1 - k] + steps[k][x + REACH + 1 + k];
                rate += multiply_add::<FUSED>(-2.0, along[k] * own, both);
            }
            let factor = if TWO { combine.factor(own) } else { combine.factors[0] };
            out[x] = multiply_add::<FUSED>(factor, rate, combine.share * own);
        }
    }
}
