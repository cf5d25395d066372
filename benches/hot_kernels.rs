//! The hot parts of the CPU paths on the lattice of the `gaussian` case, with 46^3 = 97 336
//! particles: the sort into cells, the assembly of the rows, one Euler step by list and by lattice,
//! at H = 2 dx and 3 dx.

use criterion::{Criterion, Throughput};
use diffusph::case::{self, Override};
use diffusph::model::Problem;
use diffusph::model::lattice::LatticeScene;
use diffusph::model::operator::SourceRows;
use diffusph::model::operator::rows::{assemble, cell_grid, survey};
use diffusph::model::stability::safe_step;
use diffusph::solver::Backend;
use diffusph::solver::cpu::CpuBackend;

/// The lattice distance, m: even counts keep the deposit on eight particles.
const SPACING: &str = "particles.spacing=50/46";

fn lattice(support_ratio: u32) -> Problem {
    let set = [SPACING.to_owned(), format!("kernel.support_ratio={support_ratio}")];
    let overrides = set.map(|text| Override::parse(&text).expect("an override"));
    case::load("gaussian", &overrides).expect("a shipped case").problem
}

fn hot_kernels(criterion: &mut Criterion) {
    let problem = lattice(2);
    let mut group = criterion.benchmark_group("gaussian");
    group.throughput(Throughput::Elements(problem.particles.len() as u64));
    group.bench_function("cell sort", |bencher| bencher.iter(|| cell_grid(&problem)));
    let grid = cell_grid(&problem);
    group.bench_function("assembly", |bencher| bencher.iter(|| assemble(&problem, &grid)));
    group.bench_function("recognition of the lattice", |bencher| {
        bencher.iter(|| LatticeScene::of(&problem).expect("a lattice"));
    });
    for support_ratio in [2, 3] {
        let problem = lattice(support_ratio);
        let step = safe_step(survey(&problem, &cell_grid(&problem)).rate_bound);
        let mut list = CpuBackend::of(&problem);
        group.bench_function(format!("step by list, H = {support_ratio} dx"), |bencher| {
            bencher.iter(|| list.euler(0.0, step, 1).expect("a step"));
        });
        let scene = LatticeScene::of(&problem).expect("a lattice");
        let mut lattice = CpuBackend::lattice(&problem, scene, SourceRows::default());
        group.bench_function(format!("step by lattice, H = {support_ratio} dx"), |bencher| {
            bencher.iter(|| lattice.euler(0.0, step, 1).expect("a step"));
        });
    }
    group.finish();
}

fn main() {
    // On a thread of the pool, as commands are.
    rayon::scope(|_| {
        let mut criterion = Criterion::default().configure_from_args();
        hot_kernels(&mut criterion);
        criterion.final_summary();
    });
}
