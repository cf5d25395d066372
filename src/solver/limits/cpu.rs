//! What the CPU can do at most, in f64 and on every thread of the pool that runs use.

use std::convert::Infallible;
use std::hint::black_box;
use std::time::Duration;

use rayon::prelude::*;

use super::Limits;
#[cfg(target_arch = "x86_64")]
use crate::model::wide::has_wide_vectors;
use crate::model::wide::{self, CACHE_LINE, Work, prefetch};
use crate::solver::Timing;

/// The largest array that is copied, bytes: far more than any cache holds.
const MOST_COPIED: u64 = 512 << 20;

/// Places that a thread reads from side by side.
const STREAMS: usize = 4;

/// Lines ahead of the one at hand that are fetched: a page, as rows of a matrix do.
const AHEAD: usize = 64 * CACHE_LINE;

/// Chains that a thread works on where vectors are wide: enough for every unit to have one to go on
/// with, and as many as registers hold.
#[cfg(target_arch = "x86_64")]
const WIDE_CHAINS: usize = 48;

/// The same elsewhere.
const CHAINS: usize = 16;

/// Operations of a link of a chain.
const OPERATIONS: usize = 2;

/// Links that each chain gets at a time.
const BLOCK: u64 = 8;

/// Links that are timed as one.
const LINKS: u64 = 125 * BLOCK;

pub(super) fn measure(least: Duration, most: u64) -> Limits {
    let threads = rayon::current_num_threads();
    let computed = (threads * chain_count() * OPERATIONS) as f64 * LINKS as f64;
    let (copy, copy_one_thread) = copy(least, most, threads);
    Limits {
        copy,
        copy_one_thread: Some(copy_one_thread),
        read: Some(read(least, most, threads)),
        arithmetic: computed / compute(least),
    }
}

/// The instructions that the stencil and the chains are made of, chosen at run time.
pub fn instructions() -> &'static str {
    match has_wide_vectors() {
        true => "AVX2 and FMA",
        false => "the least that this architecture has",
    }
}

/// Bytes a second on as many threads as are best, and on one.
fn copy(least: Duration, most: u64, threads: usize) -> (f64, f64) {
    let before = numbers(most);
    let length = before.len();
    let mut after = vec![0.0; length];
    // A piece a thread: a system's own copy passes caches by where a piece is large.
    let piece = length.div_ceil(threads);
    let everywhere = timed(least, || {
        let pieces = after.par_chunks_mut(piece).zip(before.par_chunks(piece));
        pieces.for_each(|(after, before)| black_box(after).copy_from_slice(before));
    });
    let on_one = match threads {
        1 => everywhere,
        _ => timed(least, || black_box(&mut *after).copy_from_slice(&before)),
    };
    let bytes = 16.0 * length as f64;
    // One thread may be as fast as all: then so is the machine.
    (bytes / everywhere.min(on_one), bytes / on_one)
}

/// Bytes a second on every thread.
fn read(least: Duration, most: u64, threads: usize) -> f64 {
    let values = numbers(most);
    let piece = values.len().div_ceil(threads);
    let sum = |piece: &[f64]| wide::run(Sum(black_box(piece)));
    let seconds = timed(least, || {
        black_box(values.par_chunks(piece).map(sum).sum::<f64>());
    });
    8.0 * values.len() as f64 / seconds
}

/// 0, 1, 2 and so on in `most` bytes, within reason.
fn numbers(most: u64) -> Vec<f64> {
    let length = (most.min(MOST_COPIED) / 8).max(1) as usize;
    (0..length).into_par_iter().map(|i| i as f64).collect()
}

/// The sum of values, each of which is read once.
struct Sum<'a>(&'a [f64]);

impl Work for Sum<'_> {
    type Output = f64;

    /// From several places at a time, which is faster than from one.
    #[inline(always)]
    fn run<const FUSED: bool>(self) -> f64 {
        let part = self.0.len() / STREAMS / CACHE_LINE * CACHE_LINE;
        let (parts, rest) = self.0.split_at(STREAMS * part);
        let mut sums = [[0.0; CACHE_LINE]; STREAMS];
        for first in (0..part).step_by(CACHE_LINE) {
            for (stream, sums) in sums.iter_mut().enumerate() {
                let line = &parts[stream * part + first..][..CACHE_LINE];
                prefetch(line.as_ptr().wrapping_add(AHEAD));
                sums.iter_mut().zip(line).for_each(|(sum, value)| *sum += value);
            }
        }
        sums.as_flattened().iter().chain(rest).sum()
    }
}

/// Seconds that [`LINKS`] links take on every thread at once.
fn compute(least: Duration) -> f64 {
    let work = |count| {
        rayon::broadcast(|_| black_box(chains(count * LINKS, black_box(-0.999), black_box(1.0))));
        Ok::<_, Infallible>(())
    };
    let Ok(timing) = Timing::of(least, work);
    timing.best()
}

fn timed(least: Duration, mut work: impl FnMut()) -> f64 {
    let repeat = |count| {
        (0..count).for_each(|_| work());
        Ok::<_, Infallible>(())
    };
    let Ok(timing) = Timing::of(least, repeat);
    timing.best()
}

/// How many chains a thread works on.
fn chain_count() -> usize {
    if has_wide_vectors() { WIDE_CHAINS } else { CHAINS }
}

/// The sum of the ends of chains of `links` links x -> `factor` x + `addend` from 0, 1, 2 ... on;
/// `links` is a multiple of [`BLOCK`]. Every chain starts elsewhere, or one would do for all.
fn chains(links: u64, factor: f64, addend: f64) -> f64 {
    #[cfg(target_arch = "x86_64")]
    if has_wide_vectors() {
        #[allow(unsafe_code, reason = "the limit of the instructions that the stencil uses")]
        // SAFETY: the processor has the instructions.
        return unsafe { chains_avx2(links, factor, addend) };
    }
    chains_anywhere(links, factor, addend)
}

/// Vectors by name: compilers make none of the loops below that stays in registers.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn chains_avx2(links: u64, factor: f64, addend: f64) -> f64 {
    use std::arch::x86_64::{_mm256_fmadd_pd, _mm256_set1_pd, _mm256_setr_pd};
    let [factor, addend] = [_mm256_set1_pd(factor), _mm256_set1_pd(addend)];
    let mut ends = [addend; WIDE_CHAINS / 4];
    for (i, end) in ends.iter_mut().enumerate() {
        let [a, b, c, d] = [0, 1, 2, 3].map(|lane| (4 * i + lane) as f64);
        *end = _mm256_setr_pd(a, b, c, d);
    }
    for _ in 0..links {
        for end in &mut ends {
            *end = _mm256_fmadd_pd(factor, *end, addend);
        }
    }
    bytemuck::cast_slice::<_, f64>(&ends).iter().sum()
}

fn chains_anywhere(links: u64, factor: f64, addend: f64) -> f64 {
    let mut ends = [0.0; CHAINS];
    ends.iter_mut().enumerate().for_each(|(i, end)| *end = i as f64);
    for _ in 0..links / BLOCK {
        for end in &mut ends {
            for _ in 0..BLOCK {
                *end = factor * *end + addend;
            }
        }
    }
    ends.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the ends of `count` chains add up to: the fixed point, and what is left of each start's
    /// distance from it.
    fn sum(count: usize, links: u64, factor: f64, addend: f64) -> f64 {
        let rest = addend / (1.0 - factor);
        let left = factor.powi(links as i32);
        (0..count).map(|i| rest + left * (i as f64 - rest)).sum()
    }

    #[test]
    fn chains_do_all_their_links() {
        type Way = fn(u64, f64, f64) -> f64;
        let ways: [(Way, usize); 2] = [(chains, chain_count()), (chains_anywhere, CHAINS)];
        for (way, count) in ways {
            for links in [0, BLOCK, 3 * BLOCK, LINKS] {
                let found = way(links, -0.999, 1.0);
                let off = |links| (found / sum(count, links, -0.999, 1.0) - 1.0).abs();
                assert!(off(links) < 1e-12, "{links} links: {found}");
                assert!(off(links + 1) > 1e-4, "a link more or less is noticed");
            }
        }
    }

    #[test]
    fn every_value_is_read() {
        for length in [0_u32, 1, 31, 32, 33, 100, 1000] {
            let values: Vec<f64> = (0..length).map(f64::from).collect();
            let all = f64::from(length) * (f64::from(length) - 1.0) / 2.0;
            assert_eq!(wide::run(Sum(&values)), all.max(0.0));
        }
    }

    #[test]
    fn limits_are_those_of_a_computer() {
        let limits = measure(Duration::from_millis(5), 1 << 22);
        let one = limits.copy_one_thread.expect("a CPU has threads");
        let read = limits.read.expect("a CPU reads");
        assert!(limits.copy > 1e7 && one > 1e7 && read > 1e7, "{limits:?}");
        // No processor does a hundred operations a tick of 10 GHz.
        let most = 1e12 * rayon::current_num_threads() as f64;
        assert!((1e7..most).contains(&limits.arithmetic), "{limits:?}");
    }
}
