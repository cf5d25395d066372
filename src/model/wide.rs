//! Work compiled twice: for any processor, and for one that has wider vectors and multiplies and adds
//! with one rounding (AVX2 and FMA).
//!
//! Which of the two runs decides the last bits of a result, so that these depend on the processor;
//! they do not depend on the number of threads.

/// Work that is faster on wider vectors. Everything that it calls where it counts has to be inlined,
/// closures too: what is compiled by itself is compiled for any processor.
pub trait Work {
    /// What it gives.
    type Output;

    /// Does it; with `FUSED`, by [`multiply_add`] with one rounding, which is slow where the
    /// processor has no instruction for it. To be marked `#[inline(always)]`.
    fn run<const FUSED: bool>(self) -> Self::Output;
}

/// Does `work` as this processor does it best.
#[inline]
pub fn run<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if has_wide_vectors() {
        #[allow(unsafe_code, reason = "twice the speed of a stencil, a tenth of that of rows")]
        // SAFETY: the processor has the instructions.
        return unsafe { run_wide(work) };
    }
    work.run::<false>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
#[allow(unsafe_code, reason = "twice the speed of a stencil, a tenth of that of rows")]
unsafe fn run_wide<W: Work>(work: W) -> W::Output {
    work.run::<true>()
}

/// Whether the processor has the wider vectors and fused multiplications.
#[inline]
pub fn has_wide_vectors() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// a b + c, rounded once with `FUSED`.
#[inline(always)]
pub fn multiply_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// One or the other of two numbers, without a branch, so that processors work on several at once.
#[inline(always)]
pub fn choose(first: bool, one: f64, other: f64) -> f64 {
    let mask = u64::from(first).wrapping_neg();
    f64::from_bits((mask & one.to_bits()) | (!mask & other.to_bits()))
}

/// Whether any of some numbers is negative, by their bits, which processors put together for several at once.
#[inline(always)]
pub fn any_signs<const COUNT: usize>(bits: [u64; COUNT]) -> bool {
    bits.into_iter().fold(0, |any, bits| any | bits) >> 63 != 0
}

/// The sum of what was added up side by side: one after the other. If it were added in pairs, compilers would split the
/// loop before it in halves too, and work on two values at once in place of four.
#[inline(always)]
pub fn sum_of(lanes: [f64; 4]) -> f64 {
    lanes.iter().sum()
}

/// Values of a line of a cache.
pub const CACHE_LINE: usize = 8;

/// Has the processor fetch the line at `address` for a read to come; where nothing lies there, nothing
/// happens.
#[inline(always)]
#[allow(
    unsafe_code,
    reason = "rows are a sixth faster: processors do not fetch ahead across pages"
)]
pub fn prefetch<T>(address: *const T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every processor of this kind has the instruction, and it takes any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(address.cast()) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Product(f64);

    impl Work for Product {
        type Output = f64;

        #[inline(always)]
        fn run<const FUSED: bool>(self) -> f64 {
            multiply_add::<FUSED>(self.0, self.0, -self.0 * self.0)
        }
    }

    #[test]
    fn a_fused_product_keeps_what_rounding_takes_away() {
        let value = 1.0 + f64::EPSILON;
        assert_eq!(Product(value).run::<false>(), 0.0);
        assert_eq!(Product(value).run::<true>(), f64::EPSILON * f64::EPSILON);
        let kept = run(Product(value)) != 0.0;
        assert_eq!(kept, has_wide_vectors());
    }
}
