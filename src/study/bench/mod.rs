//! The benchmark: throughput of uniform lattices beside what the machine can do at most.

mod cost;
mod growth;
mod measure;
mod room;
mod scene;

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::memory::free_memory;
use crate::report::bench::{BENCH_VERSION, BenchReport, LeftOutSize, LimitReport, SeriesReport};
use crate::report::run::DIFFUSPH_VERSION;
use crate::solver::{Limits, Machine, Path, PathWish, Precision, SolverError, limits};

/// The least size: in a smaller box hardly a particle is far from every edge.
pub const LEAST_SIZE: u64 = 1000;

/// Limits are measured for so many times as long as the rest, which is compared with them.
const LIMIT_SHARE: u32 = 4;

/// What is measured, and for how long.
#[derive(Debug)]
pub struct BenchOptions<'a> {
    /// Where it runs, whatever the precision.
    pub machine: &'a Machine,
    /// The precisions, of those that the machine has.
    pub precisions: Vec<Precision>,
    /// The paths.
    pub paths: Vec<PathWish>,
    /// Numbers of particles, about.
    pub sizes: Vec<u64>,
    /// Dimensions of the scenes: 2, 3 or both.
    pub dimensions: Vec<usize>,
    /// Values of H / dx.
    pub support_ratios: Vec<f64>,
    /// The least duration of a measurement.
    pub least: Duration,
    /// Sizes whose set-up is expected to take longer are left out.
    pub most_setup: Duration,
}

/// What came of a benchmark.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchOutcome {
    /// The report, up to where it was stopped.
    pub report: BenchReport,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
}

/// Where a benchmark is.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchProgress {
    /// Measurements done or left out.
    pub done: u64,
    /// All measurements.
    pub all: u64,
    /// What is measured next.
    pub what: String,
}

/// What stays the same while the size grows.
#[derive(Clone, Debug, PartialEq)]
struct Series {
    path: PathWish,
    precision: Precision,
    dimension: usize,
    support_ratio: f64,
}

/// A series with what is known of it.
struct Progressing {
    series: Series,
    machine: Machine,
    limits: Limits,
    /// Particles of the last size, and the seconds that its set-up took.
    last: Option<(u64, f64)>,
    /// Whether no size of it can run here.
    closed: bool,
    report: SeriesReport,
    left_out: Vec<LeftOutSize>,
}

/// Measures the limits of the machine, then every series at every size. `progress` is told what
/// comes next, and may stop it.
///
/// A size that does not fit into memory or takes too long to set up is left out, with the reason.
///
/// # Errors
/// A device that fails otherwise.
pub fn bench(
    options: &BenchOptions<'_>,
    progress: &mut dyn FnMut(BenchProgress) -> ControlFlow<()>,
) -> Result<BenchOutcome, SolverError> {
    let mut bench = Bench::new(options, progress);
    let interrupted = bench.run()?.is_break();
    Ok(BenchOutcome { report: bench.finish(), interrupted })
}

struct Bench<'a> {
    options: &'a BenchOptions<'a>,
    progress: &'a mut dyn FnMut(BenchProgress) -> ControlFlow<()>,
    done: u64,
    all: u64,
    all_series: Vec<Progressing>,
    report: BenchReport,
}

impl<'a> Bench<'a> {
    fn new(
        options: &'a BenchOptions<'a>,
        progress: &'a mut dyn FnMut(BenchProgress) -> ControlFlow<()>,
    ) -> Self {
        let machine = options.machine;
        let series = options.paths.len() * options.dimensions.len() * options.support_ratios.len();
        let of_precision = 1 + series * options.sizes.len();
        let report = BenchReport {
            bench_version: BENCH_VERSION,
            diffusph_version: DIFFUSPH_VERSION.to_owned(),
            backend: machine.kind().backend_name().to_owned(),
            adapter: machine.adapter().map(str::to_owned),
            threads: rayon::current_num_threads(),
            instructions: match machine {
                Machine::Cpu => Some(limits::instructions().to_owned()),
                Machine::Gpu { .. } => None,
            },
            least_s: options.least.as_secs_f64(),
            limits: Vec::new(),
            series: Vec::new(),
            left_out: Vec::new(),
            warnings: Vec::new(),
        };
        let all = (of_precision * options.precisions.len()) as u64;
        Self { options, progress, done: 0, all, all_series: Vec::new(), report }
    }

    fn run(&mut self) -> Result<ControlFlow<()>, SolverError> {
        for &precision in &self.options.precisions {
            if self.tell(format!("limits in {}", precision.name())).is_break() {
                return Ok(ControlFlow::Break(()));
            }
            self.measure_limits(precision)?;
            self.done += 1;
        }
        for &dimension in &self.options.dimensions {
            for &size in &self.options.sizes {
                if self.at_size(dimension, size)?.is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    fn tell(&mut self, what: String) -> ControlFlow<()> {
        (self.progress)(BenchProgress { done: self.done, all: self.all, what })
    }

    /// Measures the limits in `precision`, and begins its series.
    fn measure_limits(&mut self, precision: Precision) -> Result<(), SolverError> {
        let options = self.options;
        let machine = options.machine.in_precision(precision);
        let limits = Limits::measure(&machine, LIMIT_SHARE * options.least, free_memory() / 8)?;
        self.report.limits.push(LimitReport {
            precision: precision.name().to_owned(),
            copy_bytes_per_s: limits.copy,
            copy_one_thread_bytes_per_s: limits.copy_one_thread,
            read_bytes_per_s: limits.read,
            operations_per_s: limits.arithmetic,
        });
        for &dimension in &options.dimensions {
            for &support_ratio in &options.support_ratios {
                for &path in &options.paths {
                    let series = Series { path, precision, dimension, support_ratio };
                    let machine = machine.in_precision(precision);
                    self.all_series.push(Progressing::new(series, machine, limits));
                }
            }
        }
        Ok(())
    }

    /// Measures every series of a dimension at `size`, on one scene.
    fn at_size(&mut self, dimension: usize, size: u64) -> Result<ControlFlow<()>, SolverError> {
        let particles = scene::count(size, dimension);
        let free = free_memory();
        let mut fitting = Vec::new();
        for (index, of) in self.all_series.iter_mut().enumerate() {
            if of.series.dimension != dimension || of.closed {
                continue;
            }
            let why = of.why_left_out(particles, free, self.options.most_setup);
            match why {
                Some(why) => of.leave_out(Some(size), why),
                None => fitting.push(index),
            }
        }
        let here = self.all_series.iter().filter(|of| of.series.dimension == dimension).count();
        self.done += (here - fitting.len()) as u64;
        // Not built where nothing would run on it.
        let Some(&first) = fitting.first() else {
            return Ok(ControlFlow::Continue(()));
        };
        let clock = Instant::now();
        let ratio = self.all_series[first].series.support_ratio;
        let mut problem = scene::scene(size, dimension, ratio);
        let build_s = clock.elapsed().as_secs_f64();
        for index in fitting {
            let series = self.all_series[index].series.clone();
            if self.tell(series.at(size)).is_break() {
                return Ok(ControlFlow::Break(()));
            }
            scene::widen(&mut problem, series.support_ratio);
            self.measure(index, &problem, size, build_s)?;
            self.done += 1;
        }
        Ok(ControlFlow::Continue(()))
    }

    /// The report, with how time grows in each series.
    fn finish(mut self) -> BenchReport {
        for of in self.all_series {
            self.report.left_out.extend(of.left_out);
            let mut report = of.report;
            report.growth = growth::growth(&report.measurements);
            if !report.measurements.is_empty() {
                self.report.series.push(report);
            }
        }
        self.report
    }
}

impl Progressing {
    fn new(series: Series, machine: Machine, limits: Limits) -> Self {
        let report = SeriesReport {
            path: series.path_name().to_owned(),
            precision: series.precision.name().to_owned(),
            dimension: series.dimension,
            support_ratio: series.support_ratio,
            measurements: Vec::new(),
            growth: growth::growth(&[]),
        };
        Self { series, machine, limits, last: None, closed: false, report, left_out: Vec::new() }
    }

    /// Leaves out a size, or all of them.
    fn leave_out(&mut self, size: Option<u64>, why: String) {
        let SeriesReport { path, precision, dimension, support_ratio, .. } = &self.report;
        self.left_out.push(LeftOutSize {
            path: path.clone(),
            precision: precision.clone(),
            dimension: *dimension,
            support_ratio: *support_ratio,
            size,
            why,
        });
    }

    /// Why `particles` particles are left out.
    fn why_left_out(&self, particles: u64, free: u64, most_setup: Duration) -> Option<String> {
        let too_slow = || room::why_too_slow(particles, self.last, most_setup.as_secs_f64());
        room::why_too_many(&self.series, &self.machine, particles, free).or_else(too_slow)
    }
}

impl Series {
    fn path_name(&self) -> &'static str {
        match self.path {
            PathWish::Auto => Path::List.name(),
            path => path.name(),
        }
    }

    /// A measurement in words.
    fn at(&self, size: u64) -> String {
        let Self { precision, dimension, support_ratio, .. } = self;
        let (path, precision) = (self.path_name(), precision.name());
        format!("{path}, {precision}, {dimension}-D, H/dx {support_ratio}, {size} particles")
    }
}
