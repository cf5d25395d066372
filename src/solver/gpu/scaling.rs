//! The numbers that the weights on the device are relative to, so that none overflows in f32.

use crate::model::{Material, Problem};

/// The reference step and what follows from it and from reference properties.
#[derive(Debug)]
pub(super) struct Scaling {
    /// Reference step, s.
    pub(super) step: f64,
    /// dt_ref V_ref k_ref sigma / H^(dim + 2) / moment / c_ref: the weight of a pair whose ratios and
    /// dimensionless kernel are 1, c being the capacity rho c.
    pub(super) weight: f64,
    /// V / V_ref, k / k_ref, c / c_ref and 0 of each particle; `None` where all are alike.
    pub(super) ratios: Option<Vec<[f64; 4]>>,
}

impl Scaling {
    /// The scaling of a run with step `dt` (s); `by_particle` where particles differ in volume or
    /// properties.
    pub(super) fn new(problem: &Problem, dt: f64, by_particle: bool) -> Self {
        let volume = &problem.particles.volume;
        let of = |&m: &u16| &problem.materials[usize::from(m)];
        let material: Vec<&Material> = problem.particles.material.iter().map(of).collect();
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let volume_ref = largest(&mut volume.iter().copied());
        let conductivity_ref = largest(&mut material.iter().map(|m| m.conductivity));
        let capacity_ref = material.iter().map(|m| m.capacity).fold(f64::INFINITY, f64::min);
        let ratio = |(v, m): (&f64, &&Material)| {
            [v / volume_ref, m.conductivity / conductivity_ref, m.capacity / capacity_ref, 0.0]
        };
        let diffusivity = conductivity_ref / capacity_ref;
        let step = reference_step(problem, dt, diffusivity);
        let kernel = &problem.kernel;
        let moment = problem.correction.moment(kernel, problem.spacing);
        let rate = volume_ref * kernel.dw_over_r_scale() * diffusivity / moment;
        Self {
            step,
            weight: step * rate,
            ratios: by_particle.then(|| volume.iter().zip(&material).map(ratio).collect()),
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
