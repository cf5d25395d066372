//! What can go wrong while solving.

use glam::DVec3;

use super::Precision;
use super::integrator::SolveFailure;
use crate::model::Problem;
use crate::model::operator::fold::Fault;
use crate::model::operator::rows::Survey;

/// A temperature so near an end of what is known of a conductivity, of that end, is one that a step would go
/// beyond.
const NEAR: f64 = 0.01;

/// A run that could not start or go on.
#[derive(Debug, thiserror::Error)]
pub enum SolverError {
    /// The step is above the measured stability limit.
    #[error(
        "step {step:.6e} s is above the stability limit {limit:.6e} s ({:.3} times); \
         lower `time.step`, leave it out for an automatic step, or pass --allow-unstable",
        step / limit
    )]
    UnstableStep {
        /// The step asked for, s.
        step: f64,
        /// The measured limit 2 / lambda_max, s.
        limit: f64,
    },
    /// Two particles sit where the kernel has no finite weight.
    #[error(
        "particles {a} and {b} coincide at {at}, where the kernel `{kernel}` has no finite weight"
    )]
    CoincidentParticles {
        /// Index of the one.
        a: usize,
        /// Index of the other.
        b: usize,
        /// Their position, m.
        at: DVec3,
        /// The kernel's name.
        kernel: &'static str,
    },
    /// A wall or source imposes something that is not finite where a ghost or a particle needs it.
    #[error(
        "{wall}: \"{text}\" is not finite at {at}; where two walls meet, each is also evaluated up \
         to a support radius beyond the body"
    )]
    WallNotFinite {
        /// The wall or surface.
        wall: String,
        /// What it imposes, as written.
        text: String,
        /// Where, m.
        at: DVec3,
    },
    /// There are particles on both sides of a surface.
    #[error(
        "{surface}: the body goes on beyond it, near {at}: a surface must be an outer surface of \
         the body, or that of a hole"
    )]
    SurfaceInside {
        /// The surface.
        surface: String,
        /// A particle beyond it, m.
        at: DVec3,
    },
    /// A value that is not finite came up.
    #[error(
        "the run diverged at step {step} (t = {time:.6e} s): particle {particle} at {position} \
         became {value}"
    )]
    Diverged {
        /// The first step whose result is not finite, from 1.
        step: u64,
        /// The time at the end of that step, s.
        time: f64,
        /// The first particle that is not finite.
        particle: usize,
        /// Its position, m.
        position: DVec3,
        /// Its value.
        value: f64,
    },
    /// A temperature was reached at which a conductivity is not known to be positive.
    #[error(
        "at step {step} (t = {time:.6e} s) particle {particle} at {position} reached T = {temperature:.6} K: the \
         conductivity of \"{material}\" is positive, and taken, from {:.6} to {:.6} K alone; a table of pairs \
         [T, conductivity] goes on beyond its ends", limits[0], limits[1]
    )]
    ConductivityUnknown {
        /// The step that reached it.
        step: u64,
        /// The time then, s.
        time: f64,
        /// The first such particle.
        particle: usize,
        /// Its position, m.
        position: DVec3,
        /// Its temperature, K.
        temperature: f64,
        /// The name of its material.
        material: String,
        /// Temperatures between which the conductivity is known, K.
        limits: [f64; 2],
    },
    /// A value that is not finite came up once, but not when the steps were taken again.
    #[error(
        "a value that is not finite came up after step {step}, but not when the steps were taken \
         again: the device does not repeat its results"
    )]
    NotRepeatable {
        /// The last step known to be good.
        step: u64,
    },
    /// The user stopped the run.
    #[error("interrupted at step {step} (t = {time:.6e} s)")]
    Interrupted {
        /// Steps taken.
        step: u64,
        /// Time reached, s.
        time: f64,
    },
    /// The lattice path is asked for, but cannot be had.
    #[error("--path lattice: {why}; `--path auto` takes the list")]
    NoLattice {
        /// Why, in words.
        why: &'static str,
    },
    /// The matrix-free path is asked for on the CPU.
    #[error("--path matrix-free: only a GPU has it; leave `--path` out, or use `--backend gpu`")]
    MatrixFreeOnCpu,
    /// An adapter is named, but the CPU path is asked for.
    #[error("--adapter {name}: `--backend cpu` uses no adapter; leave one of the two out")]
    AdapterOnCpu {
        /// The name asked for.
        name: String,
    },
    /// A precision that the CPU path does not have.
    #[error("--precision {}: the CPU path is f64 only, and no GPU was chosen", .precision.name())]
    PrecisionOnCpu {
        /// The precision asked for.
        precision: Precision,
    },
    /// A device whose compiler deletes compensated sums.
    #[error("--precision compensated: {fault}; leave the flag out, and what is right is taken")]
    NotCompensated {
        /// What its self-test found.
        fault: String,
    },
    /// A run that f32 may spoil, on a device that has nothing better.
    #[error(
        "{harm}; this adapter has no f64, and {fault}: take `--backend cpu`, or `--precision f32` \
         all the same"
    )]
    NothingBetter {
        /// What f32 would do.
        harm: String,
        /// What the self-test of compensated sums found.
        fault: String,
    },
    /// An implicit method, but a matrix that is not symmetric.
    #[error(
        "the method {method} solves linear systems by conjugate gradients, for which convection on a \
         support wider than two spacings leaves the matrix unsymmetric: take `rkl2`, or \
         `kernel.support_ratio` 2"
    )]
    NotSymmetric {
        /// Its name.
        method: &'static str,
    },
    /// Conjugate gradients that do not get to their goal.
    #[error(
        "the linear system did not converge: {:.1e} after {} iterations, where {:.1e} is asked for; \
         likely the tolerance is below what rounding leaves, the contrast is very large, a source makes the \
         value grow, or what walls impose is not finite",
        failed.reached, failed.iterations, failed.goal
    )]
    NotConverged {
        /// What it had come to.
        failed: SolveFailure,
    },
    /// A steady state of walls or sources that change.
    #[error(
        "what walls or sources impose changes in time: there is no steady state; give another time.method"
    )]
    NeverSteady,
    /// A steady state of several materials of which one's properties depend on temperature.
    #[error(
        "steady does not know several materials of which one's conductivity depends on temperature or which \
         melts: give another time.method"
    )]
    SteadyOfCurves,
    /// Flows from walls and sources that do not cancel, and nothing that takes them up.
    #[error(
        "there is no steady state: {flow:.3e} (value x capacity) a second enter through walls or from sources, \
         and nothing holds a value"
    )]
    NoSteadyState {
        /// What enters a second, value x capacity.
        flow: f64,
    },
    /// A tolerance below what the precision can give.
    #[error(
        "time.tolerance is {tolerance:.1e} here, less than {} can give, {finest:.1e}; raise it, or take \
         a better --precision", .precision.name()
    )]
    TooTight {
        /// What is asked for, in the unit of the field.
        tolerance: f64,
        /// What can be had.
        finest: f64,
        /// The precision.
        precision: Precision,
    },
    /// Linear systems that are to be solved better than the precision can.
    #[error(
        "time.linear_tolerance is {tolerance:.1e}, less than {} can give, {finest:.1e}; raise it, or take \
         a better --precision", .precision.name()
    )]
    LinearTooTight {
        /// What is asked for.
        tolerance: f64,
        /// What can be had.
        finest: f64,
        /// The precision.
        precision: Precision,
    },
    /// Steps that become too small to reach the end.
    #[error(
        "at step {step} (t = {time:.6e} s) the tolerance asks for steps below {dt:.1e} s: raise \
         time.tolerance; where what is imposed jumps, name the times in time.breaks; what is not finite \
         is never accepted"
    )]
    StepTooSmall {
        /// Steps taken.
        step: u64,
        /// Time reached, s.
        time: f64,
        /// The step asked for, s.
        dt: f64,
    },
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] crate::gpu::GpuError),
}

impl SolverError {
    /// Whether the case or the flags are at fault, not the run.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::UnstableStep { .. }
            | Self::CoincidentParticles { .. }
            | Self::WallNotFinite { .. }
            | Self::SurfaceInside { .. }
            | Self::NoLattice { .. }
            | Self::MatrixFreeOnCpu
            | Self::AdapterOnCpu { .. }
            | Self::PrecisionOnCpu { .. }
            | Self::NotCompensated { .. }
            | Self::NothingBetter { .. }
            | Self::NotSymmetric { .. }
            | Self::NeverSteady
            | Self::SteadyOfCurves
            | Self::NoSteadyState { .. }
            | Self::TooTight { .. }
            | Self::LinearTooTight { .. } => true,
            Self::Diverged { .. }
            | Self::ConductivityUnknown { .. }
            | Self::NotRepeatable { .. }
            | Self::Interrupted { .. }
            | Self::NotConverged { .. }
            | Self::StepTooSmall { .. } => false,
            Self::Gpu(error) => error.is_usage(),
        }
    }

    /// Whether the scene is larger than the device or what is left of its memory.
    pub fn is_lack_of_room(&self) -> bool {
        matches!(self, Self::Gpu(error) if error.is_lack_of_room())
    }

    /// Whether the run got as far as its last good step.
    pub fn leaves_a_state(&self) -> bool {
        matches!(
            self,
            Self::Diverged { .. }
                | Self::ConductivityUnknown { .. }
                | Self::Interrupted { .. }
                | Self::StepTooSmall { .. }
        )
    }

    /// Steps whose result was good when the run stopped.
    pub fn good_steps(&self) -> u64 {
        match self {
            Self::Diverged { step, .. } => step - 1,
            Self::ConductivityUnknown { step, .. }
            | Self::Interrupted { step, .. }
            | Self::NotRepeatable { step }
            | Self::StepTooSmall { step, .. } => *step,
            _ => 0,
        }
    }

    /// Refuses a scene with a wall or surface that makes no sense.
    pub fn check_walls(problem: &Problem, survey: &Survey) -> Result<(), Self> {
        survey.fault.map_or(Ok(()), |fault| Err(Self::of_fault(problem, fault)))
    }

    /// What is wrong with a wall or surface, by its name.
    pub fn of_fault(problem: &Problem, fault: Fault) -> Self {
        let walls = problem.walls.iter().map(|wall| &wall.name);
        let surfaces = problem.surfaces.iter().map(|surface| &surface.name);
        let sources = problem.sources.iter().map(|source| &source.name);
        let mut names = walls.chain(surfaces).chain(sources);
        let mut name = |index| names.nth(index).cloned().unwrap_or_default();
        match fault {
            Fault::NotFinite { imposed, at } => {
                let text = problem.imposed()[imposed].text().to_owned();
                Self::WallNotFinite { wall: name(imposed), text, at }
            }
            Fault::Inside { imposed, at } => Self::SurfaceInside { surface: name(imposed), at },
        }
    }

    /// The particle of `state` that is furthest beyond, or nearest to, an end of what is known of its
    /// conductivity, where a run has come to by `step` and `time` (s), if that is beyond or so near that a step
    /// may have gone beyond.
    pub fn of_temperatures(problem: &Problem, state: &[f64], step: u64, time: f64) -> Option<Self> {
        let room = |particle: usize| {
            let curve = problem.curve(particle)?;
            let (temperature, limits) = (curve.temperature(state[particle]), curve.limits());
            let room = (temperature - limits[0]).min(limits[1] - temperature);
            let near = NEAR * limits[0].abs().min(limits[1].abs());
            (room < near).then_some((room, particle, temperature, limits))
        };
        let nearest = (0..state.len()).filter_map(room).min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, particle, temperature, limits) = nearest?;
        let material = usize::from(problem.particles.material[particle]);
        Some(Self::ConductivityUnknown {
            step,
            time,
            particle,
            position: problem.particles.position[particle],
            temperature,
            material: problem.materials[material].name.clone(),
            limits,
        })
    }

    /// Refuses a scene where two particles coincide under a kernel without a weight for them.
    pub fn check_coincident(problem: &Problem, survey: &Survey) -> Result<(), Self> {
        let kernel = problem.kernel.kind();
        match survey.coincident {
            Some((a, b)) if !kernel.definition().finite_at_zero => Err(Self::CoincidentParticles {
                a,
                b,
                at: problem.particles.position[a],
                kernel: kernel.name(),
            }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::KernelKind;
    use crate::model::operator::rows::{cell_grid, survey};
    use crate::model::scenes::lattice;

    #[test]
    fn coincident_particles_are_refused_where_the_kernel_diverges() {
        for (kind, refused) in [(KernelKind::Hat, true), (KernelKind::CubicSpline, false)] {
            let mut problem = lattice(kind, 1, [9, 1, 1], 1.0, 2.0);
            let check = |problem: &Problem| {
                SolverError::check_coincident(problem, &survey(problem, &cell_grid(problem)))
            };
            assert!(check(&problem).is_ok());
            problem.particles.position[6] = problem.particles.position[2];
            assert_eq!(check(&problem).is_err(), refused, "{kind:?}");
        }
    }
}
