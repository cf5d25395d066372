use glam::DVec3;

use super::*;
use crate::model::operator::rows::{Rows, assemble, cell_grid, wall_fold};
use crate::model::scenes::{Noise, lattice};
use crate::model::{
    Condition, Correction, Face, KernelKind, Material, PairMean, Problem, Region, ScalarField,
    Surface, Wall, WallKind,
};

#[path = "fold_tests/surfaces.rs"]
mod surfaces;

/// Value and gradient of the linear field of these tests.
const OFFSET: f64 = 4.0;
const GRADIENT: DVec3 = DVec3::new(3.0, -2.0, 1.5);
/// Transfer coefficient of these tests.
const COEFFICIENT: f64 = 2.5;

fn linear(x: DVec3) -> f64 {
    OFFSET + GRADIENT.dot(x)
}

fn field(f: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> ScalarField {
    ScalarField::new("test", move |x, _| f(x)).depending_on(true, false)
}

/// The condition of this kind on `face` that the linear field satisfies, in a material of this
/// conductivity.
fn satisfied(kind: WallKind, face: Face, conductivity: f64) -> Condition {
    let outward = if face.upper { 1.0 } else { -1.0 };
    let flux = conductivity * outward * GRADIENT[face.axis];
    match kind {
        WallKind::Free => Condition::free(),
        WallKind::Insulated => Condition::insulated(),
        WallKind::Value => Condition::value(field(linear)),
        WallKind::Flux => Condition::flux(field(move |_| flux)),
        WallKind::Convection => Condition::convection(
            field(|_| COEFFICIENT),
            field(move |x| linear(x) + flux / COEFFICIENT),
        ),
    }
}

fn wall(face: Face, condition: Condition) -> Wall {
    Wall { name: "wall".into(), face, covers: None, condition }
}

/// A lattice with walls of one kind on every face, which the linear field satisfies.
fn walled(kernel: KernelKind, dimension: usize, support_ratio: f64, kind: WallKind) -> Problem {
    let counts = std::array::from_fn(|axis| if axis < dimension { 8 - axis } else { 1 });
    let mut problem = lattice(kernel, dimension, counts, 0.25, support_ratio);
    problem.walls =
        Face::all(dimension).map(|face| wall(face, satisfied(kind, face, 1.0))).collect();
    problem
}

fn state_of(problem: &Problem, mut f: impl FnMut(DVec3) -> f64) -> Vec<f64> {
    problem.particles.position.iter().map(|&x| f(x)).collect()
}

/// A scene as a matrix, with everything in cell order.
struct Assembled {
    order: Vec<u32>,
    rows: Rows,
    source: Vec<f64>,
}

impl Assembled {
    fn new(problem: &Problem) -> Self {
        let grid = cell_grid(problem);
        let (_, rows) = assemble(problem, &grid);
        let mut source = Vec::new();
        rows.sources().source_at(0.0, &mut source);
        Self { order: grid.into_order(), rows, source }
    }

    fn by_rank(&self, state: &[f64]) -> Vec<f64> {
        self.order.iter().map(|&p| state[p as usize]).collect()
    }

    fn rate(&self, state: &[f64]) -> Vec<f64> {
        let by_rank = self.by_rank(state);
        let mut rate = vec![f64::NAN; state.len()];
        self.rows.apply(&by_rank, &self.source, &mut rate, |_, rate| rate);
        let mut out = vec![0.0; state.len()];
        for (&p, rate) in self.order.iter().zip(rate) {
            out[p as usize] = rate;
        }
        out
    }

    /// The matrix, column by column, as volume x rate.
    fn columns(&self, problem: &Problem) -> Vec<Vec<f64>> {
        let n = problem.particles.len();
        let zero = self.rate(&vec![0.0; n]);
        (0..n)
            .map(|b| {
                let mut unit = vec![0.0; n];
                unit[b] = 1.0;
                let rate = self.rate(&unit);
                let volume = &problem.particles.volume;
                (0..n).map(|a| volume[a] * (rate[a] - zero[a])).collect()
            })
            .collect()
    }

    /// What held particles and walls give, value x volume a second.
    fn given(&self, problem: &Problem, state: &[f64]) -> f64 {
        let by_rank = self.by_rank(state);
        let held = self.rows.held_rank().iter().zip(self.rows.held_rates(&by_rank));
        let volume = |rank: u32| problem.particles.volume[self.order[rank as usize] as usize];
        let by_held: f64 = held.map(|(&rank, rate)| -volume(rank) * rate).sum();
        by_held + self.rows.sources().inflow(&by_rank, Some(&self.source))
    }
}

/// The largest |A_ab - A_ba| over the largest |A_ab|.
fn asymmetry(columns: &[Vec<f64>]) -> f64 {
    let n = columns.len();
    let pairs = || (0..n).flat_map(|a| (0..n).map(move |b| (a, b)));
    let apart = pairs().map(|(a, b)| (columns[a][b] - columns[b][a]).abs()).fold(0.0, f64::max);
    apart / pairs().map(|(a, b)| columns[a][b].abs()).fold(0.0, f64::max)
}

fn each_kernel_and_dimension(mut check: impl FnMut(KernelKind, usize, f64)) {
    for kernel in KernelKind::ALL {
        for dimension in (1..=3).filter(|&d| kernel.is_defined_in(d)) {
            for support_ratio in [2.0, 2.6, 4.0] {
                check(kernel, dimension, support_ratio);
            }
        }
    }
}

#[test]
fn a_linear_field_that_satisfies_the_walls_has_no_rate_corners_included() {
    for kind in [WallKind::Value, WallKind::Flux, WallKind::Convection] {
        each_kernel_and_dimension(|kernel, dimension, support_ratio| {
            let problem = walled(kernel, dimension, support_ratio, kind);
            let assembled = Assembled::new(&problem);
            let size = 10.0 / problem.spacing.powi(2);
            let worst = assembled.rate(&state_of(&problem, linear)).into_iter();
            let worst = worst.fold(0.0, |w: f64, r| w.max(r.abs())) / size;
            assert!(worst < 1e-12, "{kernel:?} {dimension}-D {support_ratio} {kind:?}: {worst:e}");
        });
    }
}

#[test]
fn a_wrong_sign_a_missing_corner_and_a_wrong_foot_are_noticed() {
    let rate = |problem: &Problem| {
        let rates = Assembled::new(problem).rate(&state_of(problem, linear));
        rates.into_iter().fold(0.0, |w: f64, r| w.max(r.abs()))
    };
    let flux = walled(KernelKind::CubicSpline, 2, 2.0, WallKind::Flux);
    let size = 1e-3 / flux.spacing.powi(2);
    let mut sign = flux.clone();
    sign.walls[0].condition = Condition::flux(field(|_| GRADIENT.x));
    assert!(rate(&sign) > size);
    // A corner of two values whose ghosts only know one order of mirroring, at the inner foot.
    let value = walled(KernelKind::CubicSpline, 2, 2.0, WallKind::Value);
    let mut corner = value.clone();
    let inside = |x: DVec3| x.clamp(DVec3::ZERO, DVec3::new(2.0, 1.75, 0.0));
    for wall in &mut corner.walls {
        wall.condition = Condition::value(field(move |x| linear(inside(x))));
    }
    assert!(rate(&value) < 1e-12 / value.spacing.powi(2) && rate(&corner) > size);
    // A wall that is missing.
    let mut missing = value;
    missing.walls.remove(2);
    assert!(rate(&missing) > size);
}

#[test]
fn insulated_walls_keep_every_total_and_constants() {
    each_kernel_and_dimension(|kernel, dimension, support_ratio| {
        for correction in Correction::ALL {
            let scene = walled(kernel, dimension, support_ratio, WallKind::Insulated);
            let problem = Problem { correction, ..scene };
            let assembled = Assembled::new(&problem);
            assert!(assembled.rows.sources().is_empty(), "insulation is free at run time");
            assert!(assembled.rate(&vec![7.25; problem.particles.len()]).iter().all(|&r| r == 0.0));
            let mut noise = Noise(3);
            let rate = assembled.rate(&state_of(&problem, |_| noise.next()));
            let size: f64 = rate.iter().map(|r| r.abs()).sum();
            assert!(rate.iter().sum::<f64>().abs() < 64.0 * f64::EPSILON * size);
        }
    });
}

#[test]
fn a_flux_enters_in_full_in_every_scene_materials_and_correction_included() {
    each_kernel_and_dimension(|kernel, dimension, support_ratio| {
        for correction in Correction::ALL {
            for pair_mean in PairMean::ALL {
                let scene = walled(kernel, dimension, support_ratio, WallKind::Insulated);
                let mut problem = Problem { correction, pair_mean, ..scene };
                let fast = Material::diffusive("b", 50.0, 1.0);
                problem.materials.push(fast);
                let odd = |(k, m): (usize, &mut u16)| *m = u16::from(k % 3 == 0);
                problem.particles.material.iter_mut().enumerate().for_each(odd);
                let flux = Condition::flux(ScalarField::constant(0.75));
                problem.walls[0].condition = flux;
                let state = vec![3.0; problem.particles.len()];
                let extent = problem.domain.extent();
                let area: f64 = (1..dimension).map(|axis| extent[axis]).product();
                let given = Assembled::new(&problem).given(&problem, &state);
                let off = (given / (0.75 * area) - 1.0).abs();
                assert!(off < 1e-12, "{kernel:?} {dimension}-D {support_ratio}: {off:e}");
            }
        }
    });
}

/// A 2-D plate with all kinds on every face, in patches, and a held region in a corner.
fn patchwork(kernel: KernelKind, support_ratio: f64, kinds: &[WallKind]) -> Problem {
    let mut problem = walled(kernel, 2, support_ratio, WallKind::Insulated);
    problem.walls.clear();
    for (k, face) in Face::all(2).enumerate() {
        let along = 1 - face.axis;
        for part in 0..3 {
            let covers = Region::new(move |x| (x[along] / 0.6).floor() as i64 == part);
            let kind = kinds[(k + part as usize) % kinds.len()];
            let condition = match kind {
                WallKind::Flux => Condition::flux(field(|x| 1.0 + x.y)),
                kind => satisfied(kind, face, 1.0),
            };
            problem.walls.push(Wall { covers: Some(covers), ..wall(face, condition) });
        }
    }
    problem.held = vec![0, 1, 8, 9, 33];
    problem.materials.push(Material::diffusive("b", 20.0, 1.0));
    problem.particles.material[20..40].fill(1);
    problem
}

#[test]
fn patches_leave_the_matrix_symmetric_where_no_convection_reaches_past_a_layer() {
    let without = [WallKind::Value, WallKind::Flux, WallKind::Insulated, WallKind::Free];
    for kernel in KernelKind::ALL.into_iter().filter(|kernel| kernel.is_defined_in(2)) {
        for (support_ratio, kinds) in
            [(2.0, &WallKind::ALL[..]), (2.6, &without), (4.0, &without), (4.0, &WallKind::ALL)]
        {
            let mut problem = patchwork(kernel, support_ratio, kinds);
            problem.held.clear();
            let columns = Assembled::new(&problem).columns(&problem);
            let wide_convection = support_ratio > 2.0 && kinds.len() == 5;
            let found = asymmetry(&columns);
            let survey = crate::model::operator::rows::survey(&problem, &cell_grid(&problem));
            assert_eq!(survey.symmetric, !wide_convection, "{kernel:?} {support_ratio}");
            if wide_convection {
                assert!(found > 1e-6, "the test is sharp: {found:e}");
            } else {
                assert!(found < 1e-14, "{kernel:?} {support_ratio}: {found:e}");
            }
        }
    }
}

#[test]
fn what_walls_and_held_particles_give_is_what_the_others_gain() {
    for support_ratio in [2.0, 2.6, 4.0] {
        let problem = patchwork(KernelKind::WendlandC4, support_ratio, &WallKind::ALL);
        let assembled = Assembled::new(&problem);
        let mut noise = Noise(11);
        let state = state_of(&problem, |_| noise.next());
        let rate = assembled.rate(&state);
        let gained: f64 = rate.iter().zip(&problem.particles.volume).map(|(r, v)| r * v).sum();
        let size: f64 = rate.iter().zip(&problem.particles.volume).map(|(r, v)| r.abs() * v).sum();
        let off = (gained - assembled.given(&problem, &state)).abs() / size;
        assert!(off < 64.0 * f64::EPSILON, "{support_ratio}: {off:e}");
    }
}

#[test]
fn a_periodic_axis_beside_walls_is_seamless() {
    for kind in [WallKind::Insulated, WallKind::Value, WallKind::Flux, WallKind::Convection] {
        let mut problem = walled(KernelKind::WendlandC2, 2, 3.0, kind);
        problem.domain.periodic[1] = true;
        problem.walls.retain(|wall| wall.face.axis == 0);
        for wall in &mut problem.walls {
            let condition = satisfied(kind, wall.face, 1.0);
            // The same at every y.
            let flat = field(move |x| condition.imposed.at(DVec3::new(x.x, 0.0, 0.0), 0.0));
            wall.condition.imposed = flat;
        }
        let along_x = state_of(&problem, |x| x.x * x.x);
        let rate = Assembled::new(&problem).rate(&along_x);
        for row in rate.chunks(8) {
            let apart = row.iter().zip(&rate).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-11, "{kind:?}: {apart:e}");
        }
    }
}

#[test]
fn the_fold_alone_and_the_assembled_rows_agree() {
    let problem = patchwork(KernelKind::CubicSpline, 2.6, &WallKind::ALL);
    let grid = cell_grid(&problem);
    let fold = wall_fold(&problem, &grid);
    let assembled = Assembled::new(&problem);
    let mut bare = problem.clone();
    bare.walls.clear();
    let mut noise = Noise(7);
    let state = state_of(&problem, |_| noise.next());
    let mut by_rank = Assembled::new(&bare);
    by_rank.order = (0..by_rank.order.len() as u32).collect();
    let ranked = assembled.by_rank(&state);
    let mut rate = by_rank.rate(&ranked);
    // Both know where materials meet.
    let twice = wall_fold(&bare, &cell_grid(&bare)).weight;
    let twice = twice.iter().map(|&(row, neighbor, weight)| (row, neighbor, -weight));
    for (row, neighbor, weight) in fold.weight.iter().copied().chain(twice) {
        let difference = ranked[neighbor as usize] - ranked[row as usize];
        rate[row as usize] += weight * difference;
    }
    let mut source = Vec::new();
    fold.rows.source_at(0.0, &mut source);
    for (k, &rank) in fold.rows.rank().iter().enumerate() {
        rate[rank as usize] += fold.rows.diagonal()[k] * ranked[rank as usize] + source[k];
    }
    let whole = assembled.by_rank(&assembled.rate(&state));
    for (rank, (a, b)) in rate.iter().zip(&whole).enumerate() {
        let held = problem.is_held(assembled.order[rank] as usize);
        assert!(held || (a - b).abs() < 1e-11 * 400.0, "{rank}: {a} {b}");
    }
}

/// The area (length in 2-D, 1 in 1-D) of the face x_min.
fn area_of_x_min(problem: &Problem) -> f64 {
    let extent = problem.domain.extent();
    (1..problem.dimension).map(|axis| extent[axis]).product()
}

#[test]
fn a_flux_enters_in_full_beside_free_faces() {
    each_kernel_and_dimension(|kernel, dimension, support_ratio| {
        let mut problem = walled(kernel, dimension, support_ratio, WallKind::Free);
        problem.walls[0].condition = Condition::flux(ScalarField::constant(0.75));
        let state = vec![3.0; problem.particles.len()];
        let given = Assembled::new(&problem).given(&problem, &state);
        let off = given / (0.75 * area_of_x_min(&problem)) - 1.0;
        assert!(off.abs() < 1e-12, "{kernel:?} {dimension}-D {support_ratio}: {off:e}");
    });
}

#[test]
fn a_patch_takes_its_flux_in_full_and_neighbours_share_their_edge() {
    for kernel in KernelKind::ALL.into_iter().filter(|kernel| kernel.is_defined_in(3)) {
        for support_ratio in [2.0, 2.6, 4.0] {
            let mut problem = walled(kernel, 3, support_ratio, WallKind::Insulated);
            // Edges on the boundaries of cells, where pairs cross exactly.
            let patch = |from: f64, to: f64, flux: f64| Wall {
                covers: Some(Region::new(move |x| x.y >= from - 1e-12 && x.y <= to + 1e-12)),
                ..wall(Face { axis: 0, upper: false }, Condition::flux(ScalarField::constant(flux)))
            };
            problem.walls.extend([patch(0.5, 1.0, 1.0), patch(1.0, 1.25, 2.0)]);
            let state = vec![3.0; problem.particles.len()];
            let given = Assembled::new(&problem).given(&problem, &state);
            let expected = (0.5 + 2.0 * 0.25) * problem.domain.extent().z;
            assert!((given / expected - 1.0).abs() < 1e-12, "{kernel:?} {support_ratio}: {given}");
        }
    }
}

#[test]
fn walls_of_different_kinds_meet_in_a_corner_without_a_rate() {
    let kinds = [WallKind::Value, WallKind::Flux, WallKind::Convection];
    each_kernel_and_dimension(|kernel, dimension, support_ratio| {
        for shift in 0..3 {
            let mut problem = walled(kernel, dimension, support_ratio, WallKind::Free);
            for (k, wall) in problem.walls.iter_mut().enumerate() {
                wall.condition = satisfied(kinds[(k + shift) % 3], wall.face, 1.0);
            }
            let rates = Assembled::new(&problem).rate(&state_of(&problem, linear));
            let worst = rates.into_iter().fold(0.0, |w: f64, r| w.max(r.abs()));
            let size = 10.0 / problem.spacing.powi(2);
            assert!(worst < 1e-12 * size, "{kernel:?} {dimension}-D {support_ratio}: {worst:e}");
        }
    });
}

#[test]
fn a_missing_corner_is_noticed() {
    let mut problem = walled(KernelKind::CubicSpline, 2, 2.0, WallKind::Value);
    let near_corner = 0.01 * problem.spacing;
    problem.walls[0].covers = Some(Region::new(move |x| x.y > near_corner));
    let rates = Assembled::new(&problem).rate(&state_of(&problem, linear));
    let noticed = rates.iter().filter(|rate| rate.abs() > 1e-6 / problem.spacing.powi(2)).count();
    // Only the particle in the corner has a ghost behind it.
    assert_eq!(noticed, 1, "{rates:?}");
}

#[test]
fn a_value_that_changes_in_time_changes_the_source_alone() {
    let mut problem = walled(KernelKind::CubicSpline, 2, 2.6, WallKind::Value);
    let at = |t: f64| {
        let mut steady = problem.clone();
        for wall in &mut steady.walls {
            wall.condition = Condition::value(field(move |x| (x.x + x.y) * t));
        }
        Assembled::new(&steady).source
    };
    let expected = [at(0.0), at(2.0)];
    for wall in &mut problem.walls {
        wall.condition = Condition::value(ScalarField::new("(x+y)*t", |x, t| (x.x + x.y) * t));
    }
    let assembled = Assembled::new(&problem);
    assert!(assembled.rows.sources().is_changing());
    for (t, expected) in [0.0, 2.0].into_iter().zip(&expected) {
        let mut source = Vec::new();
        assembled.rows.sources().source_at(t, &mut source);
        let apart = source.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-12 * 400.0, "{t}: {apart:e}");
    }
}
