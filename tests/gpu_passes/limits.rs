//! The passes that measure limits do the work that they are taken for.

use diffusph::gpu::Real;
use diffusph::gpu::limits::{Arithmetic, Copy};

use crate::support::{device, first_difference};

/// The reals that the adapter has.
fn reals() -> impl Iterator<Item = Real> {
    Real::ALL.into_iter().filter(|&real| device().require(real).is_ok())
}

#[test]
fn the_copy_is_one() {
    for real in reals() {
        let mut copy = Copy::new(device(), real, 1_000_000).expect("the pass");
        let element = 4 * real.size() as u64;
        let bytes = 1_000_000 / element * element;
        assert_eq!((copy.after.bytes(), copy.pass.amount()), (bytes, 2 * bytes));
        let read = || real.from_bytes(&device().read(&copy.after).expect("values"));
        assert!(read().iter().all(|value| *value == 0.0), "nothing has been copied yet");
        copy.pass.run(3).expect("the pass runs");
        let read = || real.from_bytes(&device().read(&copy.after).expect("values"));
        let copied = read();
        let expected: Vec<f64> = (0..copied.len()).map(|i| 1.0 + (i % 8191) as f64).collect();
        assert_eq!(first_difference(&copied, &expected), None);
    }
}

#[test]
fn chains_do_all_the_links_that_are_counted() {
    let (start, factor, addend) = (1.0, -0.9, 1.0);
    let rest: f64 = addend / (1.0 - factor);
    for real in reals() {
        for rounds in [1, 5] {
            let made = Arithmetic::new(device(), real, rounds, [start, factor, addend]);
            let mut arithmetic = made.expect("the pass");
            arithmetic.pass.run(2).expect("the pass runs");
            let ends = real.from_bytes(&device().read(&arithmetic.ends).expect("values"));
            // A pair of chains is one lane of four, and a link has two operations.
            let links = arithmetic.pass.amount() / (2 * ends.len() as u64) / 2;
            let expected = |links: u64| -> f64 {
                let (sum, left) = (start + 7.0 + start + 7.0 + addend, factor.powi(links as i32));
                2.0 * rest + left * (sum - 2.0 * rest)
            };
            let off = |links| (ends[7] / expected(links) - 1.0).abs();
            let allowed = 100.0 * real.epsilon();
            assert!(off(links) < allowed, "{} {rounds}: {}", real.name(), ends[7]);
            assert!(off(links - 1) > allowed && off(links + 1) > allowed, "a link is noticed");
        }
    }
}
