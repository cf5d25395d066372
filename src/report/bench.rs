//! The report of a benchmark, as data.

use serde::{Deserialize, Serialize};

/// Version of the report's layout; raised whenever a name or a meaning changes.
pub const BENCH_VERSION: u32 = 2;

/// Throughput beside what the machine can do at most. Units are SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BenchReport {
    /// [`BENCH_VERSION`].
    pub bench_version: u32,
    /// [`super::run::DIFFUSPH_VERSION`].
    pub diffusph_version: String,
    /// `cpu` or `gpu`.
    pub backend: String,
    /// The GPU's name; `null` on the CPU path.
    pub adapter: Option<String>,
    /// Threads of the CPU that work: on all of a run, or on its set-up where a GPU takes the steps.
    pub threads: usize,
    /// The instructions that the arithmetic on the CPU was measured with; `null` on a GPU.
    pub instructions: Option<String>,
    /// The least duration of a measurement, s.
    pub least_s: f64,
    /// What the machine can do at most, by precision.
    pub limits: Vec<LimitReport>,
    /// The measurements.
    pub series: Vec<SeriesReport>,
    /// What was not measured.
    pub left_out: Vec<LeftOutSize>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// What a machine can do at most in a precision: the best of several rounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitReport {
    /// The precision.
    pub precision: String,
    /// Bytes read and written a second in copying arrays far larger than caches.
    pub copy_bytes_per_s: f64,
    /// The same on one thread of the CPU; `null` on a GPU.
    pub copy_one_thread_bytes_per_s: Option<f64>,
    /// Bytes a second in reading an array far larger than caches; `null` on a GPU.
    pub read_bytes_per_s: Option<f64>,
    /// Operations a second in fused multiplications and additions, which count as two.
    pub operations_per_s: f64,
}

/// One way to run one kind of scene, at several sizes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeriesReport {
    /// `lattice` or `list`.
    pub path: String,
    /// The precision.
    pub precision: String,
    /// 2 or 3.
    pub dimension: usize,
    /// H / dx.
    pub support_ratio: f64,
    /// By size.
    pub measurements: Vec<Measurement>,
    /// How time grows with the number of particles.
    pub growth: Growth,
}

/// A size of a series.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// The size asked for.
    pub size: u64,
    /// How many particles the box of about that size has.
    pub particles: u64,
    /// Neighbours of a particle, on average.
    pub neighbors: f64,
    /// Building the scene, which all paths share, s.
    pub build_s: f64,
    /// From the scene to the first step, s: recognising the lattice or finding the neighbours, the
    /// stable step, the operator, the upload.
    pub setup_s: f64,
    /// Steps that were timed.
    pub steps: u64,
    /// Particles x steps a second, in the middle one of several rounds.
    pub updates_per_s: f64,
    /// The same in the slowest round.
    pub slowest_updates_per_s: f64,
    /// The same in the fastest round.
    pub fastest_updates_per_s: f64,
    /// Bytes that an update has to move: the operator and one state read, one state written.
    pub bytes_per_update: f64,
    /// Updates a second x bytes.
    pub bytes_per_s: f64,
    /// That over what a copy reaches. Above 1 where caches hold the state.
    pub copy_fraction: f64,
    /// Those of them that are read.
    pub read_bytes_per_update: f64,
    /// Updates a second x these over what reading reaches; `null` on a GPU.
    pub read_fraction: Option<f64>,
    /// Additions, subtractions and multiplications of an update.
    pub operations_per_update: f64,
    /// Updates a second x operations.
    pub operations_per_s: f64,
    /// That over what the processor reaches.
    pub arithmetic_fraction: f64,
    /// Which limit is the lowest: `copy`, `read` or `arithmetic`.
    pub bound_by: String,
    /// Updates a second that this limit allows.
    pub limit_updates_per_s: f64,
    /// Updates a second over that.
    pub limit_fraction: f64,
    /// Memory of the backend's buffers, bytes.
    pub memory_bytes: u64,
}

/// How the time of a step grows with the number of particles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// p of time ~ N^p, by least squares of the logarithms; `null` for fewer than two sizes.
    pub exponent: Option<f64>,
    /// Sizes from here on count.
    pub from_size: u64,
    /// How many these are.
    pub sizes: usize,
    /// Updates a second at the largest size over those at 1e6; `null` unless there are both.
    pub largest_over_million: Option<f64>,
}

/// What was not measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOutSize {
    /// `lattice` or `list`.
    pub path: String,
    /// The precision.
    pub precision: String,
    /// 2 or 3.
    pub dimension: usize,
    /// H / dx.
    pub support_ratio: f64,
    /// The size; `null` where no size can be measured.
    pub size: Option<u64>,
    /// Why.
    pub why: String,
}
