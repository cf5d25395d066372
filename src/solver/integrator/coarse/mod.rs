//! A coarse space for conjugate gradients: what is smooth is solved for on a few aggregates of particles.

mod boxes;
mod envelope;

use crate::model::Problem;
use crate::solver::{Backend, Precision, SolverError};
use boxes::Boxes;
use envelope::Envelope;

/// A particle in no aggregate: a held one.
pub(super) const NONE: u32 = u32::MAX;

/// A pivot of a coarse matrix below this part of its diagonal is rounding: where nothing imposes a value the
/// matrix is singular. Sums over neighbours are of f32 where values have two words, too.
fn regular(precision: Precision) -> f64 {
    match precision {
        Precision::F32 | Precision::Compensated => 1e-5,
        Precision::F64 => 1e-10,
    }
}

/// Boxes of particles, each of one material, as piecewise constant functions (the coarse level of an additive
/// Schwarz method: Nicolaides 1987, SIAM J. Numer. Anal. 24, 355; Smith, Bjorstad and Gropp 1996, section
/// 1.3). Boxes are at least as wide as the support, so that only neighbouring ones interact: their matrix comes
/// from one application of the operator for each of a few colours. That is exact whatever the path, and
/// the contrast of materials does not spoil it, since no box has two.
pub(super) struct Coarse {
    /// V of each aggregate.
    volume: Vec<f64>,
    /// Z^T V A Z, where column k of Z is 1 in aggregate k.
    operator: Envelope,
    /// The factor of Z^T V M Z for the last M = shift + scale A.
    factor: Option<([f64; 2], Envelope)>,
    /// What a residual gives on the aggregates.
    restricted: Vec<f64>,
    /// Operator applications that the matrix took.
    pub(super) applications: u64,
}

impl Coarse {
    /// The aggregates of `problem`, on `backend`; `None` where every particle is held. A single one gains no
    /// speed, but what is solved conserves.
    pub(super) fn new<B: Backend>(
        backend: &mut B,
        problem: &Problem,
    ) -> Result<Option<Self>, SolverError> {
        let mut boxes = Boxes::of(problem);
        let (aggregate, colors) = boxes.aggregates(problem);
        if colors.is_empty() {
            return Ok(None);
        }
        backend.aggregate(&aggregate, colors.len())?;
        let [mut x, mut y] = [backend.vector()?, backend.vector()?];
        let mut restricted = vec![0.0; colors.len()];
        let mut products = Vec::new();
        let mut volume = vec![0.0; colors.len()];
        let count = colors.iter().max().map_or(0, |&most| most + 1);
        for color in 0..count {
            let of_color: Vec<f64> =
                colors.iter().map(|&c| if c == color { 1.0 } else { 0.0 }).collect();
            if !of_color.contains(&1.0) {
                continue;
            }
            backend.update(&mut x, 0.0, &[])?;
            backend.prolong(&of_color, &mut x)?;
            backend.restrict(&x, &mut restricted)?;
            volume.iter_mut().zip(&restricted).for_each(|(volume, v)| *volume += v);
            backend.apply(&x, 0.0, 1.0, &mut y)?;
            backend.restrict(&y, &mut restricted)?;
            products.push((color, restricted.clone()));
        }
        let applications = products.len() as u64;
        let operator = boxes.matrix(&colors, &products);
        let restricted = vec![0.0; colors.len()];
        Ok(Some(Self { volume, operator, factor: None, restricted, applications }))
    }

    /// Adds Z (Z^T V M Z)^-1 Z^T V r to `out`, for M = shift + scale A and r = `residual`.
    pub(super) fn add<B: Backend>(
        &mut self,
        backend: &mut B,
        matrix: [f64; 2],
        residual: &B::Vector,
        out: &mut B::Vector,
    ) -> Result<(), SolverError> {
        backend.restrict(residual, &mut self.restricted)?;
        let factor = match &mut self.factor {
            Some((of, factor)) if *of == matrix => factor,
            other => {
                let [shift, scale] = matrix;
                let diagonal = |k: usize| shift * self.volume[k];
                let factor = self.operator.factor(scale, diagonal, regular(backend.precision()));
                &mut other.insert((matrix, factor)).1
            }
        };
        factor.solve(&mut self.restricted);
        backend.prolong(&self.restricted, out)
    }
}
