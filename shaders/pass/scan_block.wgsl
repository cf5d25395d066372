// Exclusive prefix sum inside each block of WORKGROUP_SIZE * SCAN_ITEMS values, and each block's sum
// (Hillis and Steele 1986, Commun. ACM 29, 1170, over the sums that invocations form first).

var<workgroup> partial: array<u32, WORKGROUP_SIZE>;

// Turns partial into its inclusive prefix sums.
fn scan_partial(lane: u32) {
    for (var reach = 1u; reach < WORKGROUP_SIZE; reach *= 2u) {
        workgroupBarrier();
        var left = 0u;
        if lane >= reach {
            left = partial[lane - reach];
        }
        workgroupBarrier();
        partial[lane] += left;
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn scan_block(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let thread = flat_index(group, groups, lane);
    let first = thread * SCAN_ITEMS;
    let end = min(first + SCAN_ITEMS, arrayLength(&values));
    var own = 0u;
    for (var i = first; i < end; i++) {
        own += values[i];
    }
    partial[lane] = own;
    scan_partial(lane);
    var before = partial[lane] - own;
    for (var i = first; i < end; i++) {
        let value = values[i];
        values[i] = before;
        before += value;
    }
    let block = thread / WORKGROUP_SIZE;
    if lane == WORKGROUP_SIZE - 1u && block < arrayLength(&sums) {
        sums[block] = partial[lane];
    }
}
