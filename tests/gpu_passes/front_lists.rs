use diffusph::gpu::Constant;
use diffusph::solver::Precision;
use diffusph::solver::gpu::TILE;
use diffusph::solver::gpu::curve_passes::{CurveKind, CurvePasses};
use diffusph::solver::gpu::passes::STEP_SIZE;

use crate::support::device;

/// Of each segment of a curve where it begins, the potential there, and how that rises; it melts from 400 to 600.
const CURVE: [[f32; 8]; 3] = [
    [300.0, 0.0, 300.0, 0.0, 1.0, 0.0, 0.0, 0.0],
    [400.0, 0.0, 400.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [600.0, 0.0, 400.0, 0.0, 1.0, 0.0, 0.0, 0.0],
];

/// What a list begins with after enthalpies have been looked through twice, of which workgroups go through `at_once`
/// tiles, and not more than `most` are along an axis; and the tiles in it, ascending.
fn listed(enthalpies: &[f32], at_once: u32, most: u32) -> ([u32; 4], Vec<u32>) {
    let kind = CurveKind::One;
    let mut source =
        CurvePasses { precision: Precision::F32, workgroup_size: 64, kind }.find_fronts();
    for (name, constant) in &mut source.constants {
        match *name {
            "TILES_OF_WORKGROUP" => *constant = Constant::Count(at_once),
            "MOST_WORKGROUPS" => *constant = Constant::Count(most),
            _ => {}
        }
    }
    let step_size = STEP_SIZE.contents(source.real, [0], [1.0]);
    let tiles = vec![0_u32; enthalpies.len().div_ceil(TILE)];
    let mut list = vec![1, 1, 1, 0];
    list.resize(list.len() + tiles.len(), 7_777_777);
    let buffer = |name, contents| device().storage_with(name, contents).expect("a buffer");
    let step_size = device().block("step size", &step_size).expect("a block");
    let curve = buffer("curve", bytemuck::cast_slice(CURVE.as_flattened()));
    let content = buffer("content", bytemuck::cast_slice(enthalpies));
    let tiles = buffer("tiles", bytemuck::cast_slice(&tiles));
    let list = buffer("list", bytemuck::cast_slice(&list));
    let buffers = [&step_size, &curve, &content, &tiles, &list];
    let pass = device().pass(&source, &buffers, enthalpies.len() as u64).expect("a pass");
    device().submit([&pass, &pass]).expect("submission");
    let list: Vec<u32> = bytemuck::pod_collect_to_vec(&device().read(&list).expect("values"));
    let (head, rest) = list.split_first_chunk().expect("more than a head");
    let mut tiles = rest[..head[3] as usize].to_vec();
    tiles.sort_unstable();
    (*head, tiles)
}

/// As many enthalpies that melt as `melts` says, one of each tile.
fn melting(count: usize, melts: impl Fn(usize) -> bool) -> Vec<f32> {
    let enthalpy = |place: usize| match place.is_multiple_of(TILE) && melts(place / TILE) {
        true => 500.0,
        // The ends of melting do not melt.
        false => [350.0, 400.0, 600.0, 700.0][place % 4],
    };
    (0..count).map(enthalpy).collect()
}

#[test]
fn a_list_has_each_tile_that_melts_once() {
    let (head, tiles) = listed(&melting(5001, |tile| tile % 3 == 1), 32, 65_535);
    let expected: Vec<u32> = (1..2501).step_by(3).collect();
    assert_eq!(tiles, expected);
    assert_eq!(head, [expected.len().div_ceil(32) as u32, 1, 1, expected.len() as u32]);
    assert_eq!(listed(&melting(5001, |_| false), 32, 65_535), ([1, 1, 1, 0], vec![]));
}

/// Where more go through a list than there are along an axis, they are in rows.
#[test]
fn a_list_has_a_workgroup_for_every_tile() {
    for count in [1, 3, 4, 5, 39, 40, 41, 44, 45, 80, 81, 500] {
        let ([x, y, z, length], _) = listed(&melting(TILE * count, |_| true), 4, 10);
        assert_eq!((length, z), (count as u32, 1), "{count} tiles");
        let workgroups = length.div_ceil(4);
        assert_eq!((x, y), (workgroups.min(10), workgroups.div_ceil(10)), "{count} tiles");
    }
}
