use std::collections::BTreeSet;

use diffusph::model::neighbors::CellLayout;
use diffusph::model::{Domain, KernelKind, Problem};
use diffusph::solver::Precision;
use diffusph::solver::gpu::{GpuBackend, Sorted};
use glam::DVec3;

use crate::support::{Random, device, first_difference, scene};

/// Positions are multiples of this, and cells are powers of two or, along periodic axes of three
/// cells, unity: all arithmetic on them is exact in f32.
const FINEST: f64 = 1.0 / 64.0;

/// `count` particles at random in a box of `cells` cells of unit size, inside `fraction` of it.
fn random_scene(cells: [u32; 3], periodic: [bool; 3], count: usize, fraction: f64) -> Problem {
    let dimension = cells.iter().filter(|&&n| n > 0).count();
    let max = DVec3::from_array(cells.map(f64::from));
    let mut random = Random(count as u64);
    let mut position = Vec::new();
    for _ in 0..count {
        let steps = max * fraction / FINEST;
        let at = DVec3::new(random.unit(), random.unit(), random.unit()) * steps;
        position.push(at.floor() * FINEST);
    }
    let min = DVec3::ZERO;
    let domain = Domain { min, max, periodic };
    scene(KernelKind::WendlandC2, 1.0, domain, dimension, position)
}

/// Coordinates of the cell of a particle, by division alone.
fn cell_of(grid: &CellLayout, position: DVec3) -> [i64; 3] {
    let at = (position / grid.size).floor();
    [0, 1, 2].map(|axis| (at[axis] as i64).min(i64::from(grid.cells[axis]) - 1))
}

fn id_of(grid: &CellLayout, at: [i64; 3]) -> i64 {
    (at[2] * i64::from(grid.cells[1]) + at[1]) * i64::from(grid.cells[0]) + at[0]
}

/// Particles by cell and then by index, and the first place of each cell.
fn expected_order(grid: &CellLayout, positions: &[DVec3]) -> (Vec<u32>, Vec<u32>) {
    let id: Vec<i64> = positions.iter().map(|&x| id_of(grid, cell_of(grid, x))).collect();
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_by_key(|&i| (id[i as usize], i));
    let mut sorted = id.clone();
    sorted.sort_unstable();
    let starts = (0..=grid.count() as i64)
        .map(|cell| sorted.partition_point(|&of| of < cell) as u32)
        .collect();
    (order, starts)
}

/// The cells to look into along an axis, as steps from the home cell.
fn steps(at: i64, cells: i64, periodic: bool) -> Vec<i64> {
    match (periodic, cells) {
        (true, 1) => vec![0],
        (true, 2) => vec![0, 1],
        (true, _) => vec![-1, 0, 1],
        (false, _) => (-1..=1).filter(|s| (0..cells).contains(&(at + s))).collect(),
    }
}

/// Neighbours of every particle in the order that the device should find them.
fn expected_neighbors(problem: &Problem, grid: &CellLayout) -> Vec<Vec<u32>> {
    let positions = &problem.particles.position;
    let (order, starts) = expected_order(grid, positions);
    let cells = grid.cells.map(i64::from);
    let mut neighbors = vec![Vec::new(); positions.len()];
    for (a, found) in neighbors.iter_mut().enumerate() {
        let home = cell_of(grid, positions[a]);
        let along = |axis: usize| steps(home[axis], cells[axis], problem.domain.periodic[axis]);
        for z in along(2) {
            for y in along(1) {
                for x in along(0) {
                    let step = [x, y, z];
                    let at = [0, 1, 2].map(|i| (home[i] + step[i]).rem_euclid(cells[i]));
                    let id = id_of(grid, at) as usize;
                    let members = &order[starts[id] as usize..starts[id + 1] as usize];
                    let near = |&&b: &&u32| is_neighbor(problem, a, b as usize);
                    found.extend(members.iter().filter(near));
                }
            }
        }
    }
    neighbors
}

fn is_neighbor(problem: &Problem, a: usize, b: usize) -> bool {
    let position = &problem.particles.position;
    let apart = problem.domain.nearest_image(position[a] - position[b]);
    a != b && apart.length() < problem.kernel.cutoff()
}

fn grid_of(problem: &Problem) -> CellLayout {
    CellLayout::of(problem)
}

fn found_neighbors(problem: &Problem, precision: Precision) -> Vec<Vec<u32>> {
    let backend = GpuBackend::new(problem, 1.0, device(), precision).expect("backend");
    let rows = backend.neighbors().expect("neighbours");
    rows.iter().map(|row| row.iter().map(|&(b, _)| b).collect()).collect()
}

/// Scenes with empty cells, with all particles in one cell, in every dimension, and with periodic
/// axes of one, two and three cells.
fn scenes() -> Vec<Problem> {
    let mut scenes = Vec::new();
    for count in [0, 1, 63, 64, 65, 700] {
        for cells in [[8, 0, 0], [8, 4, 0], [4, 4, 2]] {
            scenes.push(random_scene(cells, [false; 3], count, 1.0));
            scenes.push(random_scene(cells, [false; 3], count, 0.5));
        }
        for n in 1..=3 {
            scenes.push(random_scene([n, 0, 0], [true, false, false], count, 1.0));
            scenes.push(random_scene([4, n, 0], [false, true, false], count, 1.0));
            scenes.push(random_scene([n, 4, n], [true, false, true], count, 1.0));
            scenes.push(random_scene([n, n, n], [true; 3], count, 1.0));
        }
    }
    scenes.push(random_scene([1, 1, 1], [false; 3], 1000, 1.0));
    scenes
}

#[test]
fn order_and_cell_starts_equal_a_plain_sort() {
    let many = random_scene([32, 32, 32], [false; 3], 100_000, 1.0);
    for problem in scenes().into_iter().chain([many]) {
        let grid = grid_of(&problem);
        let backend = GpuBackend::new(&problem, 1.0, device(), Precision::F32).expect("backend");
        let positions = &problem.particles.position;
        let choices = backend.choices().expect("a list");
        let sorted = Sorted::new(device(), choices, &grid, positions, 1.0, 1.0).expect("sorted");
        let (order, starts) = expected_order(&grid, positions);
        let cell_starts = sorted.cell_starts(device()).expect("cell starts");
        assert_eq!(first_difference(sorted.order(), &order), None);
        assert_eq!(first_difference(&cell_starts, &starts), None);
    }
}

#[test]
fn neighbors_equal_a_plain_search_in_the_same_order() {
    for problem in scenes() {
        let expected = expected_neighbors(&problem, &grid_of(&problem));
        for precision in Precision::ALL {
            let found = found_neighbors(&problem, precision);
            assert_eq!(first_difference(&found, &expected), None, "{:?}", problem.domain);
        }
    }
}

#[test]
fn neighbors_of_many_particles_equal_a_plain_search() {
    let problem = random_scene([32, 32, 32], [true, false, true], 100_000, 1.0);
    let expected = expected_neighbors(&problem, &grid_of(&problem));
    let found = found_neighbors(&problem, Precision::F32);
    assert_eq!(first_difference(&found, &expected), None);
}

#[test]
fn the_plain_search_equals_brute_force() {
    for problem in scenes() {
        let count = problem.particles.len();
        for (a, found) in expected_neighbors(&problem, &grid_of(&problem)).iter().enumerate() {
            let near: BTreeSet<u32> =
                (0..count as u32).filter(|&b| is_neighbor(&problem, a, b as usize)).collect();
            assert_eq!(found.len(), near.len());
            assert_eq!(found.iter().copied().collect::<BTreeSet<_>>(), near);
        }
    }
}

#[test]
fn checks_notice_one_moved_particle() {
    let problem = random_scene([4, 4, 2], [false; 3], 700, 1.0);
    let mut moved = problem.clone();
    moved.particles.position[350].x = 4.0 - moved.particles.position[350].x - FINEST;
    let grid = grid_of(&problem);
    let (order, starts) = expected_order(&grid, &moved.particles.position);
    let backend = GpuBackend::new(&problem, 1.0, device(), Precision::F32).expect("backend");
    let positions = &problem.particles.position;
    let sorted =
        Sorted::new(device(), backend.choices().expect("a list"), &grid, positions, 1.0, 1.0)
            .expect("sorted");
    let cell_starts = sorted.cell_starts(device()).expect("cell starts");
    assert!(first_difference(sorted.order(), &order).is_some());
    assert!(first_difference(&cell_starts, &starts).is_some());
    let expected = expected_neighbors(&moved, &grid);
    let found = found_neighbors(&problem, Precision::F32);
    assert!(first_difference(&found, &expected).is_some());
}
