//! The stencil along a line of a lattice, on the CPU.
//!
//! The rate of a particle is the sum over classes c of lines parallel to x, and over steps i along
//! them, of w_ci (R_c(x - i) + R_c(x + i) - 2 n_c C(x)), where R_c is the sum of the n_c lines of a
//! class: each line is read once, and the sums go along x, where the processor takes several values
//! at once. Differences, not a diagonal: a constant field has rate 0.

use std::ops::Range;

use crate::model::lattice::LatticeScene;

/// Values of a line that are worked on together: what lies around them stays in the fastest cache.
pub(super) const BLOCK: usize = 512;

/// Where the lines of a class are around a line, with the factors of their values.
#[derive(Debug, Default)]
struct Members {
    /// First value of each line and its factor.
    lines: Vec<(usize, f64)>,
    /// Whether every factor is 1.
    plain: bool,
}

/// What working on a block needs.
#[derive(Debug)]
pub(super) struct Scratch {
    members: Vec<Members>,
    /// R_c of each class, with `reach` values more on either side.
    sums: Vec<Vec<f64>>,
    /// The rate of each value of the block.
    pub(super) rate: Vec<f64>,
}

impl Scratch {
    pub(super) fn new(scene: &LatticeScene) -> Self {
        let classes = scene.classes.len();
        Self {
            members: (0..classes).map(|_| Members::default()).collect(),
            sums: vec![vec![0.0; BLOCK + 2 * scene.reach]; classes],
            rate: vec![0.0; BLOCK],
        }
    }

    /// Finds the lines around the line at `y`, `z`.
    pub(super) fn enter_line(&mut self, scene: &LatticeScene, y: usize, z: usize) {
        let [nx, ny, nz] = scene.counts;
        for (class, members) in scene.classes.iter().zip(&mut self.members) {
            members.lines.clear();
            for &[step_y, step_z] in &class.lines {
                let site_y = scene.edges[1].at(y as isize + step_y, ny);
                let site_z = scene.edges[2].at(z as isize + step_z, nz);
                if let (Some(y), Some(z)) = (site_y, site_z) {
                    members.lines.push(((z.index * ny + y.index) * nx, y.factor * z.factor));
                }
            }
            members.plain = members.lines.iter().all(|(_, factor)| *factor == 1.0);
        }
    }

    /// Computes the rates of the values `along` x, at most [`BLOCK`], of the line entered last.
    pub(super) fn block(&mut self, scene: &LatticeScene, state: &[f64], along: Range<usize>) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            #[allow(unsafe_code, reason = "wider vectors; the results are the same to the bit")]
            // SAFETY: the processor has the instructions.
            unsafe {
                self.block_avx2(scene, state, along);
            }
            return;
        }
        self.block_anywhere(scene, state, along);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[allow(unsafe_code, reason = "wider vectors; the results are the same to the bit")]
    unsafe fn block_avx2(&mut self, scene: &LatticeScene, state: &[f64], along: Range<usize>) {
        self.block_anywhere(scene, state, along);
    }

    #[inline(always)]
    fn block_anywhere(&mut self, scene: &LatticeScene, state: &[f64], along: Range<usize>) {
        let (length, reach) = (along.len(), scene.reach);
        for (members, sum) in self.members.iter().zip(&mut self.sums) {
            members.gather(scene, state, &along, &mut sum[..length + 2 * reach]);
        }
        // The first class is the line itself.
        let own = &self.sums[0][reach..reach + length];
        let rate = &mut self.rate[..length];
        rate.fill(0.0);
        for ((class, members), sum) in scene.classes.iter().zip(&self.members).zip(&self.sums) {
            let count = members.lines.len() as f64;
            for (step, &weight) in class.weights.iter().enumerate() {
                let lower = &sum[reach - step..][..length];
                let upper = &sum[reach + step..][..length];
                if weight == 0.0 || members.lines.is_empty() {
                    continue;
                } else if step == 0 {
                    add_center(rate, own, lower, weight, count);
                } else {
                    add_pair(rate, own, lower, upper, weight, 2.0 * count);
                }
            }
        }
        // Past a free end there is nothing, not even a 0.
        let nx = scene.counts[0];
        if scene.edges[0].is_free(false) {
            self.near_free_end(scene, &along, along.start..reach.min(along.end));
        }
        if scene.edges[0].is_free(true) {
            let near = nx.saturating_sub(reach).max(along.start);
            self.near_free_end(scene, &along, near..along.end);
        }
    }

    /// Computes the rates at `near` again, where the stencil reaches past a free end.
    fn near_free_end(&mut self, scene: &LatticeScene, along: &Range<usize>, near: Range<usize>) {
        let (nx, reach) = (scene.counts[0], scene.reach);
        let [lower_free, upper_free] = [false, true].map(|upper| scene.edges[0].is_free(upper));
        for x in near {
            let local = reach + x - along.start;
            let own = self.sums[0][local];
            let mut rate = 0.0;
            for ((class, members), sum) in scene.classes.iter().zip(&self.members).zip(&self.sums) {
                let all = members.lines.len() as f64 * own;
                for (step, &weight) in class.weights.iter().enumerate() {
                    if x >= step || !lower_free {
                        rate += weight * (sum[local - step] - all);
                    }
                    if step > 0 && (x + step < nx || !upper_free) {
                        rate += weight * (sum[local + step] - all);
                    }
                }
            }
            self.rate[x - along.start] = rate;
        }
    }
}

impl Members {
    /// Writes the sum of the lines `along` x, with `reach` values more on either side; past a free
    /// end these are 0.
    #[inline(always)]
    fn gather(&self, scene: &LatticeScene, state: &[f64], along: &Range<usize>, sum: &mut [f64]) {
        let (nx, reach) = (scene.counts[0], scene.reach);
        let first = along.start.saturating_sub(reach);
        let last = (along.end + reach).min(nx);
        let before = first + reach - along.start;
        let inner = &mut sum[before..before + last - first];
        let line = |k: usize| &state[self.lines[k].0 + first..self.lines[k].0 + last];
        if self.plain {
            add_plain(inner, self.lines.len(), line);
        } else {
            inner.fill(0.0);
            for (k, (_, factor)) in self.lines.iter().enumerate() {
                inner.iter_mut().zip(line(k)).for_each(|(sum, value)| *sum += factor * value);
            }
        }
        let past = |x: isize| {
            let Some(site) = scene.edges[0].at(x, nx) else {
                return 0.0;
            };
            let values = self.lines.iter().map(|&(start, f)| f * state[start + site.index]);
            site.factor * values.sum::<f64>()
        };
        for (k, value) in sum[..before].iter_mut().enumerate() {
            *value = past((along.start + k) as isize - reach as isize);
        }
        for (k, value) in sum[before + last - first..].iter_mut().enumerate() {
            *value = past((last + k) as isize);
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
            (0..n).for_each(|x| sum[x] = a[x] + b[x]);
            2
        }
        _ => {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| &line(k)[..n]);
            (0..n).for_each(|x| sum[x] = (a[x] + b[x]) + (c[x] + d[x]));
            4
        }
    };
    while done + 4 <= count {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| &line(done + k)[..n]);
        (0..n).for_each(|x| sum[x] += (a[x] + b[x]) + (c[x] + d[x]));
        done += 4;
    }
    for k in done..count {
        sum.iter_mut().zip(line(k)).for_each(|(sum, value)| *sum += value);
    }
}

/// rate += weight (sum - count own)
#[inline(always)]
fn add_center(rate: &mut [f64], own: &[f64], sum: &[f64], weight: f64, count: f64) {
    let n = rate.len();
    let (own, sum) = (&own[..n], &sum[..n]);
    (0..n).for_each(|x| rate[x] += weight * (sum[x] - count * own[x]));
}

/// rate += weight (lower + upper - count own)
#[inline(always)]
fn add_pair(rate: &mut [f64], own: &[f64], lower: &[f64], upper: &[f64], weight: f64, count: f64) {
    let n = rate.len();
    let (own, lower, upper) = (&own[..n], &lower[..n], &upper[..n]);
    (0..n).for_each(|x| rate[x] += weight * ((lower[x] + upper[x]) - count * own[x]));
}
