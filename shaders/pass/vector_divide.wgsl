// Divides each element of a vector by a shift and a multiple of the diagonal. What is 0 stays 0, as
// held particles have to.

@compute @workgroup_size(WORKGROUP_SIZE)
fn vector_divide(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&after) {
        let by = factors.share + factors.scale * collapsed(diagonal[i]);
        after[i] = select(before[i] / by, exactly(real(0.0)), collapsed(before[i]) == 0.0);
    }
}
