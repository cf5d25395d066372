// The largest magnitude among ITEMS elements an invocation, for each workgroup, and 1 if one of them is
// not finite.

var<workgroup> partial: array<vec2<real>, WORKGROUP_SIZE>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn vector_largest(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let workgroup = group.y * groups.x + group.x;
    let first = workgroup * WORKGROUP_SIZE * ITEMS + lane;
    let end = min((workgroup + 1u) * WORKGROUP_SIZE * ITEMS, arrayLength(&one));
    var found = vec2<real>(real(0.0));
    for (var i = first; i < end; i += WORKGROUP_SIZE) {
        let value = collapsed(one[i]);
        if is_finite(value) {
            found.x = max(found.x, abs(value));
        } else {
            found.y = real(1.0);
        }
    }
    partial[lane] = found;
    for (var reach = WORKGROUP_SIZE / 2u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if lane < reach {
            partial[lane] = max(partial[lane], partial[lane + reach]);
        }
    }
    if lane == 0u && workgroup < arrayLength(&sums) {
        sums[workgroup] = vec4<real>(partial[0], real(0.0), real(0.0));
    }
}
