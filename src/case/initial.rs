//! The `initial` section.

use glam::DVec3;
use rayon::prelude::*;

use super::boundary::select;
use super::error::CaseError;
use super::number::{Evaluator, Number, Point};
use super::schema::InitialSpec;
use super::shape::ShapeSpec;
use crate::model::{Domain, Material, Particles};

/// Particles share a deposit if their distances to it differ by less than this fraction of the
/// spacing.
const SAME_DISTANCE: f64 = 1e-6;

/// Values at t = 0, with what they were made of.
pub(super) struct Initial {
    /// One value a particle.
    pub(super) value: Vec<f64>,
    /// Amount and place of every deposit.
    pub(super) deposits: Vec<(f64, DVec3)>,
    /// The particles that take part of a deposit.
    pub(super) recipients: Vec<Recipient>,
}

/// A particle that takes part of a deposit.
pub(super) struct Recipient {
    pub(super) particle: u32,
    /// Index of the deposit's entry.
    pub(super) entry: usize,
    /// By how much its state rises.
    rise: f64,
}

impl Initial {
    /// The state of every particle: what belongs to its value, and then the deposits; `held` ones take none.
    pub(super) fn into_state(
        self,
        particles: &Particles,
        materials: &[Material],
        held: &[u32],
    ) -> Vec<f64> {
        let of_particle = |(&value, &material): (&f64, &u16)| {
            let curve = &materials[usize::from(material)].curve;
            curve.as_ref().map_or(value, |curve| curve.enthalpy(value))
        };
        let mut state = match materials.iter().any(|material| material.curve.is_some()) {
            true => self.value.par_iter().zip(&particles.material).map(of_particle).collect(),
            false => self.value,
        };
        let takes = |recipient: &&Recipient| held.binary_search(&recipient.particle).is_err();
        for recipient in self.recipients.iter().filter(takes) {
            state[recipient.particle as usize] += recipient.rise;
        }
        state
    }
}

/// What the initial values are made from.
pub(super) struct Ground<'a> {
    pub(super) evaluator: &'a Evaluator,
    pub(super) domain: &'a Domain,
    pub(super) spacing: f64,
    pub(super) particles: &'a Particles,
    pub(super) materials: &'a [Material],
}

/// Values, later entries over earlier ones, and the amounts that are added on top of all.
pub(super) fn resolve(entries: &[InitialSpec], ground: &Ground) -> Result<Initial, CaseError> {
    let mut initial = Initial {
        value: vec![0.0; ground.particles.len()],
        deposits: Vec::new(),
        recipients: Vec::new(),
    };
    let mut amounts = Vec::new();
    for (index, entry) in entries.iter().enumerate() {
        let path = format!("initial[{index}]");
        match (&entry.value, &entry.amount) {
            (Some(value), None) => {
                forbid(&path, "at", entry.at.is_some(), "it belongs to an amount")?;
                ground.set(&mut initial.value, &path, value, entry.selection.as_ref())?;
            }
            (None, Some(amount)) => {
                let reason = "it belongs to a value; an amount has a place, at";
                forbid(&path, "where", entry.selection.is_some(), reason)?;
                let at = entry.at.as_ref();
                let at = at.ok_or(CaseError::MissingKey { path: format!("{path}.at") })?;
                amounts.push((index, path, amount, at));
            }
            (Some(_), Some(_)) => {
                forbid(&path, "amount", true, "the entry has a value already")?;
            }
            (None, None) => {
                return Err(CaseError::MissingKey { path: format!("{path}.value") });
            }
        }
    }
    for (index, path, amount, at) in amounts {
        ground.deposit(&mut initial, index, &path, amount, at)?;
    }
    Ok(initial)
}

fn forbid(path: &str, key: &str, given: bool, reason: &str) -> Result<(), CaseError> {
    if !given {
        return Ok(());
    }
    Err(CaseError::UnusedKey { path: format!("{path}.{key}"), reason: reason.to_owned() })
}

impl Ground<'_> {
    fn set(
        &self,
        initial: &mut [f64],
        path: &str,
        value: &Number,
        selection: Option<&ShapeSpec>,
    ) -> Result<(), CaseError> {
        let value = self.evaluator.field(&format!("{path}.value"), value)?;
        let position = &self.particles.position;
        let Some(selection) = selection else {
            return initial.par_iter_mut().zip(position).try_for_each(|(entry, &x)| {
                *entry = value.at(x, 0.0)?;
                Ok(())
            });
        };
        let path = format!("{path}.where");
        let shape = selection.resolve(self.evaluator, &path)?;
        for particle in select(self.particles, &shape, self.spacing, &path)? {
            initial[particle as usize] = value.at(position[particle as usize], 0.0)?;
        }
        Ok(())
    }

    fn deposit(
        &self,
        initial: &mut Initial,
        index: usize,
        path: &str,
        amount: &Number,
        at: &Point,
    ) -> Result<(), CaseError> {
        let amount = self.evaluator.number(&format!("{path}.amount"), amount)?;
        let at_path = format!("{path}.at");
        let at = self.evaluator.point(&at_path, at)?;
        super::plan::check_inside(&at_path, at, self.domain, self.evaluator, self.spacing)?;
        let nearest = self.nearest(at);
        let capacity = |&b: &u32| {
            let material = usize::from(self.particles.material[b as usize]);
            self.materials[material].capacity * self.particles.volume[b as usize]
        };
        let capacity: f64 = nearest.iter().map(capacity).sum();
        for particle in nearest {
            let rise = amount / capacity;
            initial.recipients.push(Recipient { particle, entry: index, rise });
        }
        initial.deposits.push((amount, at));
        Ok(())
    }

    /// Every particle whose distance to `at` is the least, ascending.
    fn nearest(&self, at: DVec3) -> Vec<u32> {
        let dist = |x: &DVec3| self.domain.nearest_image(*x - at).length();
        let position = &self.particles.position;
        let least = position.par_iter().map(dist).reduce(|| f64::INFINITY, f64::min);
        let reach = least + SAME_DISTANCE * self.spacing;
        position
            .par_iter()
            .enumerate()
            .filter(|(_, x)| dist(x) <= reach)
            .map(|(index, _)| index as u32)
            .collect()
    }
}
