use diffusph::gpu::{SCAN_BLOCK, Scan};

use crate::support::{Random, device, first_difference};

fn exclusive_sums(values: &[u32]) -> Vec<u32> {
    let mut sum = 0_u32;
    let mut before = |&value: &u32| {
        let sums = sum;
        sum = sum.wrapping_add(value);
        sums
    };
    values.iter().map(&mut before).collect()
}

fn scanned(values: &[u32]) -> Vec<u32> {
    let buffer = device().storage_with("values", bytemuck::cast_slice(values)).expect("buffer");
    let scan = Scan::new(device(), &buffer).expect("scan");
    device().submit(scan.passes()).expect("submission");
    bytemuck::pod_collect_to_vec(&device().read(&buffer).expect("values"))
}

#[test]
fn scan_equals_running_sums_over_several_levels() {
    let block = SCAN_BLOCK as usize;
    let mut random = Random(1);
    for count in [0, 1, 2, 63, block - 1, block, block + 1, 100_000, block * block + 5] {
        let values: Vec<u32> = (0..count).map(|_| (random.next() % 1000) as u32).collect();
        let expected = exclusive_sums(&values);
        let sums = scanned(&values);
        assert_eq!(first_difference(&sums, &expected), None, "{count} values");
    }
}

/// Adding the sums of blocks back takes one invocation an element, in workgroups of 256: a dispatch
/// along one dimension would end at element 65 535 x 256, and the elements past it would keep the
/// sums of their own block.
#[test]
fn a_dispatch_past_65535_workgroups_reaches_every_element() {
    let count = 65_536 * 256 + 100;
    let sums = scanned(&vec![1; count]);
    assert_eq!(sums.len(), count);
    assert_eq!((0..).zip(&sums).find(|(expected, sum)| expected != *sum), None);
}

#[test]
fn scan_check_notices_one_wrong_value() {
    let values = vec![1; 5000];
    let mut wrong = values.clone();
    wrong[3333] = 2;
    let difference = first_difference(&scanned(&wrong), &exclusive_sums(&values));
    assert_eq!(difference, Some(3334));
}
