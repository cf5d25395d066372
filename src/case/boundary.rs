//! The `boundaries` section.

use super::error::CaseError;
use super::fill::TOLERANCE;
use super::number::{AXES, Evaluator, show};
use super::schema::{Axis, BoundarySpec};
use super::shape::Shape;
use super::wall::check_faces;
use crate::model::Particles;

/// Indices of the particles in a shape, ascending.
pub(super) fn select(
    particles: &Particles,
    shape: &Shape,
    spacing: f64,
    path: &str,
) -> Result<Vec<u32>, CaseError> {
    use rayon::prelude::*;
    let selected: Vec<u32> = particles
        .position
        .par_iter()
        .enumerate()
        .filter(|(_, x)| shape.contains(**x, TOLERANCE * spacing))
        .map(|(index, _)| index as u32)
        .collect();
    if selected.is_empty() {
        return Err(CaseError::NothingSelected { path: path.to_owned() });
    }
    Ok(selected)
}

/// Which axes are periodic; walls are checked against them.
pub(super) fn periodic(
    boundaries: &[BoundarySpec],
    dimension: usize,
) -> Result<[bool; 3], CaseError> {
    let mut periodic = [false; 3];
    for (index, boundary) in boundaries.iter().enumerate() {
        let BoundarySpec::Periodic { axes } = boundary else {
            continue;
        };
        for (entry, &axis) in axes.iter().enumerate() {
            let path = format!("boundaries[{index}].periodic.axes[{entry}]");
            let axis = axis_index(axis, &path, dimension)?;
            if periodic[axis] {
                return Err(CaseError::Duplicate { path, text: AXES[axis].to_owned() });
            }
            periodic[axis] = true;
        }
    }
    check_faces(boundaries, dimension, periodic)?;
    Ok(periodic)
}

/// Particles that are held, ascending; their values are written to `initial`.
pub(super) fn hold(
    boundaries: &[BoundarySpec],
    evaluator: &Evaluator,
    particles: &Particles,
    spacing: f64,
    initial: &mut [f64],
) -> Result<Vec<u32>, CaseError> {
    let mut held: Vec<(u32, usize)> = Vec::new();
    for (index, boundary) in boundaries.iter().enumerate() {
        let BoundarySpec::Held { selection, value } = boundary else {
            continue;
        };
        let path = format!("boundaries[{index}].held.where");
        let shape = selection.resolve(evaluator, &path)?;
        let value = evaluator.field(&format!("boundaries[{index}].held.value"), value)?;
        for particle in select(particles, &shape, spacing, &path)? {
            initial[particle as usize] = value.at(particles.position[particle as usize], 0.0)?;
            held.push((particle, index));
        }
    }
    held.sort_unstable();
    if let Some(pair) = held.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        let x = particles.position[pair[0].0 as usize];
        return Err(CaseError::HeldTwice {
            first: format!("boundaries[{}].held", pair[0].1),
            second: format!("boundaries[{}].held", pair[1].1),
            point: show(x, evaluator.dimension),
        });
    }
    Ok(held.into_iter().map(|(particle, _)| particle).collect())
}

/// The axis as a number, which the case's dimension must have.
pub(super) fn axis_index(axis: Axis, path: &str, dimension: usize) -> Result<usize, CaseError> {
    let index = axis as usize;
    if index < dimension {
        return Ok(index);
    }
    Err(CaseError::UnknownName {
        path: path.to_owned(),
        text: AXES[index].to_owned(),
        nearest: Vec::new(),
        known: AXES[..dimension].iter().map(|&name| name.to_owned()).collect(),
    })
}
