//! The stencil along lines of a lattice, on the CPU.
//!
//! The rate of a particle is the sum over classes c of lines parallel to x, and over steps i along
//! them, of w_ci (R_c(x - i) + R_c(x + i) - 2 n_c C(x)), where R_c is the sum of the n_c lines of a
//! class. Lines follow each other in memory, so several of them are worked on as one, in loops that
//! the processor runs on several values at once; only what is near the ends of a line is then done
//! again, with what lies past them. Differences, not a diagonal: a constant field has rate 0.
//!
//! Where the processor has them, wider vectors and fused multiplications are used, so that the last
//! bits of a result depend on the processor; they do not depend on the number of threads.

use std::ops::Range;

use crate::model::lattice::LatticeScene;

/// Values that are worked on together: what lies around them stays in the fastest cache.
const BLOCK: usize = 1024;

/// Classes that are added in one go.
const CLASSES: usize = 3;

/// The widest reach whose loops are unrolled; wider ones are added step by step.
const UNROLLED: usize = 3;

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
}

impl Run {
    /// The run from site `first` on, of at most `most` sites.
    pub(super) fn starting(scene: &LatticeScene, first: usize, most: usize) -> Self {
        let [nx, ny, nz] = scene.counts;
        let (x, y, z) = (first % nx, first / nx % ny, first / (nx * ny));
        let within =
            |place: usize, count: usize| place >= scene.reach && place + scene.reach < count;
        let is_inside = (ny == 1 || within(y, ny)) && (nz == 1 || within(z, nz));
        let lines = match x == 0 && is_inside {
            true => (BLOCK / nx).min(ny.saturating_sub(y + scene.reach)).min(most / nx).max(1),
            false => 1,
        };
        let length = if lines > 1 { lines * nx } else { (nx - x).min(BLOCK).min(most) };
        Self { first, length, x }
    }
}

/// The lines of a class around a run.
#[derive(Debug, Default)]
struct Members {
    /// The site of each line that is beside the first of the run, and the factor of its values.
    lines: Vec<(usize, f64)>,
    /// Whether every factor is 1.
    plain: bool,
}

impl Members {
    /// The values along a run and `reach` more on either side, where they are those of one line.
    fn single<'a>(&self, state: &'a [f64], run: &Run, reach: usize) -> Option<&'a [f64]> {
        match self.lines[..] {
            [(line, _)] if self.plain && line >= reach => {
                state.get(line - reach..line + run.length + reach)
            }
            _ => None,
        }
    }

    /// R_c at a site `further` along x than place `local` of the run.
    fn sum_at(&self, local: usize, further: isize, state: &[f64]) -> f64 {
        let site = |line: usize| (line + local).wrapping_add_signed(further);
        self.lines.iter().map(|&(line, factor)| factor * state[site(line)]).sum()
    }
}

/// What working on a run needs.
#[derive(Debug)]
pub(super) struct Scratch {
    members: Vec<Members>,
    /// R_c of each class, with `reach` values more on either side; not of one line alone, which is
    /// read where it is.
    sums: Vec<Vec<f64>>,
    /// Sums of terms that do not fit into one go.
    partial: Vec<f64>,
    ends: Vec<NearEnd>,
}

/// What is written at each site: `share` C + `scale` x rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Combine {
    pub(super) share: f64,
    pub(super) scale: f64,
}

/// A class of lines as the innermost loop takes it.
#[derive(Clone, Copy)]
struct Term<'a> {
    /// R_c from `reach` before the run on.
    sum: &'a [f64],
    /// n_c
    count: f64,
    /// w_ci for i from 0 on, filled up with 0.
    weights: [f64; UNROLLED + 1],
}

/// What a run reads.
struct Around<'a> {
    scene: &'a LatticeScene,
    state: &'a [f64],
    run: &'a Run,
    members: &'a [Members],
    /// R_c of each class, from `reach` before the run on.
    sums: Vec<&'a [f64]>,
}

impl Scratch {
    pub(super) fn new(scene: &LatticeScene) -> Self {
        let classes = scene.classes.len();
        Self {
            members: (0..classes).map(|_| Members::default()).collect(),
            sums: vec![vec![0.0; BLOCK + 2 * scene.reach]; classes],
            partial: vec![0.0; BLOCK],
            ends: NearEnd::all(scene),
        }
    }

    /// Writes what `combine` makes of values and rates along `run` to `out`.
    pub(super) fn work(
        &mut self,
        scene: &LatticeScene,
        state: &[f64],
        run: &Run,
        combine: Combine,
        out: &mut [f64],
    ) {
        self.find_members(scene, run);
        #[cfg(target_arch = "x86_64")]
        if has_wide_vectors() {
            #[allow(unsafe_code, reason = "wider vectors and fused operations: twice the speed")]
            // SAFETY: the processor has the instructions.
            unsafe {
                self.work_avx2(scene, state, run, combine, out);
            }
            return;
        }
        self.work_anywhere::<false>(scene, state, run, combine, out);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    #[allow(unsafe_code, reason = "wider vectors and fused operations: twice the speed")]
    unsafe fn work_avx2(
        &mut self,
        scene: &LatticeScene,
        state: &[f64],
        run: &Run,
        combine: Combine,
        out: &mut [f64],
    ) {
        self.work_anywhere::<true>(scene, state, run, combine, out);
    }

    #[inline(always)]
    fn work_anywhere<const FUSED: bool>(
        &mut self,
        scene: &LatticeScene,
        state: &[f64],
        run: &Run,
        combine: Combine,
        out: &mut [f64],
    ) {
        for (members, sum) in self.members.iter().zip(&mut self.sums) {
            if members.single(state, run, scene.reach).is_none() {
                gather(members, state, run, scene.reach, sum);
            }
        }
        let sums = self.members.iter().zip(&self.sums);
        let sums = sums.map(|(m, sum)| m.single(state, run, scene.reach).unwrap_or(sum)).collect();
        let around = Around { scene, state, run, members: &self.members, sums };
        around.add_up::<FUSED>(combine, &mut self.partial[..run.length], out);
        around.near_ends::<FUSED>(&self.ends, combine, out);
    }

    fn find_members(&mut self, scene: &LatticeScene, run: &Run) {
        let [nx, ny, nz] = scene.counts;
        let (y, z) = (run.first / nx % ny, run.first / (nx * ny));
        for (class, members) in scene.classes.iter().zip(&mut self.members) {
            members.lines.clear();
            for &[step_y, step_z] in &class.lines {
                let site_y = scene.edges[1].at(y as isize + step_y, ny);
                let site_z = scene.edges[2].at(z as isize + step_z, nz);
                if let (Some(y), Some(z)) = (site_y, site_z) {
                    let line = (z.index * ny + y.index) * nx;
                    members.lines.push((line + run.x, y.factor * z.factor));
                }
            }
            members.plain = members.lines.iter().all(|(_, factor)| *factor == 1.0);
        }
    }
}

impl Around<'_> {
    /// Writes the run as if lines had no ends.
    #[inline(always)]
    fn add_up<const FUSED: bool>(&self, combine: Combine, partial: &mut [f64], out: &mut [f64]) {
        match self.scene.reach {
            1 => self.add_classes::<1, FUSED>(combine, partial, out),
            2 => self.add_classes::<2, FUSED>(combine, partial, out),
            3 => self.add_classes::<3, FUSED>(combine, partial, out),
            _ => self.add_steps::<FUSED>(combine, partial, out),
        }
    }

    #[inline(always)]
    fn add_classes<const REACH: usize, const FUSED: bool>(
        &self,
        combine: Combine,
        partial: &mut [f64],
        out: &mut [f64],
    ) {
        let own = &self.state[self.run.first..][..self.run.length];
        let term = |c: usize| {
            let mut weights = [0.0; UNROLLED + 1];
            let of_class = &self.scene.classes[c].weights;
            weights[..of_class.len()].copy_from_slice(of_class);
            Term { sum: self.sums[c], count: self.members[c].lines.len() as f64, weights }
        };
        let count = self.sums.len();
        let (mut done, mut first) = (0, true);
        while count - done > CLASSES {
            let terms = [term(done), term(done + 1), term(done + 2)];
            add_terms::<CLASSES, REACH, FUSED>(partial, own, &terms, first, None);
            (done, first) = (done + CLASSES, false);
        }
        let last = Some((combine, out));
        match count - done {
            1 => add_terms::<1, REACH, FUSED>(partial, own, &[term(done)], first, last),
            2 => {
                let terms = [term(done), term(done + 1)];
                add_terms::<2, REACH, FUSED>(partial, own, &terms, first, last);
            }
            _ => {
                let terms = [term(done), term(done + 1), term(done + 2)];
                add_terms::<CLASSES, REACH, FUSED>(partial, own, &terms, first, last);
            }
        }
    }

    /// The same for any reach, a step of a class at a time.
    #[inline(always)]
    fn add_steps<const FUSED: bool>(&self, combine: Combine, partial: &mut [f64], out: &mut [f64]) {
        let (length, reach) = (self.run.length, self.scene.reach);
        let own = &self.state[self.run.first..][..length];
        let partial = &mut partial[..length];
        partial.fill(0.0);
        for ((class, members), sum) in self.scene.classes.iter().zip(self.members).zip(&self.sums) {
            for (step, &weight) in class.weights.iter().enumerate() {
                let lower = &sum[reach - step..][..length];
                let upper = &sum[reach + step..][..length];
                // The line itself counts once, as both.
                let weight = if step == 0 { 0.5 * weight } else { weight };
                let count = 2.0 * members.lines.len() as f64;
                for x in 0..length {
                    let both = lower[x] + upper[x];
                    let difference = multiply_add::<FUSED>(-count, own[x], both);
                    partial[x] = multiply_add::<FUSED>(weight, difference, partial[x]);
                }
            }
        }
        for x in 0..length {
            out[x] = multiply_add::<FUSED>(combine.scale, partial[x], combine.share * own[x]);
        }
    }

    /// Writes what is near the ends of lines again, with what lies past them.
    #[inline(always)]
    fn near_ends<const FUSED: bool>(&self, ends: &[NearEnd], combine: Combine, out: &mut [f64]) {
        let (nx, run) = (self.scene.counts[0], self.run);
        for end in ends {
            if !(run.x..run.x + run.length.min(nx)).contains(&end.x) {
                continue;
            }
            for local in (end.x - run.x..run.length).step_by(nx) {
                let own = self.state[run.first + local];
                let mut rate = 0.0;
                for entry in &end.entries {
                    let count = self.members[entry.class].lines.len() as f64;
                    let value = entry.factor * self.value(entry, local);
                    let difference = multiply_add::<FUSED>(-count, own, value);
                    rate = multiply_add::<FUSED>(entry.weight, difference, rate);
                }
                out[local] = multiply_add::<FUSED>(combine.scale, rate, combine.share * own);
            }
        }
    }

    /// R_c where `entry` says, from place `local` of the run.
    #[inline(always)]
    fn value(&self, entry: &Entry, local: usize) -> f64 {
        let reach = self.scene.reach;
        // The other end of a line that is longer than the run is not in it.
        if entry.further.unsigned_abs() <= reach || self.run.length >= self.scene.counts[0] {
            self.sums[entry.class][(reach + local).wrapping_add_signed(entry.further)]
        } else {
            self.members[entry.class].sum_at(local, entry.further, self.state)
        }
    }
}

/// A place near an end of a line, with everything that its rate is made of.
#[derive(Debug)]
struct NearEnd {
    x: usize,
    entries: Vec<Entry>,
}

/// w (factor R_c - n_c own), with R_c `further` along x.
#[derive(Debug)]
struct Entry {
    class: usize,
    further: isize,
    weight: f64,
    factor: f64,
}

impl NearEnd {
    /// The places near both ends of a line.
    fn all(scene: &LatticeScene) -> Vec<Self> {
        let (nx, reach) = (scene.counts[0], scene.reach);
        let lower = 0..reach.min(nx);
        let upper = (nx - reach.min(nx)).max(lower.end)..nx;
        let near = |x: usize| {
            let mut entries = Vec::new();
            for (class, of_class) in scene.classes.iter().enumerate() {
                for (step, &weight) in of_class.weights.iter().enumerate() {
                    let steps: &[isize] = if step == 0 { &[0] } else { &[-1, 1] };
                    for sign in steps {
                        let there = x as isize + sign * step as isize;
                        if let Some(site) = scene.edges[0].at(there, nx).filter(|_| weight != 0.0) {
                            let further = site.index as isize - x as isize;
                            entries.push(Entry { class, further, weight, factor: site.factor });
                        }
                    }
                }
            }
            Self { x, entries }
        };
        lower.chain(upper).map(near).collect()
    }
}

/// Writes the sum of the lines of a class along a run, with `reach` values more on either side.
/// Values there that belong to no line of the lattice are of no use, and 0.
#[inline(always)]
fn gather(members: &Members, state: &[f64], run: &Run, reach: usize, sum: &mut [f64]) {
    let sum = &mut sum[..run.length + 2 * reach];
    let nearest = members.lines.iter().map(|line| line.0).min().unwrap_or(0);
    let farthest = members.lines.iter().map(|line| line.0).max().unwrap_or(0);
    let before = reach.min(nearest);
    let after = reach.min(state.len() - farthest - run.length);
    let (head, rest) = sum.split_at_mut(reach - before);
    let (inner, tail) = rest.split_at_mut(before + run.length + after);
    head.fill(0.0);
    tail.fill(0.0);
    let range = |k: usize| -> Range<usize> {
        let line = members.lines[k].0;
        line - before..line + run.length + after
    };
    let line = |k: usize| &state[range(k)];
    if members.plain {
        add_plain(inner, members.lines.len(), line);
    } else {
        inner.fill(0.0);
        for (k, (_, factor)) in members.lines.iter().enumerate() {
            inner.iter_mut().zip(line(k)).for_each(|(sum, value)| *sum += factor * value);
        }
    }
}

/// Sums `count` lines, up to four at once.
#[inline(always)]
fn add_plain<'a>(sum: &mut [f64], count: usize, line: impl Fn(usize) -> &'a [f64]) {
    let n = sum.len();
    let mut done = match count {
        0 => {
            sum.fill(0.0);
            0
        }
        1 => {
            sum.copy_from_slice(line(0));
            1
        }
        2 | 3 => {
            let [a, b] = [0, 1].map(|k| &line(k)[..n]);
            for x in 0..n {
                sum[x] = a[x] + b[x];
            }
            2
        }
        _ => {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| &line(k)[..n]);
            for x in 0..n {
                sum[x] = (a[x] + b[x]) + (c[x] + d[x]);
            }
            4
        }
    };
    while done + 4 <= count {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| &line(done + k)[..n]);
        for x in 0..n {
            sum[x] += (a[x] + b[x]) + (c[x] + d[x]);
        }
        done += 4;
    }
    for k in done..count {
        sum.iter_mut().zip(line(k)).for_each(|(sum, value)| *sum += value);
    }
}

/// Adds some terms to what is in `partial`, or to nothing with `first`; the sum goes back there, or
/// combined to `last`.
#[inline(always)]
fn add_terms<const N: usize, const REACH: usize, const FUSED: bool>(
    partial: &mut [f64],
    own: &[f64],
    terms: &[Term<'_>; N],
    first: bool,
    last: Option<(Combine, &mut [f64])>,
) {
    let n = own.len();
    let mut terms = *terms;
    for term in &mut terms {
        term.sum = &term.sum[..n + 2 * REACH];
    }
    let partial = &mut partial[..n];
    match (first, last) {
        (true, None) => {
            for x in 0..n {
                partial[x] = sum_of::<N, REACH, FUSED>(&terms, own[x], x, 0.0);
            }
        }
        (false, None) => {
            for x in 0..n {
                partial[x] = sum_of::<N, REACH, FUSED>(&terms, own[x], x, partial[x]);
            }
        }
        (true, Some((Combine { share, scale }, out))) => {
            let out = &mut out[..n];
            for x in 0..n {
                let rate = sum_of::<N, REACH, FUSED>(&terms, own[x], x, 0.0);
                out[x] = multiply_add::<FUSED>(scale, rate, share * own[x]);
            }
        }
        (false, Some((Combine { share, scale }, out))) => {
            let out = &mut out[..n];
            for x in 0..n {
                let rate = sum_of::<N, REACH, FUSED>(&terms, own[x], x, partial[x]);
                out[x] = multiply_add::<FUSED>(scale, rate, share * own[x]);
            }
        }
    }
}

/// `sum` and the terms at `x`. A function and no closure, which would be compiled without the
/// instructions of its caller.
#[inline(always)]
fn sum_of<const N: usize, const REACH: usize, const FUSED: bool>(
    terms: &[Term<'_>; N],
    own: f64,
    x: usize,
    mut sum: f64,
) -> f64 {
    for term in terms {
        let Term { sum: values, count, weights } = term;
        let center = multiply_add::<FUSED>(-count, own, values[x + REACH]);
        sum = multiply_add::<FUSED>(weights[0], center, sum);
        for step in 1..=REACH {
            let both = values[x + REACH - step] + values[x + REACH + step];
            let difference = multiply_add::<FUSED>(-2.0 * count, own, both);
            sum = multiply_add::<FUSED>(weights[step], difference, sum);
        }
    }
    sum
}

/// Whether the processor has the wider vectors and fused multiplications (AVX2 and FMA) that the
/// stencil uses where it can.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(in crate::solver) fn has_wide_vectors() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

/// a b + c, rounded once with `FUSED`.
#[inline(always)]
fn multiply_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}
