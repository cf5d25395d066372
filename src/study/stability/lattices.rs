//! The lattices whose step is scanned.

use super::StabilityOptions;
use super::scan::Known;
use super::scenes;
use crate::model::stability::lattice_eigenvalue;
use crate::model::{Correction, KernelKind, Problem};

/// Particles along an axis, by dimension: even, so that the fastest waves fit.
const EDGES: [usize; 3] = [64, 32, 16];

/// The README's limits for the cubic spline at H / dx = 2, over dx^2 / D, by dimension: of the plain and of
/// the moment-corrected operator.
const PUBLISHED: [[f64; 2]; 3] = [[0.5, 0.5], [0.3665, 0.3713], [0.3308, 0.3374]];

/// A lattice to scan.
pub(super) struct Lattice {
    /// Its name.
    pub(super) name: String,
    /// The scene.
    pub(super) problem: Problem,
    /// What is known of its limit.
    pub(super) known: Known,
}

/// One lattice to scan, not built yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LatticeKind {
    kernel: KernelKind,
    dimension: usize,
    support_ratio: f64,
    correction: Correction,
}

/// Those that the options ask for, where their kernel is defined.
pub(super) fn asked_for(options: &StabilityOptions<'_>) -> Vec<LatticeKind> {
    let mut kinds = Vec::new();
    for &kernel in &options.kernels {
        for &support_ratio in &options.support_ratios {
            for correction in Correction::ALL {
                let dimensions = options.dimensions.iter().copied();
                for dimension in dimensions.filter(|&dimension| kernel.is_defined_in(dimension)) {
                    kinds.push(LatticeKind { kernel, dimension, support_ratio, correction });
                }
            }
        }
    }
    kinds
}

impl LatticeKind {
    /// Its name.
    pub(super) fn name(&self) -> String {
        let of = match self.correction {
            Correction::None => "plain",
            Correction::Moment => "corrected",
        };
        let Self { kernel, dimension, support_ratio, .. } = self;
        format!("{} {support_ratio}, {dimension}-D, {of}", kernel.name())
    }

    /// The lattice.
    pub(super) fn build(&self) -> Lattice {
        let Self { kernel, dimension, support_ratio, correction } = *self;
        let edge = EDGES[dimension - 1].max(2 * support_ratio.ceil() as usize + 2);
        let problem = scenes::periodic(kernel, support_ratio, correction, &vec![edge; dimension]);
        let counts = std::array::from_fn(|axis| if axis < dimension { edge } else { 1 });
        let is_corrected = correction == Correction::Moment;
        let (of, spacing) = (&problem.kernel, problem.spacing);
        let unit = spacing * spacing / problem.max_diffusivity();
        let waves = 2.0 / lattice_eigenvalue(of, spacing, counts, is_corrected) * unit;
        let has_figure = kernel == KernelKind::CubicSpline && support_ratio == 2.0;
        let published = has_figure.then_some(PUBLISHED[dimension - 1][usize::from(is_corrected)]);
        Lattice { name: self.name(), problem, known: Known { waves: Some(waves), published } }
    }
}
