//! Sources inside the body.

use super::ScalarField;

/// What particles of a part of the body get a second: s0 + s1 C, beside what flows between them.
#[derive(Clone, Debug)]
pub struct Source {
    /// What messages call it, e.g. its path in the case file.
    pub name: String,
    /// The particles that get it, ascending; all of them where `None`.
    pub particles: Option<Vec<u32>>,
    /// s0, value/s, a function of position and time.
    pub rate: ScalarField,
    /// s1, 1/s, a function of position. What is negative damps, what is positive grows.
    pub linear: ScalarField,
}

impl Source {
    /// Whether particle `particle` gets it.
    pub fn acts_on(&self, particle: usize) -> bool {
        let of_list = |list: &Vec<u32>| list.binary_search(&(particle as u32)).is_ok();
        self.particles.as_ref().is_none_or(of_list)
    }

    /// Indices of the particles that get it, of `count`.
    pub fn indices(&self, count: usize) -> impl Iterator<Item = usize> + '_ {
        let listed = self.particles.iter().flatten().map(|&particle| particle as usize);
        let all = if self.particles.is_none() { 0..count } else { 0..0 };
        listed.chain(all)
    }
}
