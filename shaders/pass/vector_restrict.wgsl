// The sum of V x over the members of each aggregate, one a workgroup.

var<workgroup> partial: array<real, WORKGROUP_SIZE>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn vector_restrict(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let aggregate = group.y * groups.x + group.x;
    let known = aggregate < arrayLength(&sums);
    // What a workgroup does must not depend on what it reads.
    let row = min(aggregate, arrayLength(&sums) - 1u);
    var sum = real(0.0);
    for (var k = start[row] + lane; k < start[row + 1u]; k += WORKGROUP_SIZE) {
        sum += capacity_share(place[k]) * collapsed(one[place[k]]);
    }
    partial[lane] = sum;
    for (var reach = WORKGROUP_SIZE / 2u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if lane < reach {
            partial[lane] += partial[lane + reach];
        }
    }
    if lane == 0u && known {
        sums[aggregate] = partial[0];
    }
}
