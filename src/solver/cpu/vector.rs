//! Vectors of the CPU backend.

use std::sync::{Arc, Weak};

use rayon::prelude::*;

use super::CHUNK;

/// One value at each place, and what the outside gave, value x capacity (or that a second, of a rate).
#[derive(Debug)]
pub struct CpuVector {
    pub(super) values: Vec<f64>,
    pub(super) given: f64,
    /// Nothing but what ends with the vector.
    _life: Arc<()>,
}

/// How many vectors there are, and were at once at most.
#[derive(Debug, Default)]
pub(super) struct Count {
    lives: Vec<Weak<()>>,
    pub(super) most: usize,
}

impl Count {
    /// A vector of zeros.
    pub(super) fn vector(&mut self, places: usize) -> CpuVector {
        let life = Arc::new(());
        self.lives.retain(|life| life.strong_count() > 0);
        self.lives.push(Arc::downgrade(&life));
        self.most = self.most.max(self.lives.len());
        CpuVector { values: vec![0.0; places], given: 0.0, _life: life }
    }
}

impl CpuVector {
    /// self = `keep` x self + the sum of factor x vector.
    pub(super) fn update(&mut self, keep: f64, terms: &[(f64, &Self)]) {
        self.update_given(keep, terms);
        self.values.par_chunks_mut(CHUNK).enumerate().for_each(|(k, out)| {
            let part = k * CHUNK..k * CHUNK + out.len();
            if keep == 0.0 {
                out.fill(0.0);
            } else if keep != 1.0 {
                out.iter_mut().for_each(|out| *out *= keep);
            }
            for (factor, vector) in terms {
                let values = &vector.values[part.clone()];
                out.iter_mut().zip(values).for_each(|(out, value)| *out += factor * value);
            }
        });
    }

    /// The same for what the outside gave, alone.
    pub(super) fn update_given(&mut self, keep: f64, terms: &[(f64, &Self)]) {
        let sum: f64 = terms.iter().map(|(factor, vector)| factor * vector.given).sum();
        self.given = if keep == 0.0 { sum } else { keep * self.given + sum };
    }

    /// Multiplies each value by that of `by`; the outside gave nothing to that.
    pub(super) fn multiply(&mut self, by: &Self) {
        self.given = 0.0;
        let parts = self.values.par_chunks_mut(CHUNK).zip(by.values.par_chunks(CHUNK));
        parts.for_each(|(out, by)| out.iter_mut().zip(by).for_each(|(out, by)| *out *= by));
    }

    /// self = `from` / (`shift` + `scale` x `diagonal`).
    pub(super) fn divide(&mut self, from: &Self, shift: f64, scale: f64, diagonal: &[f64]) {
        self.given = 0.0;
        let parts = self.values.par_chunks_mut(CHUNK);
        let from = from.values.par_chunks(CHUNK).zip(diagonal.par_chunks(CHUNK));
        parts.zip(from).for_each(|(out, (from, diagonal))| {
            for ((out, from), diagonal) in out.iter_mut().zip(from).zip(diagonal) {
                *out = from / (shift + scale * diagonal);
            }
        });
    }
}

/// The largest magnitude of values; not finite if one is not.
pub(super) fn largest(values: &[f64]) -> f64 {
    // NaN compares with nothing, so that a maximum alone would lose it.
    let of_part = |part: &[f64]| {
        let (mut largest, mut sum) = (0.0_f64, 0.0_f64);
        for value in part {
            largest = largest.max(value.abs());
            sum += 0.0 * value;
        }
        largest + sum
    };
    let parts: Vec<f64> = values.par_chunks(CHUNK).map(of_part).collect();
    parts
        .into_iter()
        .fold(0.0, |largest, part| if part > largest || part.is_nan() { part } else { largest })
}

/// The capacities of particles.
pub(super) enum Capacities {
    /// All have this one.
    Same(f64),
    /// By place.
    Each(Vec<f64>),
}

impl Capacities {
    /// Those of particles in the problem's order, brought to the operator's where they differ.
    pub(super) fn of(volume: &[f64], by_place: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let first = volume.first().copied().unwrap_or(0.0);
        match volume.par_iter().all(|&volume| volume == first) {
            true => Self::Same(first),
            false => Self::Each(by_place(volume)),
        }
    }

    /// sum V x y, summed in an order that does not depend on the number of threads.
    pub(super) fn dot(&self, x: &CpuVector, y: &CpuVector) -> f64 {
        let (x, y) = (x.values.par_chunks(CHUNK), y.values.par_chunks(CHUNK));
        let product = |(x, y): (&[f64], &[f64])| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        match self {
            Self::Same(volume) => {
                let parts: Vec<f64> = x.zip(y).map(product).collect();
                volume * parts.iter().sum::<f64>()
            }
            Self::Each(capacities) => {
                let parts = x.zip(y).zip(capacities.par_chunks(CHUNK));
                let weighted = |((x, y), v): ((&[f64], &[f64]), &[f64])| {
                    x.iter().zip(y).zip(v).map(|((x, y), v)| v * x * y).sum::<f64>()
                };
                let parts: Vec<f64> = parts.map(weighted).collect();
                parts.iter().sum()
            }
        }
    }

    /// That of a place.
    pub(super) fn at(&self, place: usize) -> f64 {
        match self {
            Self::Same(capacity) => *capacity,
            Self::Each(capacities) => capacities[place],
        }
    }

    /// That of a place over that of another.
    pub(super) fn ratio(&self, one: usize, other: usize) -> f64 {
        match self {
            Self::Same(_) => 1.0,
            Self::Each(capacities) => capacities[one] / capacities[other],
        }
    }

    /// sum V x over some places.
    pub(super) fn sum(&self, x: &[f64], places: &[u32]) -> f64 {
        let values = places.iter().map(|&place| x[place as usize]);
        match self {
            Self::Same(volume) => volume * values.sum::<f64>(),
            Self::Each(capacities) => {
                values.zip(places).map(|(x, &place)| capacities[place as usize] * x).sum()
            }
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        match self {
            Self::Same(_) => 0,
            Self::Each(capacities) => size_of_val(&**capacities),
        }
    }
}
