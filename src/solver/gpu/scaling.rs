//! The numbers that the weights on the device are relative to, so that none overflows in f32.

use crate::model::Problem;

/// Reference step, volume and diffusivity, and what follows from them.
#[derive(Debug)]
pub(super) struct Scaling {
    /// Reference step, s.
    pub(super) step: f64,
    /// dt_ref V_ref D_ref sigma / H^(dim + 2) / moment: the weight of a pair whose ratios and
    /// dimensionless kernel are 1.
    pub(super) weight: f64,
    /// V / V_ref and D / D_ref of each particle; `None` where both are 1 throughout.
    pub(super) ratios: Option<Vec<[f64; 2]>>,
}

impl Scaling {
    /// The scaling of a run with step `dt` (s); `by_particle` where particles differ in volume or
    /// diffusivity.
    pub(super) fn new(problem: &Problem, dt: f64, by_particle: bool) -> Self {
        let volume = &problem.particles.volume;
        let materials = &problem.particles.material;
        let diffusivity: Vec<f64> =
            materials.iter().map(|&m| problem.materials[usize::from(m)].diffusivity).collect();
        let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let (volume_ref, diffusivity_ref) = (largest(volume), largest(&diffusivity));
        let ratio = |(v, d): (&f64, &f64)| [v / volume_ref, d / diffusivity_ref];
        let step = reference_step(problem, dt, diffusivity_ref);
        let kernel = &problem.kernel;
        let moment = problem.correction.moment(kernel, problem.spacing);
        let rate = volume_ref * kernel.dw_over_r_scale() * diffusivity_ref / moment;
        Self {
            step,
            weight: step * rate,
            ratios: by_particle.then(|| volume.iter().zip(&diffusivity).map(ratio).collect()),
        }
    }
}

/// The step that weights are relative to, s: `dt`, if it is one. A run of no duration has no step;
/// its rates are asked for all the same.
pub(super) fn reference_step(problem: &Problem, dt: f64, diffusivity: f64) -> f64 {
    match dt > 0.0 && dt.is_finite() {
        true => dt,
        false => problem.spacing * problem.spacing / diffusivity,
    }
}
