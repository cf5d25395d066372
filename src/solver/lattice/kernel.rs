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
//! Where the processor has them, wider vectors and fused multiplications are used, so that the last
//! bits of a result depend on the processor; they do not depend on the number of threads.

use std::ops::Range;

use crate::model::lattice::LatticeScene;

/// Values that are worked on together: what lies around them stays in the fastest cache.
const BLOCK: usize = 2048;

/// The widest reach of a stencil.
const WIDEST: usize = 4;

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
        let (x, y, z) = (first % nx, first / nx % ny, first / (nx * ny));
        let within =
            |place: usize, count: usize| place >= scene.reach && place + scene.reach < count;
        let is_inside = (ny == 1 || within(y, ny)) && (nz == 1 || within(z, nz));
        let lines = match x == 0 && is_inside {
            true => (BLOCK / nx).min(ny.saturating_sub(y + scene.reach)).min(most / nx).max(1),
            false => 1,
        };
        let length = if lines > 1 { lines * nx } else { (nx - x).min(BLOCK).min(most) };
        Self { first, length, x, is_inside }
    }
}

/// What is written at each site: `share` C + `scale` x rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Combine {
    pub(super) share: f64,
    pub(super) scale: f64,
}

/// The lines around a run, but for its own: for each its class, and the site that is beside the
/// first of the run. Those of one class go together, as far as there are enough.
#[derive(Debug, Default)]
struct Members {
    fours: Vec<(usize, [usize; 4])>,
    twos: Vec<(usize, [usize; 2])>,
    /// With the factor of their values, since ghosts are among them.
    ones: Vec<(usize, usize, f64)>,
    /// K_i
    along: [f64; WIDEST + 1],
}

/// What working on a run needs.
#[derive(Debug)]
pub(super) struct Scratch {
    members: Members,
    /// The first site of the run that the members are of, if it is inside.
    members_of: Option<usize>,
    /// Lines of a class whose values count as they are.
    plain: Vec<usize>,
    /// P_0, Q_1, Q_2, ... from `reach` before the run on.
    sums: Vec<Vec<f64>>,
    ends: Vec<NearEnd>,
}

/// A place near an end of a line, with the places along it that add to its rate.
#[derive(Debug)]
struct NearEnd {
    x: usize,
    terms: Vec<AlongLine>,
}

/// What is `step` sites along a line: a site `further` along, times a factor.
#[derive(Debug)]
struct AlongLine {
    step: usize,
    further: isize,
    factor: f64,
}

impl Scratch {
    pub(super) fn new(scene: &LatticeScene) -> Self {
        Self {
            members: Members::default(),
            members_of: None,
            plain: Vec::new(),
            sums: vec![vec![0.0; BLOCK + 2 * scene.reach]; scene.reach + 1],
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
        self.find_members(scene, run);
        let around = Around { scene, state, run, members: &self.members };
        match scene.reach {
            1 => around.work::<1, FUSED>(&mut self.sums, &self.ends, combine, out),
            2 => around.work::<2, FUSED>(&mut self.sums, &self.ends, combine, out),
            3 => around.work::<3, FUSED>(&mut self.sums, &self.ends, combine, out),
            WIDEST => around.work::<WIDEST, FUSED>(&mut self.sums, &self.ends, combine, out),
            _ => around.work::<0, FUSED>(&mut self.sums, &self.ends, combine, out),
        }
    }

    fn find_members(&mut self, scene: &LatticeScene, run: &Run) {
        let Self { members, members_of, plain, .. } = self;
        match members_of.replace(run.first).filter(|_| run.is_inside) {
            // Inside, the same lines are around every run.
            Some(before) => return members.shift(run.first.wrapping_sub(before)),
            None => *members_of = run.is_inside.then_some(run.first),
        }
        let [nx, ny, nz] = scene.counts;
        let (y, z) = (run.first / nx % ny, run.first / (nx * ny));
        members.clear();
        for (c, class) in scene.classes.iter().enumerate() {
            plain.clear();
            let mut count = 0.0;
            for &[step_y, step_z] in &class.lines {
                let site_y = scene.edges[1].at(y as isize + step_y, ny);
                let site_z = scene.edges[2].at(z as isize + step_z, nz);
                let (Some(y), Some(z)) = (site_y, site_z) else {
                    continue;
                };
                count += 1.0;
                let line = (z.index * ny + y.index) * nx + run.x;
                match y.factor * z.factor {
                    // Of the line itself there is no difference.
                    _ if (step_y, step_z) == (0, 0) => {}
                    1.0 => plain.push(line),
                    factor => members.ones.push((c, line, factor)),
                }
            }
            members.add(c, plain);
            for (along, weight) in members.along.iter_mut().zip(&class.weights) {
                *along += weight * count;
            }
        }
    }
}

/// What a run reads.
struct Around<'a> {
    scene: &'a LatticeScene,
    state: &'a [f64],
    run: &'a Run,
    members: &'a Members,
}

impl Around<'_> {
    #[inline(always)]
    fn work<const REACH: usize, const FUSED: bool>(
        &self,
        sums: &mut [Vec<f64>],
        ends: &[NearEnd],
        combine: Combine,
        out: &mut [f64],
    ) {
        self.add_lines::<REACH, FUSED>(sums);
        self.add_along::<REACH, FUSED>(sums, combine, out);
        self.near_ends(sums, ends, combine, out);
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
        let mut target = Target::<REACH> {
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
            target.add::<2, 4, FUSED>(&lines, 1.0, &[weights(a), weights(b)]);
        }
        for &(class, four) in pairs.remainder() {
            target.add::<1, 4, FUSED>(&[four.map(beside)], 1.0, &[weights(class)]);
        }
        for &(class, two) in twos {
            target.add::<1, 2, FUSED>(&[two.map(beside)], 1.0, &[weights(class)]);
        }
        for &(class, line, factor) in ones {
            target.add::<1, 1, FUSED>(&[[beside(line)]], factor, &[weights(class)]);
        }
        if target.is_new {
            target.add::<0, 1, FUSED>(&[], 1.0, &[]);
        }
    }

    /// Writes the run as if lines had no ends.
    #[inline(always)]
    fn add_along<const REACH: usize, const FUSED: bool>(
        &self,
        sums: &[Vec<f64>],
        combine: Combine,
        out: &mut [f64],
    ) {
        // What is left out at either end of the lattice is near the end of a line.
        let run = self.run;
        let lower = REACH.saturating_sub(run.first).min(run.length);
        let upper = run.length.min((self.state.len() - run.first).saturating_sub(REACH)).max(lower);
        let length = upper - lower;
        if length == 0 {
            return;
        }
        let own = &self.state[run.first + lower..][..length];
        let here = &sums[0][lower + REACH..][..length];
        let steps: [&[f64]; REACH] =
            std::array::from_fn(|k| &sums[k + 1][lower..][..length + 2 * REACH]);
        let along: [f64; REACH] = std::array::from_fn(|k| self.members.along[k + 1]);
        let out = &mut out[lower..upper];
        let Combine { share, scale } = combine;
        for x in 0..length {
            let own = own[x];
            let mut rate = here[x];
            for k in 0..REACH {
                let both = steps[k][x + REACH - 1 - k] + steps[k][x + REACH + 1 + k];
                rate += multiply_add::<FUSED>(-2.0, along[k] * own, both);
            }
            out[x] = multiply_add::<FUSED>(scale, rate, share * own);
        }
    }

    /// Writes what is near the ends of lines again, with what lies past them.
    #[inline(always)]
    fn near_ends(&self, sums: &[Vec<f64>], ends: &[NearEnd], combine: Combine, out: &mut [f64]) {
        let (nx, reach, run) = (self.scene.counts[0], self.scene.reach, self.run);
        let needed = self.needed();
        for end in ends {
            if !(run.x..run.x + run.length.min(nx)).contains(&end.x) {
                continue;
            }
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
                out[local] = combine.scale * rate + combine.share * own;
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

impl Members {
    fn clear(&mut self) {
        self.fours.clear();
        self.twos.clear();
        self.ones.clear();
        self.along.fill(0.0);
    }

    /// Moves all lines by some sites; those before wrap around.
    fn shift(&mut self, sites: usize) {
        let move_by = |line: &mut usize| *line = line.wrapping_add(sites);
        self.fours.iter_mut().flat_map(|(_, lines)| lines).for_each(move_by);
        self.twos.iter_mut().flat_map(|(_, lines)| lines).for_each(move_by);
        self.ones.iter_mut().for_each(|(_, line, _)| move_by(line));
    }

    /// Adds lines of a class whose values count as they are.
    fn add(&mut self, class: usize, lines: &[usize]) {
        let mut rest = lines;
        while let &[a, b, c, d, ref more @ ..] = rest {
            self.fours.push((class, [a, b, c, d]));
            rest = more;
        }
        if let &[a, b, ref more @ ..] = rest {
            self.twos.push((class, [a, b]));
            rest = more;
        }
        self.ones.extend(rest.iter().map(|&one| (class, one, 1.0)));
    }
}

impl NearEnd {
    /// The places near both ends of a line.
    fn all(scene: &LatticeScene) -> Vec<Self> {
        let (nx, reach) = (scene.counts[0], scene.reach);
        let lower = 0..reach.min(nx);
        let upper = (nx - reach.min(nx)).max(lower.end)..nx;
        let near = |x: usize| {
            let mut terms = Vec::new();
            for step in 1..=reach {
                for there in [x as isize - step as isize, (x + step) as isize] {
                    if let Some(site) = scene.edges[0].at(there, nx) {
                        let further = site.index as isize - x as isize;
                        terms.push(AlongLine { step, further, factor: site.factor });
                    }
                }
            }
            Self { x, terms }
        };
        lower.chain(upper).map(near).collect()
    }
}

/// What the differences to lines are added to.
struct Target<'a, const REACH: usize> {
    own: &'a [f64],
    /// P_0
    here: &'a mut [f64],
    /// Q_1, Q_2, ...
    steps: [&'a mut [f64]; REACH],
    /// K_1, K_2, ...
    along: [f64; REACH],
    /// Whether nothing has been written.
    is_new: bool,
}

impl<const REACH: usize> Target<'_, REACH> {
    /// Adds some groups of N lines, each with its weights and the factor of its values.
    #[inline(always)]
    fn add<const GROUPS: usize, const N: usize, const FUSED: bool>(
        &mut self,
        lines: &[[&[f64]; N]; GROUPS],
        factor: f64,
        weights: &[[f64; WIDEST + 1]; GROUPS],
    ) {
        match std::mem::take(&mut self.is_new) {
            true => self.write::<GROUPS, N, true, FUSED>(lines, factor, weights),
            false => self.write::<GROUPS, N, false, FUSED>(lines, factor, weights),
        }
    }

    #[inline(always)]
    fn write<const GROUPS: usize, const N: usize, const NEW: bool, const FUSED: bool>(
        &mut self,
        lines: &[[&[f64]; N]; GROUPS],
        factor: f64,
        weights: &[[f64; WIDEST + 1]; GROUPS],
    ) {
        // No closures where it counts: they would be compiled without the caller's instructions.
        let n = self.own.len();
        let (own, here, along) = (&self.own[..n], &mut self.here[..n], self.along);
        let steps = self.steps.each_mut().map(|sum| &mut sum[..n]);
        let lines = lines.map(|group| group.map(|line| &line[..n]));
        for x in 0..n {
            let own = own[x];
            let mut sums = [0.0; WIDEST + 1];
            if NEW {
                for k in 0..REACH {
                    sums[k + 1] = along[k] * own;
                }
            } else {
                sums[0] = here[x];
                for k in 0..REACH {
                    sums[k + 1] = steps[k][x];
                }
            }
            for group in 0..GROUPS {
                let sum = sum_of(&lines[group], x);
                // Some equal values have a sum whose difference to as many times one is 0.
                let difference = match N {
                    1 => multiply_add::<FUSED>(factor, sum, -own),
                    _ => multiply_add::<FUSED>(-(N as f64), own, sum),
                };
                for k in 0..REACH + 1 {
                    sums[k] = multiply_add::<FUSED>(weights[group][k], difference, sums[k]);
                }
            }
            here[x] = sums[0];
            for k in 0..REACH {
                steps[k][x] = sums[k + 1];
            }
        }
    }
}

/// The sum of one, two or four lines at a place: of equal values without a rounding error.
#[inline(always)]
fn sum_of<const N: usize>(lines: &[&[f64]; N], x: usize) -> f64 {
    match N {
        4 => (lines[0][x] + lines[1][x]) + (lines[2][x] + lines[3][x]),
        2 => lines[0][x] + lines[1][x],
        _ => lines[0][x],
    }
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
