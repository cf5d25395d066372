use glam::DVec3;

use super::*;
use crate::model::Domain;
use crate::model::scenes::Noise;

/// All pairs nearer than the cutoff, by looking at every pair: the oracle.
fn brute_force(domain: &Domain, position: &[DVec3], cutoff: f64) -> Vec<Vec<usize>> {
    let near = |a: usize, b: usize| {
        a != b && domain.nearest_image(position[b] - position[a]).length() < cutoff
    };
    (0..position.len()).map(|a| (0..position.len()).filter(|&b| near(a, b)).collect()).collect()
}

/// The grid's neighbours in particle indices, sorted; panics if one comes twice.
fn by_grid(grid: &CellGrid<'_>, cutoff: f64) -> Vec<Vec<usize>> {
    let mut lists = vec![Vec::new(); grid.order().len()];
    let mut scratch = Scratch::default();
    for cell in 0..grid.layout().count() {
        grid.for_each_row(cell, cutoff, &mut scratch, |rank, neighbors| {
            let list = &mut lists[grid.order()[rank] as usize];
            list.extend(neighbors.iter().map(|n| grid.order()[n.rank as usize] as usize));
            list.sort_unstable();
            let once = list.windows(2).all(|pair| pair[0] < pair[1]);
            assert!(once, "a neighbour is listed twice: {list:?}");
        });
    }
    lists
}

fn scatter(n: usize, dimension: usize, extent: DVec3, seed: u64) -> Vec<DVec3> {
    let mut noise = Noise(seed);
    let mut point = || {
        let mut x = DVec3::ZERO;
        (0..dimension).for_each(|axis| x[axis] = extent[axis] * noise.next());
        x
    };
    (0..n).map(|_| point()).collect()
}

fn domain(dimension: usize, extent: DVec3, periodic: [bool; 3]) -> Domain {
    let mut max = DVec3::ZERO;
    (0..dimension).for_each(|axis| max[axis] = extent[axis]);
    Domain { min: DVec3::ZERO, max, periodic }
}

#[test]
fn hand_made_lists_in_one_dimension() {
    let position: Vec<DVec3> = [0.1, 0.9, 1.6, 3.9].map(|x| DVec3::new(x, 0.0, 0.0)).to_vec();
    let open = domain(1, DVec3::new(4.0, 0.0, 0.0), [false; 3]);
    let closed = Domain { periodic: [true, false, false], ..open };
    let lists = |domain: &Domain| {
        by_grid(&CellGrid::new(CellLayout::new(domain, 1, 1.0, 4), &position), 1.0)
    };
    assert_eq!(lists(&open), [vec![1], vec![0, 2], vec![1], vec![]]);
    assert_eq!(lists(&closed), [vec![1, 3], vec![0, 2], vec![1], vec![0]]);
}

#[test]
fn equals_brute_force_with_one_two_three_and_more_cells_an_axis() {
    let cutoff = 1.0;
    for dimension in 1..=3 {
        for cells in [[1.2, 2.3, 3.4], [2.0, 1.0, 5.5], [3.0, 3.0, 1.7], [2.9, 7.1, 2.2]] {
            for mask in 0..1_u8 << dimension {
                let periodic = std::array::from_fn(|axis| mask >> axis & 1 == 1);
                let region = domain(dimension, DVec3::from_array(cells), periodic);
                let position = scatter(120, dimension, region.extent(), u64::from(mask) + 7);
                let layout = CellLayout::new(&region, dimension, cutoff, position.len());
                let grid = CellGrid::new(layout, &position);
                let expected = brute_force(&region, &position, cutoff);
                assert_eq!(
                    by_grid(&grid, cutoff),
                    expected,
                    "{dimension}-D {cells:?} {periodic:?}"
                );
            }
        }
    }
}

#[test]
fn the_comparison_notices_a_moved_particle() {
    let region = domain(3, DVec3::splat(3.0), [true; 3]);
    let mut position = scatter(100, 3, region.extent(), 3);
    let expected = brute_force(&region, &position, 1.0);
    position[50] = region.max - position[50];
    let grid = CellGrid::new(CellLayout::new(&region, 3, 1.0, 100), &position);
    assert_ne!(by_grid(&grid, 1.0), expected);
}

#[test]
fn the_sort_is_a_stable_permutation() {
    let region = domain(2, DVec3::splat(4.0), [false; 3]);
    let position = scatter(1000, 2, region.extent(), 11);
    let grid = CellGrid::new(CellLayout::new(&region, 2, 1.0, 1000), &position);
    let mut seen = grid.order().to_vec();
    seen.sort_unstable();
    assert!(seen.iter().enumerate().all(|(i, &p)| i as u32 == p));
    for cell in 0..grid.layout().count() {
        let members = &grid.order()[grid.ranks(cell)];
        assert!(members.windows(2).all(|pair| pair[0] < pair[1]));
        let inside =
            |&p: &u32| grid.layout().index(grid.layout().coordinates(position[p as usize])) == cell;
        assert!(members.iter().all(inside));
    }
}

#[test]
fn a_sparse_scene_does_not_ask_for_more_cells_than_it_can_use() {
    let region = domain(3, DVec3::splat(1e6), [false; 3]);
    assert!(CellLayout::new(&region, 3, 1.0, 1000).count() <= 2000);
    let none = CellGrid::new(CellLayout::new(&region, 3, 1.0, 0), &[]);
    assert!(none.order().is_empty());
}
