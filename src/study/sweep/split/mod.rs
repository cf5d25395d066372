//! What an error consists of: the particles and the steps apart.
//!
//! Where the particles fill a box with mirrors or periodic ends, the solution exact in time of the
//! particles' own equations is known (see [`super::modes`]), and so is that of diffusion itself from
//! what the particles carry at first. Between the exact solution and a run lie:
//! exact -> diffusion of the particles' initial state -> the same with Deff in place of D -> the
//! particles' equations, exact in time -> the run.

use glam::DVec3;

use super::modes::Modes;
use crate::case::Scene;
use crate::exact::{PointSourceInBox, Solution};
use crate::model::Problem;
use crate::model::integrator::{Method, MethodChoice};
use crate::model::interpolation::Interpolation;
use crate::model::lattice::{Edge, End, LatticeScene, effective_diffusivity_ratio};
use crate::model::operator::FoldNeeds;
use crate::report::Norms;
use crate::report::run::ProbeReport;
use crate::report::study::{Part, ProbeSplit, Split};

/// What is known of a scene whatever its steps.
pub(super) struct Space {
    l2_relative: Option<f64>,
    probes: Vec<AtProbe>,
    /// What the first part is called.
    first: &'static str,
    remarks: Vec<String>,
}

/// The values on the way from the exact solution to the run, at a probe.
struct AtProbe {
    name: String,
    exact: f64,
    /// Diffusion from the initial state, with D and with Deff.
    diffused: [f64; 2],
    /// The second of these, interpolated between particles.
    interpolated: f64,
    /// The particles' equations, exact in time, interpolated.
    semi_discrete: f64,
}

impl Space {
    /// The split of `scene`, up to the steps.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub(super) fn of(scene: &Scene) -> Result<Self, String> {
        let problem = &scene.problem;
        let lattice = lattice(problem)?;
        let exact = scene.exact.as_ref().ok_or("the case has no exact solution")?;
        Self::on(scene, &lattice, exact)
    }

    /// The split on `lattice`, whose stencil counts.
    fn on(scene: &Scene, lattice: &LatticeScene, exact: &Solution) -> Result<Self, String> {
        let problem = &scene.problem;
        let time = problem.time.end;
        let modes = Modes::of(lattice);
        let initial = modes.amplitudes(&lattice.by_site(&problem.initial));
        let material = problem.particles.material.first().map_or(0, |&m| usize::from(m));
        let diffusivity = problem.materials[material].diffusivity();
        let moment = problem.correction.moment(&problem.kernel, problem.spacing);
        let ratio = effective_diffusivity_ratio(&problem.kernel, problem.spacing) / moment;
        let after = |rates: &[f64]| modes.after(&initial, rates, time);
        let diffused = [1.0, ratio]
            .map(|ratio| after(&modes.of_diffusion(ratio * diffusivity, problem.spacing)));
        let by_particle = |amplitudes: &[f64]| lattice.by_particle(&modes.field(amplitudes));
        let with_deff = by_particle(&diffused[1]);
        let semi_discrete = by_particle(&after(&modes.of_stencil(&lattice.classes)));
        let (reference, first) = reference(exact);
        let probes = problem.probes.iter().filter_map(|probe| {
            let interpolation = Interpolation::at(problem, probe.at)?;
            let place = ((probe.at - problem.domain.min) / problem.spacing).to_array();
            Some(AtProbe {
                name: probe.name.clone(),
                exact: reference.at(probe.at, time),
                diffused: [0, 1].map(|k| modes.at(&diffused[k], inside(place, problem.dimension))),
                interpolated: interpolation.of(&with_deff, time),
                semi_discrete: interpolation.of(&semi_discrete, time),
            })
        });
        let probes = probes.collect();
        let field = exact.evaluate(&problem.particles.position, time);
        let norm = Norms::new(&semi_discrete, &field, &problem.particles.volume).l2_relative;
        let remarks = remark(problem, lattice, &semi_discrete).into_iter().collect();
        Ok(Self { l2_relative: norm.is_finite().then_some(norm), probes, first, remarks })
    }

    /// The split of a run that read these values at its probes.
    pub(super) fn with(&self, values: &[ProbeReport]) -> Split {
        let value_of = |name: &str| values.iter().find(|probe| probe.name == name);
        let probes = self.probes.iter().filter_map(|at| {
            let value = value_of(&at.name)?.value;
            let [d, deff] = at.diffused;
            let way = [
                (self.first, d),
                ("Deff", deff),
                ("interpolation", at.interpolated),
                ("dispersion", at.semi_discrete),
                ("step", value),
            ];
            let mut before = at.exact;
            let part = |(name, after): (&str, f64)| {
                let value = after - before;
                let relative = Some(value / before).filter(|part| part.is_finite());
                before = after;
                Part { name: name.to_owned(), value, relative }
            };
            let parts = way.map(part).to_vec();
            Some(ProbeSplit { name: at.name.clone(), value, exact: at.exact, parts })
        });
        Split {
            space_l2_relative: self.l2_relative,
            probes: probes.collect(),
            remarks: self.remarks.clone(),
        }
    }
}

/// A place in spacings, on the one particle of axes past the dimension.
fn inside(place: [f64; 3], dimension: usize) -> [f64; 3] {
    [0, 1, 2].map(|axis| if axis < dimension { place[axis] } else { 0.5 })
}

/// The lattice of a scene whose modes are known.
fn lattice(problem: &Problem) -> Result<LatticeScene, String> {
    let lattice = LatticeScene::of(problem).map_err(str::to_owned)?;
    if problem.has_curves() {
        return Err(
            "the case has a material that melts or whose conductivity depends on temperature"
                .to_owned(),
        );
    }
    if !problem.held.is_empty() {
        return Err("the case holds the values of particles".to_owned());
    }
    if !matches!(FoldNeeds::of(problem), FoldNeeds::None | FoldNeeds::Insulated) {
        return Err("a wall or a source of the case imposes something".to_owned());
    }
    let is_mirror = |end: &End| match end {
        End::Free => true,
        End::Mirror(factors) => factors.iter().all(|factor| *factor == 1.0),
    };
    let is_known = |edge: &Edge| match edge {
        Edge::Periodic => true,
        Edge::Open(ends) => ends.iter().all(is_mirror),
    };
    if !lattice.edges.iter().all(is_known) {
        return Err("a wall of the case is no mirror of equal values".to_owned());
    }
    if problem.time.method == MethodChoice::Given(Method::Steady) || problem.time.end == 0.0 {
        return Err("no time passes".to_owned());
    }
    Ok(lattice)
}

/// What the split is against, and what its first part is called: of equal masses, the point source
/// that they stand for.
fn reference(exact: &Solution) -> (Solution, &'static str) {
    const SOURCE: &str = "source extent";
    match exact {
        Solution::MassesInBox(masses) => {
            let source = PointSourceInBox {
                walls: masses.walls.clone(),
                amount: masses.amount,
                at: masses.at,
                porosity: 1.0,
            };
            (Solution::PointSourceInBox(source), SOURCE)
        }
        Solution::PointSource(_) | Solution::PointSourceInBox(_) => (exact.clone(), SOURCE),
        _ => (exact.clone(), "initial state"),
    }
}

/// What to say of free edges, which are taken for mirrors.
fn remark(problem: &Problem, lattice: &LatticeScene, field: &[f64]) -> Option<String> {
    let is_free = |axis: usize, upper: bool| lattice.edges[axis].is_free(upper);
    let free: Vec<(usize, bool)> = (0..problem.dimension)
        .flat_map(|axis| [(axis, false), (axis, true)])
        .filter(|&(axis, upper)| is_free(axis, upper))
        .collect();
    if free.is_empty() {
        return None;
    }
    let reach = problem.kernel.support_radius();
    let is_near = |x: &DVec3| {
        free.iter().any(|&(axis, upper)| match upper {
            true => problem.domain.max[axis] - x[axis] < reach,
            false => x[axis] - problem.domain.min[axis] < reach,
        })
    };
    let largest = |near: bool| {
        let at = problem.particles.position.iter().zip(field);
        let of = at.filter(|(x, _)| !near || is_near(x));
        of.map(|(_, value)| value.abs()).fold(0.0, f64::max)
    };
    let part = 100.0 * largest(true) / largest(false).max(f64::MIN_POSITIVE);
    // One figure for all spacings, so that the remark is said once.
    let rounded = part.log10().ceil();
    let most = if part > 0.0 { 10f64.powf(rounded) } else { 0.0 };
    Some(format!(
        "Free edges are taken for insulated walls; what they change is counted with the step. The \
         field within their reach is below {most} % of its largest value."
    ))
}

#[cfg(test)]
mod tests;
