//! Where in a melting particle the front is.
//!
//! Heat flows to a front, not to the centre of the particle that it passes through. With a sharp melting point a
//! particle stays at that temperature from the moment the front enters it until the front has left, while the
//! front moves by a whole spacing, from half a spacing before the centre to half a spacing behind it: where the
//! liquid fraction is f, it is s = f - 1/2 spacings further from what is liquid and nearer to what is solid.
//! A pair mean takes the distance to the centre, so that the first particle that melts is late.
//!
//! With D spacings, the mean distance of the neighbours on one side along a normal, the flow between a melting
//! particle and a liquid neighbour is D / (D + s) of what the operator has, and that with a solid one D / (D - s):
//! what a linear profile between the front and these neighbours carries. Of pairs of particles that both melt,
//! or neither, nothing changes, and what one of a pair gains the other loses.

use crate::model::{HeatCurve, Kernel, Problem, lattice};

/// How fronts change the flows of a scene.
#[derive(Clone, Debug)]
pub struct Fronts {
    /// By material: where it melts, if it does sharply.
    fronts: Vec<Option<Front>>,
    /// Mean distance of the neighbours on one side along an axis, spacings.
    distance: f64,
}

/// The melting of a material with a sharp melting point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Front {
    /// Enthalpy where it begins, K.
    pub begins: f64,
    /// Enthalpy where it ends, K.
    pub ends: f64,
    /// Potential meanwhile, K.
    pub potential: f64,
    /// How much is liquid for each K of enthalpy, 1/K.
    per_enthalpy: f64,
}

impl Fronts {
    /// Those of `problem`; `None` where nothing melts at one temperature.
    pub fn of(problem: &Problem) -> Option<Self> {
        if !problem.melts() {
            return None;
        }
        let curves = problem.materials.iter().map(|material| material.curve.as_deref());
        let fronts: Vec<Option<Front>> = curves.map(|curve| Front::of(curve?)).collect();
        let distance = mean_distance(&problem.kernel, problem.spacing);
        fronts.iter().any(Option::is_some).then_some(Self { fronts, distance })
    }

    /// The melting of a material, if it is sharp.
    pub fn of_material(&self, material: u16) -> Option<&Front> {
        self.fronts[usize::from(material)].as_ref()
    }

    /// Mean distance of the neighbours on one side along an axis, spacings.
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// How much more than the operator has of it flows between a melting particle of this enthalpy (K) and a
    /// neighbour, in parts: a liquid one, and a solid one.
    #[inline(always)]
    pub fn excess(&self, front: &Front, enthalpy: f64) -> [f64; 2] {
        let s = (enthalpy - front.begins) * front.per_enthalpy - 0.5;
        // -s / (D + s) and s / (D - s), by one division.
        let [to_liquid, to_solid] = [self.distance + s, self.distance - s];
        let part = s / (to_liquid * to_solid);
        [-part * to_solid, part * to_liquid]
    }
}

impl Front {
    fn of(curve: &HeatCurve) -> Option<Self> {
        let [begins, ends] = curve.melting()?;
        let melt = curve.melt()?;
        let is_sharp = melt.solidus == melt.liquidus && begins < ends;
        is_sharp.then(|| Self::between([begins, ends], curve.potential(begins)))
    }

    fn between([begins, ends]: [f64; 2], potential: f64) -> Self {
        Self { begins, ends, potential, per_enthalpy: 1.0 / (ends - begins) }
    }

    /// Whether a particle of this enthalpy (K) melts.
    #[inline]
    pub fn is_in(&self, enthalpy: f64) -> bool {
        (self.begins < enthalpy) & (enthalpy < self.ends)
    }
}

/// sum w |x| / sum w over the neighbours of a lattice, in spacings, with the weights of its pairs and x along an
/// axis, on which those that are level with the particle do not count.
fn mean_distance(kernel: &Kernel, spacing: f64) -> f64 {
    let (mut weights, mut distances) = (0.0, 0.0);
    lattice::for_each_neighbor(kernel, spacing, |offset| {
        let x = (offset.x / spacing).abs();
        if x > 0.5 {
            let weight = -kernel.dw_over_r(offset.length());
            weights += weight;
            distances += weight * x;
        }
    });
    // No neighbour, no flow.
    if weights > 0.0 { distances / weights } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::KernelKind;

    #[test]
    fn a_linear_profile_up_to_the_front_flows_as_it_should() {
        let front = Front::between([700.0, 900.0], 700.0);
        for (kind, ratio) in [(KernelKind::CubicSpline, 2.0), (KernelKind::WendlandC4, 3.2)] {
            let kernel = Kernel::new(kind, 1, ratio).expect("a kernel");
            let fronts =
                Fronts { fronts: vec![Some(front)], distance: mean_distance(&kernel, 1.0) };
            for fraction in [0.01, 0.3, 0.5, 0.99] {
                let excess = fronts.excess(&front, 700.0 + 200.0 * fraction);
                // The front, from the centre towards what is solid; slopes of -3 before and -2 behind it.
                let s = fraction - 0.5;
                let (mut flow, mut slope) = ([0.0; 2], [0.0; 2]);
                lattice::for_each_neighbor(&kernel, 1.0, |offset| {
                    let weight = -kernel.dw_over_r(offset.length());
                    let side = usize::from(offset.x > 0.0);
                    let fall = if side == 0 { 3.0 } else { 2.0 };
                    flow[side] += weight * (1.0 + excess[side]) * fall * (s - offset.x);
                    slope[side] -= weight * fall * offset.x;
                });
                for side in 0..2 {
                    assert!((flow[side] / slope[side] - 1.0).abs() < 1e-13, "{kind:?}, {fraction}");
                }
            }
        }
    }

    #[test]
    fn neighbours_of_one_layer_are_a_spacing_away() {
        for dimension in 1..=3 {
            let kernel = Kernel::new(KernelKind::CubicSpline, dimension, 2.0).expect("a kernel");
            assert!((mean_distance(&kernel, 1.0) - 1.0).abs() < 1e-15);
            let wide = Kernel::new(KernelKind::CubicSpline, dimension, 3.0).expect("a kernel");
            assert!((1.1..1.9).contains(&mean_distance(&wide, 1.0)));
        }
    }
}
