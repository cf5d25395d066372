//! Whether a size fits: into memory, into the device's buffers, into the time there is.

use super::Series;
use super::scene::{PARTICLE_BYTES, inner_neighbors};
use crate::report::format::{bytes, grouped, wall_time};
use crate::solver::{Machine, MachineKind, PathWish};
use crate::study::memory::SHARE;

/// Indices are u32, of which backends reserve the top ones.
const MOST_PARTICLES: u64 = u32::MAX as u64 - 2;

/// Bytes of a particle that sorting into cells takes: its cell and its place.
const SORTING: u64 = 8;

/// Bytes of a particle that a GPU's set-up takes in the memory of programs: its place in its cell
/// in f64 and as the device takes it, its row, the length of its row.
const UPLOADING: u64 = 24 + 24 + 16;

/// Memory of programs that a size takes at most while it is set up and runs, bytes: its scene, the
/// operator and the states.
pub(super) fn needed(series: &Series, machine: &Machine, particles: u64) -> u64 {
    let precision = machine.kind().precision();
    let neighbors = inner_neighbors(series.dimension, series.support_ratio);
    let operator = match series.path {
        PathWish::Lattice => 0,
        PathWish::MatrixFree => series.dimension as u64 * precision.bytes() + 8,
        // Entries; order and start, or length, of each row.
        _ => neighbors * (4 + precision.bytes()) + 8,
    };
    let setting_up = match (series.path, machine.kind()) {
        (PathWish::Lattice, MachineKind::Cpu) => 0,
        (_, MachineKind::Cpu) => SORTING,
        (_, MachineKind::Gpu(_)) => SORTING + UPLOADING,
    };
    let on_machine =
        if machine.shares_memory() { operator + 2 * precision.state_bytes() } else { 0 };
    particles.saturating_mul(PARTICLE_BYTES + setting_up + on_machine)
}

/// Why `particles` particles of a series are too many; `free` is the memory that is free, bytes,
/// the scene not counted if it is there.
pub(super) fn why_too_many(
    series: &Series,
    machine: &Machine,
    particles: u64,
    free: u64,
) -> Option<String> {
    if particles > MOST_PARTICLES {
        return Some(format!("indices are 32 bits: at most {} particles", grouped(MOST_PARTICLES)));
    }
    let field = particles * machine.kind().precision().state_bytes();
    // A lattice's state may lie in several buffers.
    let most = machine.most_field_bytes().filter(|_| series.path != PathWish::Lattice);
    if let Some(most) = most.filter(|most| field > *most) {
        let (field, most) = (bytes(field), bytes(most));
        return Some(format!("a state takes {field}, and the adapter binds at most {most}"));
    }
    let needed = needed(series, machine, particles);
    let share = (SHARE * free as f64) as u64;
    (needed > share).then(|| {
        let percent = 100.0 * SHARE;
        format!(
            "it needs {} of memory; {percent} % of what is free are {}",
            bytes(needed),
            bytes(share)
        )
    })
}

/// Why setting up `particles` particles takes too long, where `smaller` took so many seconds for so
/// many: set-up grows with their number.
pub(super) fn why_too_slow(
    particles: u64,
    smaller: Option<(u64, f64)>,
    most_setup: f64,
) -> Option<String> {
    let (count, seconds) = smaller?;
    let expected = seconds * particles as f64 / count as f64;
    (expected > most_setup).then(|| {
        format!(
            "its set-up is expected to take {}, more than --setup-seconds {most_setup}",
            wall_time(expected)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::Precision;
    use crate::study::memory::free_memory;

    fn series(path: PathWish) -> Series {
        Series { path, precision: Precision::F64, dimension: 3, support_ratio: 2.0 }
    }

    #[test]
    fn sizes_that_do_not_fit_are_refused_with_the_reason() {
        let why = |path, particles, free| {
            why_too_many(&series(path), &Machine::Cpu, particles, free).unwrap_or_default()
        };
        // 58 bytes a particle by lattice and 386 by list, of which four fifths may be taken.
        assert_eq!(why(PathWish::Lattice, 1000, 72_500), "");
        assert!(why(PathWish::Lattice, 1000, 72_499).contains("58 kB of memory"));
        assert_eq!(why(PathWish::List, 1000, 482_500), "");
        assert!(why(PathWish::List, 1000, 482_498).contains("386 kB of memory"));
        assert!(why(PathWish::Lattice, 5_000_000_000, u64::MAX).contains("32 bits"));
    }

    #[test]
    fn set_up_is_expected_to_grow_with_the_particles() {
        assert_eq!(why_too_slow(1000, None, 1.0), None, "nothing is known of it");
        assert_eq!(why_too_slow(1000, Some((100, 0.1)), 1.0), None);
        let why = why_too_slow(1000, Some((100, 0.11)), 1.0).expect("1.1 s are too long");
        assert!(why.contains("1.1 s") && why.contains("--setup-seconds 1"), "{why}");
    }

    #[test]
    fn some_memory_is_free() {
        assert!((1 << 20..1 << 60).contains(&free_memory()));
    }
}
