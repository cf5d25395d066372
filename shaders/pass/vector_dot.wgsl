// Partial sums of V x y, one a workgroup, over ITEMS elements an invocation. Values are divided by the
// largest of the workgroup first, so that no product leaves the range of the type: a partial sum is
// in units of the volume that ratios are to and of both largest values, which come with it.

var<workgroup> partial: array<vec2<real>, WORKGROUP_SIZE>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn vector_dot(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let workgroup = group.y * groups.x + group.x;
    let first = workgroup * WORKGROUP_SIZE * ITEMS + lane;
    let end = min((workgroup + 1u) * WORKGROUP_SIZE * ITEMS, arrayLength(&one));
    var size = vec2<real>(LEAST);
    for (var i = first; i < end; i += WORKGROUP_SIZE) {
        size = max(size, abs(vec2<real>(collapsed(one[i]), collapsed(other[i]))));
    }
    partial[lane] = size;
    for (var reach = WORKGROUP_SIZE / 2u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if lane < reach {
            partial[lane] = max(partial[lane], partial[lane + reach]);
        }
    }
    workgroupBarrier();
    size = partial[0];
    workgroupBarrier();
    var sum = real(0.0);
    for (var i = first; i < end; i += WORKGROUP_SIZE) {
        sum += capacity_share(i) * ((collapsed(one[i]) / size.x) * (collapsed(other[i]) / size.y));
    }
    partial[lane] = vec2<real>(sum);
    for (var reach = WORKGROUP_SIZE / 2u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if lane < reach {
            partial[lane] += partial[lane + reach];
        }
    }
    if lane == 0u && workgroup < arrayLength(&sums) {
        sums[workgroup] = vec4<real>(partial[0].x, size.x, size.y, real(0.0));
    }
}
