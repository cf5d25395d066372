//! Smoothed particle hydrodynamics (SPH) for diffusion and heat conduction: on the GPU through
//! wgpu compute shaders, with a matching f64 CPU path.
//!
//! The way of a scene through the crate, top to bottom (each module may use only those below it
//! in this list; `tests/architecture.rs` checks it):
//!
//! | module | what it holds | may use |
//! |---|---|---|
//! | [`cli`] | one file a subcommand | everything but `exact` |
//! | [`study`] | drivers: one run of a scene with its report, a study of many settings, numerical stability, the benchmark | `case solver exact report model` |
//! | [`case`] | case file, expressions, shapes: JSON to a [`model::Problem`] | `exact model` |
//! | [`solver`] | plan, backend trait, CPU and GPU backends, the time loop, limits of a machine | `gpu model` |
//! | [`report`] | norms, JSON, CSV, VTK and SVG output | `model` |
//! | [`exact`] | analytic solutions | `model` |
//! | [`gpu`] | device, buffers, shader linking, scan and sort: no physics | wgpu alone |
//! | [`model`] | the physics in f64: kernels, operator, neighbours, stability | nothing |

pub mod case;
pub mod cli;
pub mod exact;
pub mod gpu;
pub mod model;
pub mod report;
pub mod solver;
pub mod study;
