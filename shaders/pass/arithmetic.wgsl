// Eight independent chains of x -> factor x + addend an invocation: nothing but arithmetic. Four
// links a round; how many rounds comes from a buffer, so that nothing is computed at compile time.

@compute @workgroup_size(WORKGROUP_SIZE)
fn arithmetic(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i >= arrayLength(&ends) {
        return;
    }
    let factor = vec4<real>(chain.factor);
    let addend = vec4<real>(chain.addend);
    var a = starts[i];
    var b = a + addend;
    for (var round = 0u; round < chain.rounds; round++) {
        a = fma(a, factor, addend);
        b = fma(b, factor, addend);
        a = fma(a, factor, addend);
        b = fma(b, factor, addend);
        a = fma(a, factor, addend);
        b = fma(b, factor, addend);
        a = fma(a, factor, addend);
        b = fma(b, factor, addend);
    }
    ends[i] = a + b;
}
