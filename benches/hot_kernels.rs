//! The hot parts of the CPU path on the lattice of the `gaussian` case, with 46^3 = 97 336
//! particles: the sort into cells, the assembly of the rows, one Euler step.

use criterion::{Criterion, Throughput};
use diffusph::case::{self, Override};
use diffusph::model::Problem;
use diffusph::model::operator::rows::{assemble, cell_grid, survey};
use diffusph::model::stability::safe_step;
use diffusph::solver::Backend;
use diffusph::solver::cpu::CpuBackend;

/// The lattice distance, m: even counts keep the deposit on eight particles.
const SPACING: &str = "particles.spacing=50/46";

fn lattice() -> Problem {
    let spacing = Override::parse(SPACING).expect("an override");
    case::load("gaussian", &[spacing]).expect("a shipped case").problem
}

fn hot_kernels(criterion: &mut Criterion) {
    let problem = lattice();
    let mut group = criterion.benchmark_group("gaussian");
    group.throughput(Throughput::Elements(problem.particles.len() as u64));
    group.bench_function("cell sort", |bencher| bencher.iter(|| cell_grid(&problem)));
    let grid = cell_grid(&problem);
    group.bench_function("assembly", |bencher| bencher.iter(|| assemble(&problem, &grid)));
    let step = safe_step(survey(&problem, &grid).rate_bound);
    let mut backend = CpuBackend::of(&problem);
    group.bench_function("Euler step", |bencher| {
        bencher.iter(|| backend.euler(0.0, step, 1).expect("a step"));
    });
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    hot_kernels(&mut criterion);
    criterion.final_summary();
}
